// Values of quantities at the start of a run: for `unlatch check --quantities`.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct StartingQuantity {
  std::string name;  // of one that the scenario names; empty for one that it may name
  std::string unit;  // "1" for a plain number
  std::string text;  // how it is written: "velocity: {body: pod}"
  double value = 0;  // in its unit
};

// The scenario's named quantities, then those that it may name (list_possible_quantities()).
std::vector<StartingQuantity> list_starting_quantities(const Scenario& scenario);

}  // namespace unlatch::hil
