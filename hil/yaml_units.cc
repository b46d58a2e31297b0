#include "hil/yaml_units.h"

#include <numbers>

namespace unlatch::hil {
namespace {

constexpr double kPi = std::numbers::pi;

constexpr Unit kUnits[] = {
    {"ms", "s", 1, 1e3},          {"us", "s", 1, 1e6},         {"min", "s", 60, 1},     {"mm", "m", 1, 1e3},
    {"cm", "m", 1, 1e2},          {"km", "m", 1e3, 1},         {"g", "kg", 1, 1e3},     {"t", "kg", 1e3, 1},
    {"deg", "rad", kPi, 180},     {"mrad", "rad", 1, 1e3},     {"mm/s", "m/s", 1, 1e3}, {"km/s", "m/s", 1e3, 1},
    {"deg/s", "rad/s", kPi, 180}, {"mrad/s", "rad/s", 1, 1e3}, {"kN", "N", 1e3, 1},     {"MN", "N", 1e6, 1},
    {"mN", "N", 1, 1e3},          {"kN m", "N m", 1e3, 1},     {"kN/m", "N/m", 1e3, 1}, {"N/mm", "N/m", 1e3, 1},
    {"km3/s2", "m3/s2", 1e9, 1},
};

}  // namespace

const Unit* find_unit(std::string_view name, std::string_view si) {
  for (const Unit& unit : kUnits)
    if (unit.name == name && unit.si == si) return &unit;
  return nullptr;
}

std::vector<std::string> list_units(std::string_view si) {
  std::vector<std::string> names{std::string(si)};
  for (const Unit& unit : kUnits)
    if (unit.si == si) names.emplace_back(unit.name);
  return names;
}

}  // namespace unlatch::hil
