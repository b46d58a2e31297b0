// Flights of two designs, for those who look at them: what quantities do over time.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "hil/study/optimize/problem/problem.h"

namespace unlatch::tools {

struct OptimizeCurve {
  std::string name, unit;
  std::vector<double> times;   // s
  std::vector<double> values;  // NaN outside a requirement's interval
};

// The requirement of this id in a scenario; none: the campaign's alone has it.
std::optional<std::size_t> find_requirement(const hil::Scenario& scenario, const std::string& id);

// The nominal scenario at this point, flown once: a curve for each constraint, empty for those of events, where the
// design makes no valid scenario, and if `stop` was set. If all constraints are of events, or there are none, curves of
// the scenario's requirements follow, or, if it has none over time, of clearances, else of the bodies' velocities. Of
// long flights the least and the greatest value of each interval of time are kept.
std::vector<OptimizeCurve> fly_point(const hil::OptimizeProblem& problem, const hil::OptimizePoint& point,
                                     const std::atomic<bool>& stop);

}  // namespace unlatch::tools
