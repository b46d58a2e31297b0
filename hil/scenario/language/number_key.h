// A number of the language and its bounds.
#pragma once

#include <cmath>
#include <string_view>

namespace unlatch::hil {

struct NumberKey {
  std::string_view path;  // file of the table, section, key: "scenario.timing.spin"
  std::string_view unit;  // SI; "" for a plain number
  double least, most;
  bool above;  // `least` itself is outside
  bool whole;  // whole numbers only

  bool holds(double value) const {
    return (above ? value > least : value >= least) && value <= most && (!whole || value == std::floor(value));
  }
};

}  // namespace unlatch::hil
