// Quantities that a run can write down, each with name, unit, frame and length, and the selection of some of them. They
// decide nothing in the run and are not part of its model. hil/outputs reads their values; every export, the samples of
// `--json` and libraries use this one list.
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
    kPosition,             // of a body's origin, W, m
    kAttitude,             // quaternion w x y z, body to W
    kVelocity,             // of the origin, W, m/s
    kRate,                 // angular velocity, body axes, rad/s
    kAcceleration,         // of the origin, W, m/s²
    kAngularAcceleration,  // body axes, rad/s²
    kModal,                // modal coordinates, kg^0.5 m
    kModalRate,            // their rates, kg^0.5 m/s
    kMode,                 // of a joint: the index of its mode
    kForce,                // multipliers of a joint's rows x y z, on the follower, along the rows, N; 0: the row is off
    kMoment,               // of rot_x rot_y rot_z, N m
    kDisplacement,         // of the follower's point, joint frame, m
    kAngle,                // about the axes of the rotation frame, in (−π, π], rad
    kSpeed,                // rate of the displacement, m/s
    kAngleRate,            // angular velocity about the axes of the rotation frame, rad/s
    kElementForce,         // of an element (unlatch/readings.h), N or N m
    kElementLength,        // of a point spring, m
    kElementStroke,        // what is left of the stroke of a point spring or one-sided force, m or rad
    kElementWound,         // angle of a cord on its drum, rad
    kElementOnDrum,        // and length, m
    kElementCoordinate,    // of a joint spring, plane torsion, one-sided force or friction, m or rad
    kElementRate,          // rate of the length or coordinate, m/s or rad/s
    kElementScale,         // of an element's switch, 0 to 1
    kContactForce,         // of a contact (unlatch/contacts.h): sum of the pairs' normal forces, N
    kContactFriction,      // sum of the sizes of their friction, N
    kContactDepth,         // of the deepest pair, m; 0 while it is open
    kContactSlipSpeed,     // weighted by the normal forces, m/s
    kContactImpulse,       // of the normal forces since the start, N s
    kContactSlip,          // path of the slip since the start, m
    kContactDissipated,    // what damping and friction took since the start, J
    kSensor,               // values of a sensor, as measured at this tick, without the rates of groups
    kSignal,               // of a signal, 0 or 1
    kCommand,              // commanded value of a channel, in its unit
    kClearance,            // distance of a pair that the scenario watches, m
  };
  struct Column {
    std::string name;  // "core.vx", unique in a scenario
    std::string unit;  // "m/s"; "1" for a plain number
  };

  Kind kind = Kind::kPosition;
  int subject = 0;              // body, joint, element, contact, sensor, signal, channel or pair, by its number
  std::string group, of, what;  // "body", "core", "velocity"
  std::string name;             // "body.core.velocity"; "signal.armed", "clearance.core.booster1" have no third part
  std::string key;              // in JSON: "v"
  std::string frame;            // axes of its components: "W", "body", "joint", "sensor"; empty for none
  std::vector<Column> columns;  // one for each component
  std::size_t first = 0;        // its first value among those of all outputs
};

// All of a scenario, in a fixed order.
std::vector<Output> list_outputs(const Scenario& scenario);
// Number of values of all of them.
std::size_t count_values(std::span<const Output> outputs);

// The names of a sensor's values after the sensor's own: ".x" …
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

// `pattern`: an output's name, with * for any characters; its first part may be left out. "core.*", "*.force".
bool matches(std::string_view pattern, const Output& output);
// All outputs in one group: of a scenario that selects none.
std::vector<SelectedOutputs> select_all(std::span<const Output> outputs, Rate rate = {});
std::vector<SelectedOutputs> select(std::span<const Output> outputs, std::span<const OutputGroup> groups);
// Empty if the pattern selects an output; else the correction.
std::string find_fault(std::string_view pattern, std::span<const Output> outputs);

// "core.*,*.force@10,sensor.*@100Hz": patterns, each with the ticks from one row to the next, or a rate in Hz. `dt`: s.
// Throws std::invalid_argument.
std::vector<OutputGroup> parse_outputs(const std::string& text, double dt, std::span<const Output> outputs);
// Ticks from one instant to the next of a rate in Hz; 0 if that is no whole number of steps.
std::int64_t calc_every(double rate, double dt);

}  // namespace unlatch::hil
