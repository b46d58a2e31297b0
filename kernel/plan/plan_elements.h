// Elements of a plan, and what they read: coordinates of joints, shapes, profiles, laws, the air. A kind is a struct
// and a list in PlanElementLists.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernel/environment/environment.h"
#include "kernel/geometry/compiled_shape.h"
#include "kernel/model/one_sided_law.h"
#include "kernel/plan/lanes.h"
#include "kernel/plan/list_kinds.h"
#include "kernel/plan/plan_laws.h"
#include "unlatch/model.h"
#include "unlatch/readings.h"

namespace unlatch {

// A spring that is integrated implicitly, see kernel/elements/compliance.h.
struct PlanCompliant {
  std::int32_t spring;              // into PlanData::joint_springs
  NumberPlace pivot, acceleration;  // what it adds to its freedom's pivot, and that freedom's acceleration
  double side;                      // of the joint's child
};

// A displacement or rotation of a joint that an element, guard or sensor reads.
struct PlanCoordinate {
  std::int32_t joint, row;
  // of a rotation: its initial value, and the two axes of the rotation frame across its own, in each body's axes
  double initial = 0;
  Vec3 across_base[2]{}, across_follower[2]{};
};

struct PlanProfile {
  Profile::Kind kind;
  double value, initial, final, tau;
  std::int32_t first, count;  // kTable: into PlanData::knots; kHarmonic: into PlanData::harmonics
};

struct PlanLoad {
  std::int32_t body, element, profile, channel;
  bool world;                // it keeps its direction in the world, else in the body
  bool apart;                // each stage adds it by itself: in the world's axes, or sized by a law
  Vec3 point;                // of a force in the world, body axes
  Spatial wrench;            // of size 1, in its axes; in the body at the origin, in the world at the point
  double length;             // of the direction
  double consumption;        // kg per N s
  std::int32_t varying;      // into PlanData::varying: what burns it
  std::int32_t law = kNone;  // into PlanLaws::list: its size, instead of `profile`
};

struct PlanPointSpring {
  std::int32_t base, follower, element;
  bool push_only;
  Vec3 point_base, point_follower;
  double stiffness, damping, free_length;
};

struct PlanJointSpring {
  std::int32_t joint, axis, element;
  std::int32_t coordinate;  // into PlanData::coordinates
  double effort, stiffness, damping, rest;
  std::int32_t compliant;  // into PlanData::compliant, kNone if it is integrated explicitly
};

struct PlanPlaneTorsion {
  std::int32_t base, follower, element;
  Vec3 normal_base, axis_follower;
  double stiffness, damping;
};

// Shapes of a body, see Surface in unlatch/model/elements.h.
struct PlanShapes {
  std::int32_t body;
  std::int32_t first, count;  // into PlanData::shape_parts
  geometry::GroupNumbers group;
  // Of the body that carries them, held by nothing: 1/kg, of a flexible body with the mobility of its modes there; 0
  // for the ground. About its origin, body axes, 1/(kg m²).
  double inverse_mass = 0;
  Mat3 inverse_inertia{};
};

// A contact, see kernel/elements/kinds/contact/contact.h.
struct PlanContact {
  std::int32_t base, follower, element;  // into PlanData::shapes; into State::elements
  std::int32_t first_pair, pairs;        // into PlanData::contact_pairs
  std::int32_t auxiliary;                // into State::auxiliary: ContactTotals
  bool hertzian;                         // n = 1.5, otherwise 1
  double stiffness, damping, friction, slip_speed;
  bool rigid = false;  // see kernel/elements/kinds/contact/rigid_row.h: of the numbers above none counts
  double restitution = 0, settle = 0;  // of a rigid one; s
};
struct ContactPair {
  std::int32_t contact, base_shape, follower_shape;  // into PlanData::contacts; into the groups' shapes
  bool closed;                                       // at the start
};

// A force on one side of a limit, see kernel/elements/kinds/one_sided/one_sided.h.
struct PlanOneSided {
  std::int32_t number, element;                          // its own place in PlanData::one_sided
  std::int32_t joint, axis, coordinate, base, follower;  // joint, coordinate: kNone between two points
  double sign, limit;
  bool guided;
  Vec3 point_base, point_follower, guide;
  OneSidedNumbers law;
  std::int32_t first, count;  // its table, into PlanData::travels and travel_forces
  std::int64_t engaged;       // at the start
  std::int32_t drum = kNone;  // into PlanData::drums and State::bearings
};

struct PlanFriction {
  std::int32_t joint, axis, element, coordinate;
  double coefficient, radius, speed;  // radius: 1 along an axis
};

struct PlanAeroTerm {
  AeroTerm::Of of;
  std::int32_t rate, law;
  double value;
};
struct PlanAerodynamics {
  std::int32_t body, element;
  std::int32_t number;        // in PlanData::aerodynamics
  std::int32_t first, count;  // into PlanData::aero_terms
  double area;
  Vec3 lengths, point;
};

struct Knot {
  double time, value;
};

// Uniform and central gravity, see Gravity in unlatch/model.h.
struct GravityField {
  Vec3 uniform{};
  double mu = 0;
  Vec3 centre{};
};

// In PlanLists.
template <template <class> class List>
struct PlanElementLists {
  List<PlanCoordinate> coordinates;  // that are read, or their rates
  List<PlanLoad> loads;
  List<std::int32_t> external_loads;  // of these, those that stand apart or burn something
  List<PlanPointSpring> point_springs;
  List<PlanJointSpring> joint_springs;
  List<PlanCompliant> compliant;
  List<RowSet> compliant_axes;  // per joint: axes with implicit springs
  List<PlanPlaneTorsion> plane_torsions;
  List<PlanShapes> shapes;
  List<geometry::ShapeNumbers> shape_parts;     // those of one of `shapes` together
  List<Vec3> hull_points;                       // of hulls
  List<geometry::ProfilePoint> profile_points;  // of hollow shapes
  List<PlanContact> contacts;
  List<ContactPair> contact_pairs;  // those of one contact together
  List<PlanOneSided> one_sided;
  List<CordDrum> drums;  // of cords, in the model's order
  List<double> travels, travel_forces;
  List<PlanFriction> frictions;
  List<PlanAerodynamics> aerodynamics;
  List<PlanAeroTerm> aero_terms;
  List<AirLayer> air_layers;  // of the standard atmosphere
  List<AirKnot> air_knots;    // of the atmosphere
  List<WindKnot> wind_knots;  // of the wind
  List<double> air_corners;   // altitudes where the air or the wind has a corner, rising, m; none without aerodynamics
  List<PlanProfile> profiles;
  List<Knot> knots;
  List<Profile::Harmonic> harmonics;
  PlanLawLists<List> laws;
  List<double> element_scales;  // initial switch scale per element: 0 or 1

  // Calls use(list…) with each list: that of one name of all `lists`. A new list goes here as well.
  template <class Use, class... Lists>
  static constexpr void for_each(const Use& use, Lists&... lists) {
    use(lists.coordinates...);
    use(lists.loads...);
    use(lists.external_loads...);
    use(lists.point_springs...);
    use(lists.joint_springs...);
    use(lists.compliant...);
    use(lists.compliant_axes...);
    use(lists.plane_torsions...);
    use(lists.shapes...);
    use(lists.shape_parts...);
    use(lists.hull_points...);
    use(lists.profile_points...);
    use(lists.contacts...);
    use(lists.contact_pairs...);
    use(lists.one_sided...);
    use(lists.drums...);
    use(lists.travels...);
    use(lists.travel_forces...);
    use(lists.frictions...);
    use(lists.aerodynamics...);
    use(lists.aero_terms...);
    use(lists.air_layers...);
    use(lists.air_knots...);
    use(lists.wind_knots...);
    use(lists.air_corners...);
    use(lists.profiles...);
    use(lists.knots...);
    use(lists.harmonics...);
    PlanLawLists<FixedList>::for_each(use, lists.laws...);
    use(lists.element_scales...);
  }
};

}  // namespace unlatch
