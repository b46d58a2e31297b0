#include "hil/scenario/text/quantity.h"

#include <algorithm>
#include <numbers>

#include "hil/scenario/text/expression.h"

namespace unlatch::hil {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr Dimension kLength{{1, 0, 0, 0}}, kMass{{0, 1, 0, 0}}, kTime{{0, 0, 1, 0}}, kAngle{{0, 0, 0, 1}},
    kForce{{1, 1, -2, 0}}, kRate{{0, 0, -1, 1}}, kFrequency{{0, 0, -1, 0, 1}}, kPressure{{-1, 1, -2, 0}},
    kEnergy{{2, 1, -2, 0}}, kTemperature{{0, 0, 0, 0, 0, 1}};

// Units by dimension, the SI unit first. A foot, an inch and a pound are exact by definition (1959); a pound-force is a
// pound times the standard gravity of 9.80665 m/s2.
constexpr Unit kUnits[] = {
    {"m", 1, 1, kLength},
    {"mm", 1, 1e3, kLength},
    {"cm", 1, 1e2, kLength},
    {"km", 1e3, 1, kLength},
    {"kg", 1, 1, kMass},
    {"g", 1, 1e3, kMass},
    {"t", 1e3, 1, kMass},
    {"s", 1, 1, kTime},
    {"ms", 1, 1e3, kTime},
    {"us", 1, 1e6, kTime},
    {"min", 60, 1, kTime},
    {"rad", 1, 1, kAngle},
    {"mrad", 1, 1e3, kAngle},
    {"deg", kPi, 180, kAngle},
    {"N", 1, 1, kForce},
    {"mN", 1, 1e3, kForce},
    {"kN", 1e3, 1, kForce},
    {"MN", 1e6, 1, kForce},
    {"rpm", kPi, 30, kRate},
    {"in", 0.0254, 1, kLength},
    {"ft", 0.3048, 1, kLength},
    {"lb", 0.45359237, 1, kMass},
    {"lbf", 4.4482216152605, 1, kForce},
    {"Hz", 1, 1, kFrequency},
    {"kHz", 1e3, 1, kFrequency},
    {"Pa", 1, 1, kPressure},
    {"kPa", 1e3, 1, kPressure},
    {"MPa", 1e6, 1, kPressure},
    {"GPa", 1e9, 1, kPressure},
    {"J", 1, 1, kEnergy},
    {"kJ", 1e3, 1, kEnergy},
    {"K", 1, 1, kTemperature},
    {"%", 1, 100, {}},
};

// Returns false for customary units (in, ft, lb, lbf): their ratio to SI is no power of ten.
bool is_decimal(const Unit& unit) {
  return unit.dimension == kTime || unit.dimension == kAngle || unit.factor == 1 || unit.factor == 1e3 ||
         unit.factor == 1e6 || unit.factor == 1e9;
}

struct Named {
  Dimension dimension;
  const char *name, *si;
};
constexpr Named kNamed[] = {
    {{{1, 0, 0, 0}}, "a length", "m"},
    {{{0, 1, 0, 0}}, "a mass", "kg"},
    {{{0, 0, 1, 0}}, "a time", "s"},
    {{{0, 0, 0, 1}}, "an angle", "rad"},
    {{{1, 0, -1, 0}}, "a speed", "m/s"},
    {{{0, 0, -1, 1}}, "an angular rate", "rad/s"},
    {{{1, 0, -2, 0}}, "an acceleration", "m/s2"},
    {{{1, 1, -2, 0}}, "a force", "N"},
    {{{2, 1, -2, 0}}, "a torque", "N m"},
    {{{0, 1, -2, 0}}, "a stiffness", "N/m"},
    {{{0, 1, -1, 0}}, "a damping", "N s/m"},
    {{{2, 1, -2, -1}}, "a torsion stiffness", "N m/rad"},
    {{{2, 1, -1, -1}}, "a torsion damping", "N m s/rad"},
    {{{2, 1, 0, 0}}, "a moment of inertia", "kg m2"},
    {{{3, 0, -2, 0}}, "a gravitational parameter", "m3/s2"},
    {{{0, 1, -1, 0}}, "a mass flow", "kg/s"},
    {{{0, 0, -1, 0, 1}}, "a frequency", "Hz"},
    {{{-1, 1, -2, 0}}, "a pressure", "Pa"},
    {{{0, 0, 0, 0, 0, 1}}, "a temperature", "K"},
    {{{-3, 1, 0, 0}}, "a density", "kg/m3"},
};

std::string compose_si(const Dimension& dimension) {
  static constexpr const char* kBase[] = {"m", "kg", "s", "rad", "", "K"};
  std::string text;
  for (const Dimension::Base base :
       {Dimension::kMass, Dimension::kLength, Dimension::kTime, Dimension::kAngle, Dimension::kTemperature}) {
    const int exponent = dimension.exponents[base];
    if (exponent == 0) continue;
    text += (text.empty() ? "" : " ") + std::string(kBase[base]) + (exponent == 1 ? "" : std::to_string(exponent));
  }
  return text;
}

}  // namespace

bool Dimension::is_plain() const {
  for (const Base base : {kLength, kMass, kTime, kAngle, kTemperature})
    if (exponents[base] != 0) return false;
  return true;
}

bool Dimension::takes(const Dimension& other) const {
  const int angle = exponents[kAngle], given = other.exponents[kAngle];
  const bool cycles_for_radians = other.exponents[kCycle] != exponents[kCycle] && given != angle;
  return std::equal(exponents.begin(), exponents.begin() + kAngle, other.exponents.begin()) &&
         exponents[kTemperature] == other.exponents[kTemperature] && (given == angle || given == 0) &&
         !cycles_for_radians;
}

const Unit* find_unit(std::string_view name) {
  const auto* at = std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) { return u.name == name; });
  return at == std::end(kUnits) ? nullptr : at;
}

std::string describe_dimension(const Dimension& dimension) {
  if (dimension.is_plain()) return "a plain number";
  for (const Named& named : kNamed)
    if (named.dimension == dimension) return std::string(named.name) + " (" + named.si + ")";
  if (dimension.exponents[Dimension::kCycle] == 0) return "a quantity in " + compose_si(dimension);
  Dimension without_cycles = dimension;
  without_cycles.exponents[Dimension::kCycle] = 0;
  return describe_dimension(without_cycles);
}

std::string describe_unit(const Dimension& dimension) {
  for (const Named& named : kNamed)
    if (named.dimension == dimension) return named.si;
  static const char* const kNames[] = {"m", "kg", "s", "rad", "Hz", "K"};
  std::array<int, 6> exponents = dimension.exponents;
  exponents[Dimension::kTime] += exponents[Dimension::kCycle];
  std::string text;
  for (const bool below : {false, true})
    for (std::size_t i = 0; i < exponents.size(); ++i) {
      const int exponent = below ? -exponents[i] : exponents[i];
      if (exponent <= 0) continue;
      text += (below ? "/" : text.empty() ? "" : " ") + std::string(kNames[i]);
      if (exponent > 1) text += std::to_string(exponent);
    }
  return text;
}

Dimension dimension_of(std::string_view si) {
  return si.empty() ? Dimension{} : evaluate_expression("1 " + std::string(si), {}).dimension;
}

std::vector<std::string> list_unit_names() {
  std::vector<std::string> names;
  for (const Unit& unit : kUnits) names.emplace_back(unit.name);
  return names;
}

// Lists units with other prefixes of the first factor: kN m, MN m. Feet and pounds are listed alone, not in products.
std::vector<std::string> list_units(std::string_view si) {
  std::vector<std::string> names;
  const std::size_t length = std::min(si.find_first_of(" /0123456789"), si.size());
  const Unit* first = find_unit(si.substr(0, length));
  if (first == nullptr) return names;
  for (const Unit& unit : kUnits)
    if (unit.dimension == first->dimension && unit.name != first->name && (length == si.size() || is_decimal(unit)))
      names.push_back(std::string(unit.name) + std::string(si.substr(length)));
  if (si == "rad/s") names.emplace_back("rpm");
  return names;
}

}  // namespace unlatch::hil
