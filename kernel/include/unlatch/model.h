// Model: the physics as the user described it. Plain data, filled by a loader or by hand, checked by validate() and
// never changed after a Plan was compiled from it. SI units and radians throughout; W is the inertial frame. The parts
// of a description are in unlatch/model/.
//
// References (4.x) are equations of Anshakov et al., "Dynamic processes in rocket-space systems", 2003, as corrected in
// kernel/README.md.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "unlatch/model/bodies.h"
#include "unlatch/model/elements.h"
#include "unlatch/model/environment.h"
#include "unlatch/model/events.h"
#include "unlatch/model/joints.h"
#include "unlatch/model/law.h"
#include "unlatch/model/quantity.h"
#include "unlatch/model/shapes.h"

namespace unlatch {

// Field of gravity: uniform, central, or both.
struct Gravity {
  Eigen::Vector3d uniform = Eigen::Vector3d::Zero();  // m/s²
  double mu = 0;                                      // central field, m³/s²; 0 for none
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   // of the central field, W, m
};

// --- Channels, sensors, impulses ------------------------------------------------------------------------------------

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

// A system: bodies, joints, elements, channels, sensors and events. Names are unique within each list, and among all
// elements.
struct Model : ElementLists {
  std::string name;                  // for reports
  std::vector<Body> bodies;          // indices of other lists refer to this order
  std::vector<Joint> joints;         // tree and non-tree joints
  Gravity gravity;                   // field
  Environment environment;           // planet, air, wind
  std::vector<Surface> surfaces;     // that contacts, conditions and sensors name
  int contact_substeps = 0;          // parts of a step while some contact is closed; see kAutomaticSubsteps
  std::vector<Channel> channels;     // commanded values
  std::vector<std::string> signals;  // names
  std::vector<Quantity> quantities;  // named numbers, of one value each
  std::vector<Table> tables;         // that laws look up
  std::vector<Law> laws;             // that profiles, quantities and elements name
  std::vector<Sensor> sensors;       // measured values
  std::vector<Impulse> impulses;     // that actions name
  std::vector<Event> events;         // in the order in which they act at one instant
};

// A mistake in a model.
struct ModelError {
  std::string where;  // "body 'core'"
  std::string what;   // the mistake
  std::string mend;   // what would be right
  std::string key{};  // the property, as scenarios call it: "mass"; empty for the whole
};

// Value of Model::contact_substeps that leaves the number of parts to the step: as many as needed, up to
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
