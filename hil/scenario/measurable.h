// Quantities of a scenario for use in requirements, each with its unit.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct Measurable {
  std::string name;  // "reaction.nose1.x", "rate.core", "time.release:booster1"; unique in a scenario
  std::string unit;  // SI; "" for a plain number
  std::string text;  // text of a requirement: "reaction: {joint: nose1, row: x}"
};

// Lists quantities in the order of Requirement::Measure. Quantities with a choice of directions and frames (rate,
// velocity, position, axes) appear once for each body; clearances for the watched pairs of the scenario.
std::vector<Measurable> list_measurables(const Scenario& scenario);

// Unit of a requirement's value, SI, from its quantity, subject and axis.
std::string get_unit(const Requirement& requirement, const Model& model);

}  // namespace unlatch::hil
