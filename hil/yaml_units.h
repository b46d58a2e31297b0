// The units that a scenario may name beside SI.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace unlatch::hil {

// A value in a unit is value / divisor · factor of the SI unit `si`. Divisors and factors are exact, so that `12 ms`
// is the double nearest to 0.012.
struct Unit {
  std::string_view name, si;
  double factor, divisor;
};

const Unit* find_unit(std::string_view name, std::string_view si);  // null if it is none for that quantity
std::vector<std::string> list_units(std::string_view si);           // the SI unit first

}  // namespace unlatch::hil
