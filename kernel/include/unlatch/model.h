// Model: the physics as the user described it. Plain data, filled by a loader or by hand, checked by validate() and
// never changed after a Plan was compiled from it. SI units and radians throughout; W is the inertial frame. One long
// file, because it is what a user reads: the whole vocabulary in the order of a description.
//
// References (4.x) are equations of Anshakov et al., "Dynamic processes in rocket-space systems", 2003, as corrected in
// kernel/README.md.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "unlatch/environment.h"
#include "unlatch/events.h"
#include "unlatch/law.h"
#include "unlatch/quantity.h"
#include "unlatch/shapes.h"

namespace unlatch {

inline constexpr int kGround = -1;  // index of the inertial frame among bodies
inline constexpr int kNone = -1;    // index of nothing: no channel, no element, …

// Unaligned, so that the model has one layout whether or not the user's own Eigen vectorises.
using Attitude = Eigen::Quaternion<double, Eigen::DontAlign>;

// --- Bodies ---------------------------------------------------------------------------------------------------------

// Law of a body's mass, centre of mass and inertia: linear between the knots, constant beyond them.
struct MassLaw {
  enum class Of { kTime, kBurnt };  // the knots' variable: t, s; or what the body has burnt, kg
  // Mass properties at one value of the variable.
  struct Knot {
    double at, mass;          // s or kg; kg
    Eigen::Vector3d centre;   // of mass, from the body's origin, which is fixed in the structure; body axes, m
    Eigen::Matrix3d inertia;  // about the centre of mass, body axes, kg m²
  };
  Of of = Of::kTime;                               // variable of the knots
  std::vector<Knot> knots;                         // in rising order
  bool jet_damping = false;                        // see kernel/dynamics/varying.h
  Eigen::Vector3d exit = Eigen::Vector3d::Zero();  // where the particles leave, from the body's origin, body axes, m
};

// Small elastic deformations as m modes over the body's frame, whose origin is the undeformed centre of mass. The sums
// are over the body's particles at r with the mode shapes Φ_k, scaled so that Σ m |Φ_k|² = 1.
struct FlexibleBody {
  Eigen::VectorXd frequencies;            // ω_k, rad/s, > 0
  Eigen::VectorXd damping;                // ζ_k, of critical
  Eigen::Matrix3Xd momentum;              // Σ m Φ_k; 0 for modes of a body that nothing holds
  std::vector<Eigen::Matrix3d> first;     // Σ m r Φ_kᵀ
  std::vector<Eigen::Matrix3d> second;    // Σ m Φ_k Φ_lᵀ, at k · m + l
  Eigen::VectorXd initial, initial_rate;  // modal coordinates at the start and their rates, 1/s; empty for 0
};

// A frame without mass that a flexible body carries: what joints, loads and sensors are fixed to.
struct Marker {
  int body = 0;                                        // index of the flexible body
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // undeformed, from the body's origin, body axes, m
  Eigen::Matrix3Xd shape;                              // Φ_k there
  Eigen::Matrix3Xd turn;                               // Ψ_k: small rotation there per unit of the coordinate, rad
};

// A body, rigid unless one of law, flexible and marker is given.
struct Body {
  std::string name;                                   // unique among bodies
  double mass = 0;                                    // kg, > 0
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the centre of mass, body axes, kg m²
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();     // initial position of the centre of mass, m
  Attitude q_WB = Attitude::Identity();               // initial attitude, body to inertial
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();     // initial velocity of the centre of mass, inertial axes, m/s
  Eigen::Vector3d w_WB_B = Eigen::Vector3d::Zero();   // initial angular velocity, body axes, rad/s
  // At most one of these.
  std::optional<MassLaw> law;  // mass and inertia are then those at the start, the origin that of its structure
  std::optional<FlexibleBody> flexible;  // mass and inertia are then the undeformed ones
  std::optional<Marker> marker;          // nothing above is then read: it moves with its flexible body
};

// --- Joints ---------------------------------------------------------------------------------------------------------

// The elementary rows of a joint: three point–plane rows (4.11), which hold the follower's point in the planes through
// the base's point normal to x, y, z of the joint frame; and three rotation rows (4.12) about the rotation frame's
// axes. The order is that of the multipliers.
enum Row : std::uint8_t { kX = 0, kY, kZ, kRotX, kRotY, kRotZ };
inline constexpr int kRows = 6;  // number of rows of a joint
using RowSet = std::uint8_t;     // bit r set: Row r is active
// The set of one row.
constexpr RowSet row_bit(int row) { return static_cast<RowSet>(1u << row); }
// `row` is in `set`.
constexpr bool has_row(RowSet set, int row) { return (set >> row & 1u) != 0; }
inline constexpr RowSet kPointRows = 0b000111;     // x, y, z
inline constexpr RowSet kRotationRows = 0b111000;  // rot_x, rot_y, rot_z
extern const char* const kRowNames[kRows];         // "x" … "rot_z"

// A mode of a joint.
struct JointMode {
  std::string name;  // unique within the joint
  RowSet rows = 0;   // active rows
};

// A joint between two bodies, or between the ground and a body. Its mode is the set of rows that hold; without rows it
// is free. A joint none of whose modes has rows constrains nothing: it serves to measure, or to carry springs.
struct Joint {
  std::string name;                                          // unique among joints
  int base = kGround;                                        // body i of (4.11): carries the joint frame
  int follower = 0;                                          // body j: carries the point
  Eigen::Vector3d point_base = Eigen::Vector3d::Zero();      // from base's origin, base axes (ground: W), m
  Eigen::Vector3d point_follower = Eigen::Vector3d::Zero();  // from follower's origin, follower axes, m
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();        // columns x, y, z of the joint frame in base axes
  std::optional<Eigen::Matrix3d> rotation_axes;  // frame of the rotation rows in base axes; the joint frame if absent
  std::optional<Eigen::Matrix3d> follower_axes;  // the rotation frame in follower axes at angle zero; if absent, the
                                                 // two coincide at the initial attitudes
  bool universal = false;  // in modes whose only rotation row is rot_z: that row is about x_base × y_follower, so that
                           // the follower may turn about x of the base and its own y
  std::vector<JointMode> modes;  // at least one
  int mode = 0;                  // initial mode
  // Stiffness of its point–plane rows beside those of other joints, > 0, for the split of redundant reactions alone
  // (kernel/solver/redundant_rows.h). A rotation row shares as a point–plane row does at `share_length`, m, > 0; by
  // default a tenth of the distance of the joints of its loops from their middle, root mean square, at the start.
  double share = 1;
  std::optional<double> share_length{};  // see share
};

// --- Elements: what pushes and pulls --------------------------------------------------------------------------------

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
// up the other way if it swings on (unlatch/cords.h). The force is along the straight part.
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

// --- Shapes and contacts --------------------------------------------------------------------------------------------

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
};

// Field of gravity: uniform, central, or both.
struct Gravity {
  Eigen::Vector3d uniform = Eigen::Vector3d::Zero();  // m/s²
  double mu = 0;                                      // central field, m³/s²; 0 for none
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   // of the central field, W, m
};

// --- Channels, signals, sensors -------------------------------------------------------------------------------------

// A number that flight software commands.
struct Channel {
  std::string name;
  double initial = 0, minimum = 0, maximum = 1, safe = 0;
  std::string unit = "1";
};

// A measured value.
struct Sensor {
  // Measured quantity: number of values, unit and axes.
  enum class Kind {
    kPosition,       // 3, p_WB, m
    kAttitude,       // 4, w x y z, body to inertial
    kVelocity,       // 3, inertial axes, m/s
    kRate,           // 3, body axes, rad/s
    kAcceleration,   // 3, of `point`, body axes, m/s²
    kSpecificForce,  // 3, the same less gravity: what an accelerometer reads
    kContact,        // 1, a signal: 0 or 1
    kReaction,       // 6, multipliers of a joint in the order of Row, N and N m; 0 for rows that do not hold
    kDisplacement,   // 1, of the follower's point along `axis` of the joint frame, m
    kAngle,          // 1, about `axis` of the rotation frame, turns counted, rad
    kSpeed,          // 1, rate of the displacement, m/s, or of the angle, rad/s
    kDistance,       // 1, signed distance of surfaces `subject` and `other`, m
    kQuantity,       // 1, quantity number `subject` of the model
  };
  std::string name;                                 // unique among sensors
  Kind kind = Kind::kRate;                          // measured quantity
  int subject = 0;                                  // body, joint, signal, surface or quantity
  int axis = kX;                                    // Row
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // body axes, m
  int other = kNone;                                // kDistance: the other surface
};
// Number of values of a sensor.
int sensor_width(Sensor::Kind kind);
// Unit of a sensor's values; of kQuantity get_unit() of unlatch/quantities.h has it.
const char* sensor_unit(Sensor::Kind kind);

// --- Events ---------------------------------------------------------------------------------------------------------

// Their conditions and actions are in unlatch/events.h.

// An impulse on a body: a pyrotechnic shock. Rows stay closed: their reactions are impulses too.
struct Impulse {
  int body = 0;                                       // index of the body
  Load::Frame frame = Load::Frame::kBody;             // axes of `linear` and `angular`
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    // where `linear` acts, body axes, m
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // N s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // N m s
  int channel = kNone;                                // command channel that multiplies both
};

// --- The whole ------------------------------------------------------------------------------------------------------

// A system: bodies, joints, forces, channels, sensors and events. Names are unique within each list.
struct Model {
  std::string name;                          // for reports
  std::vector<Body> bodies;                  // indices of other lists refer to this order
  std::vector<Joint> joints;                 // tree and non-tree joints
  Gravity gravity;                           // field
  Environment environment;                   // planet, air, wind
  std::vector<Load> loads;                   // forces and torques
  std::vector<PointSpring> point_springs;    // springs between points
  std::vector<JointSpring> joint_springs;    // springs in joints
  std::vector<PlaneTorsion> plane_torsions;  // torsion springs towards a plane
  std::vector<Surface> surfaces;             // that contacts, conditions and sensors name
  std::vector<Contact> contacts;             // between shapes
  int contact_substeps = 0;                  // parts of a step while some contact is closed; see kAutomaticSubsteps
  std::vector<OneSided> one_sided;           // pushers, stops and cords
  std::vector<JointFriction> frictions;      // Coulomb friction in joints
  std::vector<Aerodynamics> aerodynamics;    // forces of the air
  std::vector<Channel> channels;             // commanded values
  std::vector<std::string> signals;          // names
  std::vector<Quantity> quantities;          // named numbers, of one value each
  std::vector<Table> tables;                 // that laws look up
  std::vector<Law> laws;                     // that profiles, quantities and elements name
  std::vector<Sensor> sensors;               // measured values
  std::vector<Impulse> impulses;             // that actions name
  std::vector<Event> events;                 // in the order in which they act at one instant

  // Elements share one numbering: loads, point springs, joint springs, plane torsions, contacts,
  // one-sided forces, frictions, aerodynamics.
  int element_count() const;
  const std::string& element_name(int element) const;
};

// A mistake in a model.
struct ModelError {
  std::string where;  // "body 'core'"
  std::string what;   // the mistake
  std::string mend;   // what would be right
  std::string key{};  // the property, as scenarios call it: "mass"; empty for the whole
};

// Value of Model::contact_substeps that leaves the number of parts to the step: a power of two up to
// kMaxAutomaticSubsteps, by the present depths, speeds and masses (kernel/elements/kinds/contact/contact_parts.h).
inline constexpr int kAutomaticSubsteps = 0;
// Largest number of parts that the step chooses.
inline constexpr int kMaxAutomaticSubsteps = 256;
// Largest number that a model may give.
inline constexpr int kMaxContactSubsteps = 64;
// The largest number of parts into which a step of the model can be cut.
int get_most_contact_substeps(const Model& model);

// Appends the events "touch" and "lift" of each contact, with its name as subject: repeating, without actions. A
// contact that is closed at the start has no touch then.
void add_contact_events(Model& model);

// True if some body of the model is a marker.
bool has_markers(const Model& model);
// A copy of the model in which markers have the initial poses and velocities that follow from their flexible bodies.
Model place_markers(const Model& model);

// A copy of the model with two more events for each one-sided force that has none yet: where it becomes engaged, and
// where it ceases to be. They stand after all other events, and compile_plan() numbers them so. Their subject is the
// force's name; their names are "touch" and "stroke_end" of a pusher, "touch" and "lift" of a stop, "taut" and "slack"
// of a cord.
Model complete_events(const Model& model);

// Every mistake that makes the model unphysical or inconsistent. If there is none, it can be compiled.
std::vector<ModelError> validate(const Model& model);

}  // namespace unlatch
