// Readings of a state that are neither in it nor in the workspace: forces and strokes of elements, modal rates; and
// elements whatever their kind: what they act on, what their readings mean, how they start. For outputs and reports.
// The step computes each force by the same formula (kernel/elements/kinds).
#pragma once

#include <span>
#include <vector>

#include "unlatch/model.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/step_data.h"
#include "unlatch/workspace.h"

namespace unlatch {

// What a kind of element says about one of them. Bodies and joints that do not exist are reported as the ground and
// kNone.
struct ElementTraits {
  const char* kind = "";       // as scenarios call it: "joint_spring"
  int base = kGround;          // body that it acts on; of a load the ground
  int follower = kGround;      // the other body
  int joint = kNone;           // that it sits in
  int axis = kX;               // Row of that joint
  const char* note = "";       // for drawings: "pushes"
  bool on = true;              // at the start
  bool angular = false;        // its coordinate is an angle, rad, and its effort a moment, N m
  bool has_coordinate = true;  // ElementReading::length and rate mean something
  bool has_points = false;     // the coordinate is the length of a line between two points
  bool has_stroke = false;     // ElementReading::stroke means something
  bool has_drum = false;       // and wound, on_drum
  bool is_contact = false;     // its readings are those of a contact (unlatch/contacts.h)
};

// `element`: in the one numbering of all elements (Model::element_name()). Throws std::out_of_range.
ElementTraits describe_element(const Model& model, int element);

// The bodies that an element acts on, without the ground.
std::vector<int> list_element_bodies(const Model& model, int element);

// A spring, pusher, stop, cord or torsion spring at the initial poses, all bodies at rest, switched on.
struct ElementStart {
  const char* kind = nullptr;  // "spring", "pusher", "joint spring", "torsion", "stop", "cord"; null: it stores nothing
  double length = 0;           // m or rad: between the points, or the joint's coordinate
  double force = 0;            // N or N m on the follower along the length
  double energy = 0;           // J stored
  double stroke = 0;           // m or rad to the place without force
};

// `model`: with its markers placed (place_markers()).
ElementStart calc_element_start(const Model& model, int element);

// Length and force of a spring between two points.
struct SpringReading {
  double length = 0;  // between its ends, m
  double force = 0;   // along the line on the follower, away from the base: a push is positive; N
  double scale = 0;   // of its switch: 0 while it is off
};

// Size of a load (its number in the model) at the state's tick: profile · switch scale · command, N or N m per length
// of its direction. `workspace`: with the outputs of this state.
double calc_load_size(const Plan& plan, const Inputs& inputs, const State& state, const Workspace& workspace,
                      int load) noexcept;

// Reading of a point spring (its number in the model) at the state's tick.
SpringReading calc_point_spring(const Plan& plan, const State& state, int spring) noexcept;

// Force of a spring between two points. World axes.
struct PointSpringForce {
  Vec3 r_base, r_follower;  // its ends from the bodies' origins, m
  Vec3 direction{0, 0, 0};  // of the line from base to follower, unit; 0 for ends that coincide
  double length = 0;        // between its ends, m
  double rate = 0;          // of the length, m/s
  double elastic = 0;       // part of `size` by the law of its stiffness, N
  double viscous = 0;       // the rest: of its damping, and what a pusher loses that may not pull, N
  double size = 0;          // along `direction` on the follower, N
  bool acts = false;        // false for a pusher at its free length, and for ends that coincide
};

// Force of a spring between bodies with these poses and velocities (for the ground: at rest at W); `scale`: of its
// switch, 0 to 1.
PointSpringForce calc_point_spring(const PointSpring& spring, const BodyState& base, const BodyState& follower,
                                   double scale) noexcept;

// A plane torsion, (4.17) with φ = atan2(n_i·n_j, |n_i × n_j|), positive where n_j stands out of the plane along n_i. A
// turn of the follower about e = n_i × n_j / |n_i × n_j| carries n_j away from n_i, dφ/dt = −e·w_rel, so the restoring
// moment is +kφ along e. World axes.
struct PlaneTorsionForce {
  Vec3 axis{0, 0, 0};          // e
  double angle = 0, rate = 0;  // φ, rad; dφ/dt, rad/s
  double size = 0;             // moment about e on the follower, N m
  bool acts = false;           // false where the axis stands on the plane: no direction is nearer to it than another
};

// Moment of a plane torsion between bodies with these poses and velocities, as of a point spring.
PlaneTorsionForce calc_plane_torsion(const PlaneTorsion& torsion, const BodyState& base, const BodyState& follower,
                                     double scale) noexcept;

// Effort of a joint spring on the follower, N or N m, at a coordinate x of its joint, m or rad, and its rate.
template <class Spring>
inline double calc_joint_spring(const Spring& spring, double x, double rate, double scale) noexcept {
  return (spring.effort - spring.stiffness * (x - spring.rest) - spring.damping * rate) * scale;
}

// An element at one instant.
struct ElementReading {
  // On the follower, N or N m. Of a load: its size along its direction; of a point spring: a push is positive; of a
  // joint spring and of friction: along or about its axis; of a plane torsion: the moment that turns its axis back is
  // positive where its angle is; of a one-sided force: along its coordinate.
  double force = 0;
  double length = 0;  // point spring: between its ends, m; joint spring and friction: its joint's coordinate, m or rad;
                      // plane torsion: its angle, rad; one-sided force: its coordinate, m or rad; load: 0
  double rate = 0;    // of `length`, per s
  double scale = 0;   // of its switch: 0 while it is off
  double stroke = 0;  // that is left: point spring: its free length less its length, m; one-sided force: its depth, m
                      // or rad
  double wound = 0;   // of a cord: angle on its drum, rad
  double on_drum = 0;  // and length, m
};

// Reading of an element (its number in State::elements) at the state that the outputs in the workspace are of: the one
// that the latest step(), Bundle::step() or update_outputs() left.
ElementReading calc_element(const Plan& plan, const Workspace& workspace, int element) noexcept;

// Coordinate and force of a one-sided force.
struct OneSidedReading {
  double coordinate = 0;  // m or rad
  double depth = 0;       // to its limit, m or rad: negative beyond its reach
  double depth_rate = 0;  // m/s or rad/s
  double force = 0;       // N or N m, never negative; 0 while it is off or not engaged
  double scale = 0;       // of its switch: 0 while it is off
  double wound = 0;       // of a cord: angle on its drum, rad; 0 if it is straight
  double on_drum = 0;     // and length, m
  double bearing = 0;     // of its end about the drum's axis from the anchor, turns counted, rad
};

// The same of a one-sided force, by its number among the model's.
OneSidedReading calc_one_sided(const Plan& plan, const Workspace& workspace, int number) noexcept;

// The law of a one-sided force alone: its force while it is engaged, N or N m, and what it stores, J, at a depth and
// its rate, m and m/s or rad and rad/s.
double calc_one_sided_force(const OneSided& force, double depth, double depth_rate) noexcept;
double calc_one_sided_energy(const OneSided& force, double depth) noexcept;

// A drum with the anchor of its cord, axes of the body that carries it.
struct CordDrum {
  Vec3 centre;     // on the axis, in the plane of the anchor, from the body's origin, m
  Mat3 axes;       // x through the anchor, y the way in which the cord runs on from there, z the drum's axis
  double radius;   // m
  double bearing;  // of the cord's end about z from the anchor at the start, turns counted, rad
};

// The drum of a cord that has one, as it is at the model's initial poses. `model`: as place_markers() returns it.
CordDrum place_drum(const Model& model, const OneSided& cord);

// Direction and size of a one-sided force between two points. World axes.
struct OneSidedForce {
  Vec3 direction{0, 0, 0};  // along which its coordinate grows; 0 where the line has no length
  double rate = 0;          // of the coordinate, m/s
  double depth = 0;         // to its limit, m: negative beyond its reach
  double depth_rate = 0;    // m/s
  double size = 0;          // along `direction` on the follower, N
};

// The force, while it is engaged, between bodies with these poses and velocities (for the ground: at rest at W), at
// switch scale 1. `limit`: calc_limit(); `drum`: of a cord that has one, else null; `bearing`: of the cord's end, less
// than half a turn from the present one, rad.
OneSidedForce calc_one_sided_force(const OneSided& force, double limit, const CordDrum* drum, double bearing,
                                   const BodyState& base, const BodyState& follower) noexcept;

// Coordinates at the initial poses of a model whose markers are placed, m or rad: of a joint along or about one of its
// rows; of a one-sided force, and its limit.
double calc_start(const Model& model, const Joint& joint, int row);
double calc_start(const Model& model, const OneSided& force);
double calc_limit(const Model& model, const OneSided& force);

// Rates of a flexible body's modal coordinates, kg^0.5 m/s; empty for a rigid one.
std::span<const double> get_modal_rates(const Plan& plan, const State& state, int body) noexcept;

}  // namespace unlatch
