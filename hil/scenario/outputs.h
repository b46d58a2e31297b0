// Quantities that a run can write to files, each with name, unit, frame and length, and the selection of some of them.
// They do not influence the run and are not part of its model. hil/run/outputs reads their values; every export, the
// samples of `--json` and the libraries use this one list.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hil/scenario/rates.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct Scenario;

struct Output {
  enum class Kind {
    kPosition,             // body's origin, W, m
    kAttitude,             // body's quaternion w x y z, body to W
    kVelocity,             // body's origin, W, m/s
    kRate,                 // angular velocity, body axes, rad/s
    kAcceleration,         // body's origin, W, m/s²
    kAngularAcceleration,  // body axes, rad/s²
    kModal,                // modal coordinates, kg^0.5 m
    kModalRate,            // rates of the modal coordinates, kg^0.5 m/s
    kMode,                 // index of a joint's mode
    kForce,                // multipliers of a joint's rows x y z, on the follower, along the rows, N; 0: the row is off
    kMoment,               // likewise of rows rot_x rot_y rot_z, N m
    kDisplacement,         // follower's point, joint frame, m
    kAngle,                // about the axes of the rotation frame, in (−π, π], rad
    kSpeed,                // rate of the displacement, m/s
    kAngleRate,            // angular velocity about the axes of the rotation frame, rad/s
    kElementForce,         // force of an element (unlatch/readings.h), N or N m
    kElementLength,        // length of a point spring, m
    kElementStroke,        // remaining stroke of a point spring or one-sided force, m or rad
    kElementWound,         // angle of a cord on its drum, rad
    kElementOnDrum,        // length of a cord on its drum, m
    kElementCoordinate,    // coordinate of a joint spring, plane torsion, one-sided force or friction, m or rad
    kElementRate,          // rate of the length or coordinate, m/s or rad/s
    kElementScale,         // of an element's switch, 0 to 1
    kContactForce,         // contact (unlatch/contacts.h): sum of the pairs' normal forces, N
    kContactFriction,      // sum of the sizes of their friction, N
    kContactDepth,         // depth of the deepest pair, m; 0 while the contact is open
    kContactSlipSpeed,     // weighted by the normal forces, m/s
    kContactImpulse,       // impulse of the normal forces since the start, N s
    kContactSlip,          // length of the slip path since the start, m
    kContactDissipated,    // energy dissipated by damping and friction since the start, J
    kSensor,               // values of a sensor, as measured at this tick, without the rates of groups
    kSignal,               // value of a signal, 0 or 1
    kCommand,              // commanded value of a channel, in its unit
    kClearance,            // distance of a watched pair, m
    kQuantity,             // one that the scenario names, in its unit
    kReceived,             // values of a sensor that flight software had at this tick
  };
  struct Column {
    std::string name;  // "core.vx", unique in a scenario
    std::string unit;  // "m/s"; "1" for a plain number
  };

  Kind kind = Kind::kPosition;
  int subject = 0;  // number of the body, joint, element, contact, sensor, signal, channel, pair or quantity
  std::string group, of, what;  // "body", "core", "velocity"
  std::string name;             // "body.core.velocity"; "signal.armed", "clearance.core.booster1" have no third part
  std::string key;              // key in JSON: "v"
  std::string frame;            // axes of its components: "W", "body", "joint", "sensor"; empty for none
  std::vector<Column> columns;  // one for each component
  std::size_t first = 0;        // index of its first value among those of all outputs
};

// The values of sensors as flight software receives them: shown where they differ from the true ones by the scenario,
// which has errors or rates of sensors; or always, because faults may have changed them in a session.
enum class SensorsShown { kAsScenario, kAlsoReceived };
bool shows_received(const Scenario& scenario, SensorsShown shown);

// Lists all outputs of a scenario, in a fixed order.
std::vector<Output> list_outputs(const Scenario& scenario, SensorsShown shown = SensorsShown::kAsScenario);
// Number of values of all these outputs.
std::size_t count_values(std::span<const Output> outputs);

// Names of a sensor's values, appended to the sensor's name: ".x" …
std::span<const char* const> get_sensor_components(Sensor::Kind kind);

// Outputs by patterns of their names, and the ticks at which they are written.
struct OutputGroup {
  std::vector<std::string> patterns;
  Rate rate;
};
struct SelectedOutputs {
  Rate rate;
  std::vector<std::size_t> outputs;  // indices, ascending
};

// Matches an output's name. `pattern`: * stands for any characters; the first part of the name may be left out.
// "core.*", "*.force".
bool matches(std::string_view pattern, const Output& output);
// All outputs in one group: for a scenario that selects none.
std::vector<SelectedOutputs> select_all(std::span<const Output> outputs, Rate rate = {});
std::vector<SelectedOutputs> select(std::span<const Output> outputs, std::span<const OutputGroup> groups);
// Correction of a pattern that selects no output; empty if it selects one.
std::string find_fault(std::string_view pattern, std::span<const Output> outputs);

// Parses "core.*,*.force@10,sensor.*@100Hz": patterns, each with the ticks from one row to the next, or a rate in Hz.
// `dt`: s. Throws std::invalid_argument.
std::vector<OutputGroup> parse_outputs(const std::string& text, double dt, std::span<const Output> outputs);
// Ticks from one instant to the next of a rate in Hz; 0 if that is no whole number of steps.
std::int64_t calc_every(double rate, double dt);

}  // namespace unlatch::hil
