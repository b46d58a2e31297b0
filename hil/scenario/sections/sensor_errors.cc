// Errors of sensors, in the units of data sheets: deg/h, deg/√h, µg/√Hz.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/number_text.h"
#include "hil/scenario/text/written_unit.h"

namespace unlatch::hil {
namespace {

// The largest size of an error, in SI units: what is sent stays finite.
constexpr double kMostSize = 1e30;
constexpr double kMostMisalignment = std::numbers::pi;  // rad, about each axis

// A number or a list with units of data sheets in those of the language.
YamlNode translate(YamlNode node) {
  node.text = replace_sheet_units(node.text);
  for (YamlNode& item : node.items) item.text = replace_sheet_units(item.text);
  return node;
}

// Twice the exponents of a unit, and `seconds` more of time.
Dimension calc_squared(const std::string& unit, int seconds) {
  Dimension dimension = dimension_of(unit);
  for (int& exponent : dimension.exponents) exponent *= 2;
  dimension.exponents[Dimension::kTime] += seconds;
  return dimension;
}

// A size of an error, at least 0, in `unit` times s^(seconds / 2): √s for a density per √Hz, 1/√s for a random walk. A
// number alone is in this SI unit. `example`: in the units of data sheets.
double read_size(YamlMap& map, const char* key, const std::string& unit, int seconds, const char* example,
                 Mistakes& mistakes) {
  const YamlNode* const node = map.find(key);
  if (node == nullptr) return 0;
  YamlNode translated = *node;
  const std::string plain = replace_sheet_units(node->text), squared = square_root_unit(plain);
  translated.text = squared.empty() ? plain : squared;
  bool fits = true;
  double value = 0;
  if (seconds == 0 && squared.empty()) {
    value = read_number(translated, unit, 0, mistakes);
  } else {
    const std::optional<Quantity> quantity = read_quantity(translated, mistakes);
    if (!quantity) return 0;
    fits =
        quantity->dimension.is_plain() || (!squared.empty() && calc_squared(unit, seconds).takes(quantity->dimension));
    value = squared.empty() ? quantity->value : std::sqrt(quantity->value);
  }
  if (fits && value >= 0 && value <= kMostSize) return value;
  mistakes.add(node->mark, "'" + node->text + "' is no size of this error",
               "write a number in " + (unit.empty() ? "1" : unit) +
                   (seconds == 0 ? "" : (seconds > 0 ? "/√Hz" : "/√s")) + ", from 0 to " + write_short(kMostSize) +
                   ", or with units of data sheets: " + example);
  return 0;
}

const char* get_example(const std::string& unit, int seconds) {
  if (unit == "rad/s") return seconds == 0 ? "0.5 deg/h" : (seconds > 0 ? "0.05 deg/√h" : "0.2 deg/h/√h");
  if (unit == "m/s2") return seconds == 0 ? "30 µg" : (seconds > 0 ? "50 µg/√Hz" : "5 µg/√h");
  if (unit == "rad") return seconds == 0 ? "0.01 deg" : (seconds > 0 ? "1 mrad/√Hz" : "1 mrad/√h");
  return seconds == 0 ? "0.01" : "1e-3";
}

}  // namespace

void ScenarioReader::read_sensor_errors(const YamlNode& node, const Sensor& sensor) {
  using Kind = Sensor::Kind;
  YamlMap map(node, "errors of sensor '" + sensor.name + "'", mistakes_);
  SensorErrors errors;
  errors.sensor = static_cast<int>(model_.sensors.size());
  errors.name = calc_name_hash(sensor.name);
  const int width = sensor_width(sensor.kind);
  const bool attitude = sensor.kind == Kind::kAttitude, signal = sensor.kind == Kind::kContact;
  std::string unit = attitude ? "rad" : get_unit(model_, get_quantity(model_, sensor));
  if (unit == "1") unit = "";
  const auto size = [&](const char* key, int seconds = 0) {
    return read_size(map, key, unit, seconds, get_example(unit, seconds), mistakes_);
  };
  if (!signal) {
    if (const YamlNode* const bias = map.find("bias")) {
      const YamlNode list = translate(*bias);
      if (bias->is_scalar()) {
        errors.bias.assign(static_cast<std::size_t>(attitude ? 3 : width), read_number(list, unit, 0, mistakes_));
      } else {
        errors.bias = read_numbers(list, static_cast<std::size_t>(attitude ? 3 : width), unit, mistakes_);
        errors.bias.resize(static_cast<std::size_t>(attitude ? 3 : width));
      }
      if (std::ranges::any_of(errors.bias, [](double value) { return !(std::abs(value) <= kMostSize); }))
        mistakes_.add(bias->mark, "'bias' is out of its range", "an absolute value up to " + write_short(kMostSize));
    }
    errors.turn_on = size("turn_on");
    errors.noise = size("noise");
    errors.noise_density = size("noise_density", 1);
    errors.walk = size("walk", -1);
    errors.drift = size("drift");
    errors.drift_time = read_bounded(map, get_number_key("scenario.sensor_errors.drift_time"), 100.0, mistakes_);
  }
  if (!signal && !attitude) {
    if (const YamlNode* const scale = map.find("scale")) {
      const double read = read_number(translate(*scale), "", 0, mistakes_);
      if (check_bounds(read, get_number_key("scenario.sensor_errors.scale"), scale->mark, mistakes_))
        errors.scale = read;
    }
    if (width == 3) {
      if (const YamlNode* const turn = map.find("misalignment")) {
        const std::vector<double> read = read_numbers(translate(*turn), 3, "rad", mistakes_);
        if (read.size() == 3) errors.misalignment = Eigen::Vector3d(read[0], read[1], read[2]);
        if (!(errors.misalignment.cwiseAbs().maxCoeff() <= kMostMisalignment))
          mistakes_.add(turn->mark, "'misalignment' is out of its range", "a turn of at most 180 deg about each axis");
      }
    }
    errors.quantum = size("quantum");
    errors.range = size("range");
    if (errors.range > 0 && errors.quantum > errors.range)
      mistakes_.add(map.find("quantum")->mark,
                    "the quantum '" + map.find("quantum")->text + "' is greater than the range '" +
                        map.find("range")->text + "': every value would be sent as 0",
                    "give a quantum of at most the range");
  }
  errors.dropout = read_bounded(map, get_number_key("scenario.sensor_errors.dropout"), 0.0, mistakes_);
  if (const YamlNode* const delay = map.find("delay"))
    sensor_delays_.push_back({scenario_.rates.errors.sensors.size(), *delay});
  map.finish();
  scenario_.rates.errors.sensors.push_back(std::move(errors));
}

// A delay is a number of samples, or a time that is one: known once the groups are.
void ScenarioReader::read_sensor_delays() {
  constexpr double kSameTime = 1e-6;  // relative to a sample: the rounding of a decimal period
  constexpr const NumberKey& kDelay = get_number_key("scenario.sensor_errors.delay");
  for (const SensorDelay& delay : sensor_delays_) {
    SensorErrors& errors = scenario_.rates.errors.sensors[delay.errors];
    const std::optional<Quantity> quantity = read_quantity(delay.node, mistakes_);
    if (!quantity) continue;
    std::int64_t every = 1;
    for (const RateGroup& group : scenario_.rates.groups)
      if (std::ranges::find(group.sensors, errors.sensor) != group.sensors.end()) every = group.rate.every;
    const double period = static_cast<double>(every) * scenario_.dt;
    const bool timed = quantity->dimension == dimension_of("s");
    if (!timed && !quantity->dimension.is_plain()) {
      mistakes_.add(delay.node.mark, "'" + delay.node.text + "' is " + describe_dimension(quantity->dimension),
                    "write a plain number, that of the samples, or a time: 2, 20 ms");
      continue;
    }
    double samples = timed && period > 0 ? quantity->value / period : quantity->value;
    if (timed && std::abs(samples - std::round(samples)) <= kSameTime) samples = std::round(samples);
    const auto write = [&](double count) { return timed ? write_short(count * period) + " s" : write_short(count); };
    if (timed && !(samples >= kDelay.least && samples <= kDelay.most)) {
      mistakes_.add(delay.node.mark, "'" + delay.node.text + "' is a delay of " + write_short(samples) + " samples",
                    "from 0 to " + write(kDelay.most) + ": at most " + write_short(kDelay.most) + " samples of " +
                        write_short(period) + " s");
      continue;
    }
    if (samples == std::floor(samples) || !std::isfinite(samples)) {
      if (check_bounds(samples, kDelay, delay.node.mark, mistakes_)) errors.delay = static_cast<int>(samples);
      continue;
    }
    mistakes_.add(delay.node.mark,
                  "a delay of " + write_short(samples) + " samples: values are sampled, and delivered, every " +
                      write_short(period) + " s",
                  write(std::floor(samples)) + " or " + write(std::ceil(samples)) +
                      ", or a group with a shorter period in timing.groups");
  }
}

}  // namespace unlatch::hil
