#include "library/fmi/variables.h"

#include <set>
#include <string_view>

namespace unlatch::fmi {
namespace {

constexpr const char* kRows[] = {"x", "y", "z", "rot_x", "rot_y", "rot_z"};
constexpr const char* kQuaternion[] = {"w", "x", "y", "z"};
constexpr std::string_view kDash = " – ";  // between the names of a watched pair

class Lister {
 public:
  explicit Lister(unlatch_simulation* simulation) : simulation_(simulation) {}

  std::vector<Variable> list() {
    variables_.push_back({"time", "s", "simulated time", Variable::Causality::kIndependent, 0, 0, 0, nullptr});
    add_channels();
    add_sensors();
    add_reactions();
    add_bodies();
    add_clearances();
    add_constants();
    add_numbers();
    return good_ ? std::move(variables_) : std::vector<Variable>{};
  }

 private:
  std::size_t count(std::int32_t kind) {
    std::size_t number = 0;
    good_ &= unlatch_count(simulation_, kind, &number) == UNLATCH_OK;
    return number;
  }
  unlatch_item describe(std::int32_t kind, std::size_t index) {
    unlatch_item item{};
    item.size = sizeof item;
    item.name = item.unit = item.text = "";
    good_ &= unlatch_describe(simulation_, kind, index, &item) == UNLATCH_OK;
    return item;
  }
  unlatch_array get_array(std::int32_t which, std::size_t index = 0) {
    unlatch_array array{};
    array.size = sizeof array;
    good_ &= unlatch_get_array(simulation_, which, index, &array) == UNLATCH_OK;
    return array;
  }
  static const double* at(const unlatch_array& array, std::size_t row, std::size_t column) {
    return reinterpret_cast<const double*>(static_cast<const char*>(array.data) +
                                           static_cast<std::ptrdiff_t>(row) * array.row_stride +
                                           static_cast<std::ptrdiff_t>(column) * array.column_stride);
  }

  void add_channels() {
    const unlatch_array values = get_array(UNLATCH_CHANNELS);
    for (std::size_t i = 0, n = count(UNLATCH_CHANNEL); i < n && good_; ++i) {
      const unlatch_item item = describe(UNLATCH_CHANNEL, i);
      variables_.push_back({std::string("channels.") + item.name, item.unit, "command", Variable::Causality::kInput,
                            item.initial, item.minimum, item.maximum, at(values, i, 0)});
    }
  }
  void add_sensors() {
    const unlatch_array values = get_array(UNLATCH_SENSORS);
    for (std::size_t i = 0, n = count(UNLATCH_SENSOR); i < n && good_; ++i) {
      const unlatch_item item = describe(UNLATCH_SENSOR, i);
      for (std::int32_t k = 0; k < item.width; ++k) {
        const char* const part = item.width == 4 ? kQuaternion[k] : kRows[k];
        const std::string unit = item.width == 6 ? (k < 3 ? "N" : "N m") : item.unit;
        add(std::string("sensors.") + item.name + (item.width > 1 ? std::string(".") + part : ""), unit, "sensor",
            at(values, static_cast<std::size_t>(item.first + k), 0));
      }
    }
  }
  void add_reactions() {
    for (std::size_t i = 0, n = count(UNLATCH_JOINT); i < n && good_; ++i) {
      const unlatch_array rows = get_array(UNLATCH_REACTIONS, i);
      for (std::size_t k = 0; k < 6; ++k)
        add(std::string("reactions.") + describe(UNLATCH_JOINT, i).name + "." + kRows[k], k < 3 ? "N" : "N m",
            "reaction on the follower, joint axes", at(rows, 0, k));
    }
  }
  void add_bodies() {
    struct Part {
      std::int32_t which;
      const char *name, *unit, *description;
    };
    constexpr Part kParts[] = {{UNLATCH_POSITIONS, "position", "m", "inertial axes"},
                               {UNLATCH_ATTITUDES, "attitude", "1", "quaternion, body to inertial"},
                               {UNLATCH_VELOCITIES, "velocity", "m/s", "inertial axes"},
                               {UNLATCH_ANGULAR_VELOCITIES, "angular_velocity", "rad/s", "body axes"}};
    for (std::size_t i = 0, n = count(UNLATCH_BODY); i < n && good_; ++i) {
      const std::string body = std::string("bodies.") + describe(UNLATCH_BODY, i).name + ".";
      for (const Part& part : kParts) {
        const unlatch_array values = get_array(part.which);
        for (std::size_t k = 0; k < values.columns; ++k)
          add(body + part.name + "." + (values.columns == 4 ? kQuaternion[k] : kRows[k]), part.unit, part.description,
              at(values, i, k));
      }
    }
  }
  void add_clearances() {
    const std::size_t pairs = count(UNLATCH_CLEARANCE);
    if (pairs == 0) return;
    const unlatch_array values = get_array(UNLATCH_CLEARANCES);
    for (std::size_t i = 0; i < pairs && good_; ++i) {
      const unlatch_item item = describe(UNLATCH_CLEARANCE, i);
      const std::string pair = item.name;  // "a.skirt – b"
      const std::size_t dash = pair.find(kDash);
      if (dash == std::string::npos) continue;
      add("clearances." + pair.substr(0, dash) + "." + pair.substr(dash + kDash.size()), "m",
          "signed distance of " + pair + ", negative where they overlap", at(values, i, 0));
    }
  }
  void add_constants() {
    for (std::size_t i = 0, n = count(UNLATCH_CONSTANT); i < n && good_; ++i) {
      const unlatch_item item = describe(UNLATCH_CONSTANT, i);
      variables_.push_back({item.text, item.unit, "constant of the scenario", Variable::Causality::kParameter,
                            item.initial, 0, 0, nullptr});
    }
  }
  // Adds numbers, except the version of the language, and the step and end of the run, which the importer controls.
  void add_numbers() {
    for (std::size_t i = 0, n = count(UNLATCH_NUMBER); i < n && good_; ++i) {
      const unlatch_item item = describe(UNLATCH_NUMBER, i);
      const std::string_view path = item.name;
      if (path == "unlatch" || path == "step.dt" || path == "step.until") continue;
      variables_.push_back({item.name, item.unit, "number of the scenario", Variable::Causality::kParameter,
                            item.initial, 0, 0, nullptr});
    }
  }
  // Adds an output. FMI wants unique names: of the pairs a.skirt – b and a – skirt.b the second gets a number.
  void add(std::string name, std::string unit, std::string description, const double* data) {
    std::string unique = name;
    for (int number = 2; !names_.insert(unique).second; ++number) unique = name + "_" + std::to_string(number);
    variables_.push_back(
        {std::move(unique), std::move(unit), std::move(description), Variable::Causality::kOutput, 0, 0, 0, data});
  }

  unlatch_simulation* const simulation_;
  std::vector<Variable> variables_;
  std::set<std::string> names_;  // of the outputs
  bool good_ = true;
};

}  // namespace

std::vector<Variable> list_variables(unlatch_simulation* simulation) { return Lister(simulation).list(); }

}  // namespace unlatch::fmi
