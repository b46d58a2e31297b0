// The variables of an FMU: the channels of a scenario as inputs; sensors, reactions, bodies and clearances as outputs.
// The description and the running FMU make the same list from the same scenario.
//
//   value reference   0: time; 1 + i: channel i; then sensors, reactions, bodies, clearances, numbered on
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "library/include/unlatch.h"

namespace unlatch::fmi {

struct Variable {
  std::string name, unit;                      // "sensors.gyro.x", "rad/s"
  std::string description;                     // for people
  bool input = false;                          // else an output
  double start = 0, minimum = 0, maximum = 0;  // of inputs
  const double* data = nullptr;                // present value; null for time
};

// The first is the independent variable `time`. Empty after an error of the library.
std::vector<Variable> list_variables(unlatch_simulation* simulation);

}  // namespace unlatch::fmi
