// Requirements that no run of a scenario can evaluate, told before it runs.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct RequirementProblem {
  std::size_t requirement = 0;  // index into Scenario::requirements
  std::string what, mend;
};

// Events that are left out, that cannot occur before the end of the run, or before the beginning of their own interval;
// rows that no mode of their joint holds.
std::vector<RequirementProblem> find_problems(const Scenario& scenario);

// Limits that every run keeps: sizes, absolute values and times that shall be at least 0 or less, angles between axes
// that shall be at most pi.
std::vector<RequirementProblem> find_trivial(const Scenario& scenario);

}  // namespace unlatch::hil
