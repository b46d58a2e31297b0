// Elements of a model: what pushes and pulls its bodies. A kind is a struct here and a list in ElementLists.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "unlatch/model/joints.h"
#include "unlatch/model/shapes.h"

namespace unlatch {

// A value over the element's own time s = t − (time it was switched on), or a law.
struct Profile {
  // Shape of a profile.
  enum class Kind { kConstant, kExponential, kTable, kHarmonic, kLaw };
  // One sine of a harmonic profile.
  struct Harmonic {
    double amplitude, frequency, phase;  // amplitude · sin(frequency · s + phase); rad/s, rad
  };
  Kind kind = Kind::kConstant;        // shape
  double value = 1;                   // kConstant
  double initial = 0, final = 0;      // kExponential: final + (initial − final) · exp(−s / tau)
  double tau = 1;                     // s
  std::vector<double> times, values;  // kTable: linear between, constant outside; times strictly increasing
  std::vector<Harmonic> harmonics;    // kHarmonic: the sum
  int law = kNone;                    // kLaw: index of the law
};

// A force or torque on one body: thrust, nozzle, disturbance. Its size is profile · switch scale · channel.
struct Load {
  // Force or torque.
  enum class Kind { kForce, kTorque };
  // Axes of a direction: of the body, or inertial.
  enum class Frame { kBody, kWorld };
  std::string name;                                      // unique among elements
  int body = 0;                                          // index of the body
  Kind kind = Kind::kForce;                              // force or torque
  Frame frame = Frame::kBody;                            // axes of `direction`
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       // forces: where it acts, body axes, m
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // multiplied by the size; need not be a unit vector
  Profile profile;                                       // N or N m
  int channel = kNone;                                   // command channel that multiplies it
  double consumption = 0;                                // kg burnt per N s of a force: 1 / (Isp · g0)
  int tank = kNone;                                      // body with a mass law that burns it; by default `body`
  bool on = true;                                        // at the start
};

// A straight spring and damper between two points: F = −k (l − l0) − c dl/dt along the line, on the follower.
struct PointSpring {
  std::string name;  // unique among elements
  // Indices of the bodies.
  int base = kGround, follower = 0;
  // Ends, base axes and follower axes, m.
  Eigen::Vector3d point_base = Eigen::Vector3d::Zero(), point_follower = Eigen::Vector3d::Zero();
  double stiffness = 0, damping = 0, free_length = 0;  // N/m, N s/m, m
  bool push_only = false;                              // a pusher: no force once l ≥ l0, and never a pull
  bool on = true;                                      // at the start
};

// A spring, damper and motor along one axis of a joint: effort − k (s − rest) − c ds/dt on the follower, where s is the
// displacement along x, y, z of the joint frame (4.14)–(4.16), or the angle about an axis of the rotation frame.
// Torsion drives, elastic latches, (4.15) with the restoring sign.
struct JointSpring {
  std::string name;                                         // unique among elements
  int joint = 0;                                            // index of the joint
  int axis = kRotZ;                                         // Row: kX … kRotZ
  double effort = 0, stiffness = 0, damping = 0, rest = 0;  // N or N m, per m or rad, per m/s or rad/s, m or rad
  bool on = true;                                           // at the start
  std::optional<bool> implicit{};  // integrated implicitly, see THEORY.md, section 5; by default the plan decides
};

// A torsion spring that keeps an axis of the follower in a plane of the base, (4.17) with a signed angle:
// φ = atan2(n_i·n_j, |n_i × n_j|), moment on the follower (k φ + c dφ/dt) (n_i × n_j)/|n_i × n_j|, the opposite on the
// base.
struct PlaneTorsion {
  std::string name;  // unique among elements
  // Indices of the bodies.
  int base = kGround, follower = 0;
  Eigen::Vector3d normal_base = Eigen::Vector3d::UnitZ();    // n_i, unit, base axes
  Eigen::Vector3d axis_follower = Eigen::Vector3d::UnitX();  // n_j, unit, follower axes
  double stiffness = 0, damping = 0;                         // N m/rad, N m s/rad
  bool on = true;                                            // at the start
};

// Cylinder of the base, without ends, on which a cord between two points is wound, without friction and as thin as a
// thread. x is the length of the cord's whole path from its anchor on the cylinder to the follower's point: an arc and
// its tangent, or out of the anchor's plane a helix and its tangent; once it is unwound, the straight line, which winds
// up the other way if it swings on. The force is along the straight part.
struct Drum {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // on its axis, in the plane of the anchor; base axes, m
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   // unit, base axes
  double radius = 0;                                 // m, > 0
  bool left = false;                                 // from its anchor the cord runs left-handed about the axis
  std::optional<double> wound{};  // angle at the start, rad, ≥ 0; by default that of a cord of the length `limit`
};

// A force that acts on one side of a limit of a coordinate x, and in one direction: a pusher within its stroke, a stop
// beyond its place, a cord that is taut. With s = +1 for a force that pushes x up from below the limit, −1 for one that
// pulls it down from above, and the depth δ = s (limit − x), the force on the follower along x is
//
//   s · max(0, F(stroke − δ) + damping dδ/dt + friction (dδ/dt) / sqrt((dδ/dt)² + v_s²))
//
// and on the base the opposite, while it is engaged: from the instant at which δ, and with it the sum in the brackets,
// rises to 0 until the instant at which either falls below 0. Both instants are events of the model
// (complete_events()), so that the force ends exactly there. The law F is a function of the travel u = stroke − δ:
//
//   kLinear  preload − stiffness u
//   kTable   linear between (travels, forces), constant outside
//   kGas     preload (gas_length / (gas_length + u))^exponent: p V^γ constant, V = area · gas_length at u = 0; γ = 1 is
//            isothermal, 1.4 adiabatic air; no pressure from outside
struct OneSided {
  // Kind, for the names of its events.
  enum class Kind { kPusher, kStop, kCord };
  // Force over the travel.
  enum class Law { kLinear, kTable, kGas };
  std::string name;         // unique among elements
  Kind kind = Kind::kStop;  // a pusher's stroke is > 0
  bool pulls = false;       // s = −1
  int joint = kNone;        // x is the displacement or angle of this joint along `axis`; kNone: between two points
  int axis = kX;            // Row
  // Between two points: indices of the bodies, and the ends.
  int base = kGround, follower = 0;
  Eigen::Vector3d point_base = Eigen::Vector3d::Zero();      // base axes, m
  Eigen::Vector3d point_follower = Eigen::Vector3d::Zero();  // follower axes, m
  // x is the length of the line between them. With a guide, an axis of the base (unit, base axes), x is the place of
  // the follower's point along it, and the force acts at that point along the guide, wherever the point is across it.
  std::optional<Eigen::Vector3d> guide{};
  std::optional<Drum> drum{};             // of a cord: it is wound on this, and `point_base` is not read
  std::optional<double> limit{};          // m or rad; by default x at the start + s · stroke
  double stroke = 0;                      // m or rad, ≥ 0
  Law law = Law::kLinear;                 // F
  double preload = 0, stiffness = 0;      // N or N m; N/m or N m/rad; F ≥ 0 over the whole stroke
  double gas_length = 0, exponent = 1.4;  // m or rad, > 0; ≥ 1
  std::vector<double> travels, forces;    // kTable: strictly increasing, ≥ 0; ≥ 0
  double damping = 0, friction = 0;       // N s/m or N m s/rad; N or N m
  double friction_speed = 1e-3;           // v_s, m/s or rad/s, > 0
  bool on = true;                         // at the start
};

// Coulomb friction in a joint along or about a free axis, of the size of the reaction across it:
//
//   −coefficient · r · |R| · v / sqrt(v² + v_s²),   v = r · speed of the axis,   r = 1 along x, y, z, else `radius`
//
// R is the reaction of the point–plane rows that hold, found as in kernel/elements/kinds/friction.h. Regularised: at
// rest it creeps at v / v_s = load / (μ |R|).
struct JointFriction {
  std::string name;        // unique among elements
  int joint = 0;           // index of the joint
  int axis = kX;           // Row that some mode leaves free
  double coefficient = 0;  // ≥ 0
  double radius = 0;       // of a pin or bearing, m; of rotations, > 0
  double speed = 1e-3;     // v_s, m/s, > 0
  bool on = true;          // at the start
};

// A part of a coefficient of Aerodynamics: a number, or the value of a law.
struct AeroTerm {
  // The coefficient that it is a part of: C_X C_Y C_Z C_l C_m C_n C_D.
  enum class Of { kX, kY, kZ, kRoll, kPitch, kYaw, kDrag };
  Of of = Of::kX;    // see above
  int rate = kNone;  // 0, 1, 2: it counts times p, q or r, made plain by their length / (2 V)
  double value = 0;  // without a law
  int law = kNone;   // index of a law
};

// Force and moment of the air on a body. With V the size of the velocity u relative to the air, q = ½ ρ V², the sums C
// of the terms, and everything in body axes (x forwards, y to the right, z down, for bodies that fly forwards),
//
//   force  = q S (C_X, C_Y, C_Z) − q S C_D u / V
//   moment = q S (l_x C_l, l_y C_m, l_z C_n) about `point`, where the force acts
//
// Rates are those relative to the air, which turns with the planet.
struct Aerodynamics {
  std::string name;                                   // unique among elements
  int body = 0;                                       // index of the body
  double area = 0;                                    // S, m², > 0
  Eigen::Vector3d lengths = Eigen::Vector3d::Ones();  // l_x, l_y, l_z, m, > 0
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    // body axes, m
  std::vector<AeroTerm> terms{};                      // in the order of their sums
  bool on = true;                                     // at the start
};

// A named union of shapes that a body carries, without mass: for contacts, and for conditions and sensors of distance.
struct Surface {
  std::string name;                     // unique among surfaces
  int body = kGround;                   // that carries them: rigid, or a marker; kGround: fixed in W
  std::vector<geometry::Shape> shapes;  // at least one, in axes of the body (ground: W), m
};

// Compliant contact of two surfaces. Each pair of their shapes is closed from the instant at which its signed
// distance falls to zero until it rises to zero; with the depth δ = −distance, the rate of δ, and the slip v_t of the
// two materials at the midpoint of the witnesses, follower against base:
//
//   F_n = max(0, k δⁿ (1 + d dδ/dt))        on the follower away from the base, along the witnesses
//   F_t = −μ F_n v_t / √(|v_t|² + v_s²)     on the follower; on the base the opposite, both at that midpoint
//
// Pairs that have no distance (two half-spaces, two hollow shapes) do not touch.
//
// A rigid contact has neither stiffness nor depth: at the touch an impulse reverses the speed of approach times
// `restitution`; a bounce whose flight would be shorter than `settle` does not leave. Then the distance is held by a
// force that pushes, until that falls to zero. One shape of each of its pairs is a sphere, the other convex or a
// half-space, and no body bends (THEORY.md, section 7).
struct Contact {
  std::string name;                           // unique among elements
  int base = 0, follower = 0;                 // indices of surfaces, of two bodies
  double stiffness = 0;                       // k, N/m or N/m^1.5, > 0
  double exponent = 1;                        // n: 1 or 1.5
  double damping = 0;                         // d, s/m, ≥ 0
  std::optional<double> restitution{};        // instead of d: the ratio of the speeds after and before, in (0, 1],
  double speed = 0;                           // m/s, of a blow with this speed, > 0
  double friction = 0;                        // μ, ≥ 0
  double slip_speed = 1e-3;                   // v_s, m/s, > 0
  bool on = true;                             // at the start
  std::vector<std::pair<int, int>> except{};  // pairs of shapes that do not touch: indices in base and follower
  bool rigid = false;                         // see above: of all numbers only restitution, 0 to 1, and settle count
  std::optional<double> settle{};             // of a rigid one, s, > 0; by default half of the step
};

// The elements of a model, kind by kind. They share one numbering: the lists follow each other in this order.
struct ElementLists {
  std::vector<Load> loads;                   // forces and torques
  std::vector<PointSpring> point_springs;    // springs between points
  std::vector<JointSpring> joint_springs;    // springs in joints
  std::vector<PlaneTorsion> plane_torsions;  // torsion springs towards a plane
  std::vector<Contact> contacts;             // between shapes
  std::vector<OneSided> one_sided;           // pushers, stops and cords
  std::vector<JointFriction> frictions;      // Coulomb friction in joints
  std::vector<Aerodynamics> aerodynamics;    // forces of the air

  // Number of elements of all kinds; the name of one of them.
  int element_count() const;
  const std::string& element_name(int element) const;
};

}  // namespace unlatch
