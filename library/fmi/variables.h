// Variables of an FMU: the channels of a scenario as inputs; sensors, reactions, bodies and clearances as outputs; its
// constants, and its literal numbers, as parameters. The description and the running FMU make the same list from the
// same scenario.
//
//   value reference   0: time; 1 + i: channel i; then sensors, reactions, bodies, clearances, constants, numbers,
//                     counted on
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "library/include/unlatch.h"

namespace unlatch::fmi {

struct Variable {
  std::string name, unit;   // "sensors.gyro.x", "rad/s"
  std::string description;  // text for people
  enum class Causality { kIndependent, kInput, kParameter, kOutput };
  Causality causality = Causality::kOutput;
  double start = 0;                 // start of inputs and parameters
  double minimum = 0, maximum = 0;  // limits of inputs
  const double* data = nullptr;     // present value; null for time and parameters
};

// Lists variables; the first is the independent variable `time`. Empty after an error of the library.
std::vector<Variable> list_variables(unlatch_simulation* simulation);

}  // namespace unlatch::fmi
