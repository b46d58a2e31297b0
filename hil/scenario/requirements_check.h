// Requirements that no run of a scenario can evaluate, reported before it runs.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct RequirementProblem {
  std::size_t requirement = 0;  // index into Scenario::requirements
  std::string what, mend;
};

// Finds events that are disabled, that cannot occur before the end of the run, or before the beginning of their own
// interval, and rows that no mode of their joint holds.
std::vector<RequirementProblem> find_problems(const Scenario& scenario);

// Finds limits that every run meets: a lower limit of 0 or less for sizes, absolute values and times, an upper limit of
// pi for angles between axes, a limit of the other sign for the force of a pusher, stop or cord.
std::vector<RequirementProblem> find_trivial(const Scenario& scenario);

}  // namespace unlatch::hil
