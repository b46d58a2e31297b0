// Springs of a scenario as they begin.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"
#include "unlatch/readings.h"

namespace unlatch::hil {

// A spring, pusher or torsion spring at the start.
struct SpringStart {
  std::string name;
  bool on = false;
  bool angular = false;  // length, stroke in rad and force in N m
  ElementStart start;
};
// All elements of a scenario that store energy, in their order.
std::vector<SpringStart> list_springs(const Scenario& scenario);

}  // namespace unlatch::hil
