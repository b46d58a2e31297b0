// Errors of sensors, in the units of data sheets: deg/h, deg/√h, µg/√Hz.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {
namespace {

// Units of data sheets that the language does not have elsewhere: h would be a common name of constants, and g is a
// gram.
struct SheetUnit {
  const char *name, *stands_for;
};
constexpr SheetUnit kSheetUnits[] = {{"µg", "(9.80665e-6 m/s2)"},
                                     {"μg", "(9.80665e-6 m/s2)"},
                                     {"ug", "(9.80665e-6 m/s2)"},
                                     {"mg", "(9.80665e-3 m/s2)"},
                                     {"Hz", "(1/s)"},
                                     {"h", "(3600 s)"}};

// Letters, and the bytes of µ (micro sign) and μ (Greek letter) in UTF-8; not those of √.
bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '\xc2' || c == '\xb5' || c == '\xce' ||
         c == '\xbc';
}

// A number, a unit or a bracket before a unit: "15 µg" is a product, "15*µg" has its star already.
bool ends_with_factor(const std::string& text) {
  const std::size_t last = text.find_last_not_of(' ');
  return last != std::string::npos &&
         (std::isalnum(static_cast<unsigned char>(text[last])) != 0 || text[last] == '.' || text[last] == ')');
}

std::string replace_sheet_units(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    if (!is_word(text[i])) {
      out += text[i++];
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && (is_word(text[end]) || (end > i && text[end] >= '0' && text[end] <= '9'))) ++end;
    const std::string word = text.substr(i, end - i);
    const auto* const unit = std::ranges::find(kSheetUnits, word, &SheetUnit::name);
    if (unit == std::end(kSheetUnits)) {
      out += word;
    } else {
      if (ends_with_factor(out)) out += '*';
      out += unit->stands_for;
    }
    i = end;
  }
  return out;
}

// "0.1 deg / √h" → "(0.1 deg)^2/(h)"; empty if there is no root at the end.
std::string square(const std::string& text) {
  for (const std::string& root : {std::string("√"), std::string("sqrt(")}) {
    const std::size_t at = text.rfind(root);
    if (at == std::string::npos) continue;
    const std::size_t slash = text.find_last_not_of(' ', at == 0 ? 0 : at - 1);
    if (slash == std::string::npos || text[slash] != '/') continue;
    std::string under = text.substr(at + root.size());
    if (root.back() == '(') {
      const std::size_t close = under.rfind(')');
      if (close == std::string::npos) continue;
      under = under.substr(0, close);
    }
    return "(" + text.substr(0, slash) + ")^2/(" + under + ")";
  }
  return "";
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
  const std::string squared = square(replace_sheet_units(node->text));
  translated.text = squared.empty() ? replace_sheet_units(node->text) : squared;
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
  if (fits && value >= 0 && std::isfinite(value)) return value;
  mistakes.add(node->mark, "'" + node->text + "' is no size of this error",
               "write a number in " + (unit.empty() ? "1" : unit) +
                   (seconds == 0 ? "" : (seconds > 0 ? "/√Hz" : "/√s")) +
                   ", at least 0, or with units of data sheets: " + example);
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
  const int width = sensor_width(sensor.kind);
  const bool attitude = sensor.kind == Kind::kAttitude, signal = sensor.kind == Kind::kContact;
  std::string unit = attitude ? "rad" : get_unit(model_, get_quantity(model_, sensor));
  if (unit == "1") unit = "";
  const auto size = [&](const char* key, int seconds = 0) {
    return read_size(map, key, unit, seconds, get_example(unit, seconds), mistakes_);
  };
  if (!signal) {
    if (const YamlNode* const bias = map.find("bias")) {
      YamlNode list = *bias;
      if (bias->is_scalar()) {
        list.text = replace_sheet_units(bias->text);
        errors.bias.assign(static_cast<std::size_t>(attitude ? 3 : width), read_number(list, unit, 0, mistakes_));
      } else {
        for (YamlNode& item : list.items) item.text = replace_sheet_units(item.text);
        errors.bias = read_numbers(list, static_cast<std::size_t>(attitude ? 3 : width), unit, mistakes_);
        errors.bias.resize(static_cast<std::size_t>(attitude ? 3 : width));
      }
    }
    errors.turn_on = size("turn_on");
    errors.noise = size("noise");
    errors.noise_density = size("noise_density", 1);
    errors.walk = size("walk", -1);
    errors.drift = size("drift");
    errors.drift_time = read_bounded(map, get_number_key("scenario.sensor_errors.drift_time"), 100.0, mistakes_);
  }
  if (!signal && !attitude) {
    errors.scale = map.number("scale", "", 0.0);
    if (width == 3) errors.misalignment = map.vector("misalignment", "rad", Eigen::Vector3d::Zero());
    errors.quantum = size("quantum");
    errors.range = size("range");
  }
  errors.dropout = read_bounded(map, get_number_key("scenario.sensor_errors.dropout"), 0.0, mistakes_);
  errors.delay = static_cast<int>(read_bounded(map, get_number_key("scenario.sensor_errors.delay"), 0.0, mistakes_));
  map.finish();
  scenario_.rates.errors.sensors.push_back(std::move(errors));
}

}  // namespace unlatch::hil
