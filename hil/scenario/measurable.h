// The quantities of a scenario that requirements can be about, each with its unit.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct Measurable {
  std::string name;  // "reaction.nose1.x", "rate.core", "time.release:booster1"; unique in a scenario
  std::string unit;  // SI; "" for a plain number
  std::string text;  // as a requirement writes it: "reaction: {joint: nose1, row: x}"
};

// In the order of Requirement::Measure. Of those that have a choice of directions and frames (rate, velocity, position,
// axes) one for each body; of clearances those of the pairs that the scenario watches.
std::vector<Measurable> list_measurables(const Scenario& scenario);

// The unit of a requirement's value, SI, from its quantity, subject and axis.
std::string get_unit(const Requirement& requirement, const Model& model);

}  // namespace unlatch::hil
