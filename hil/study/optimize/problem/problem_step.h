// The step of a problem with a tolerance: found once before the search, from the start and designs within the bounds,
// and with dispersions from the campaign's corners and samples. All runs of the search are flown at it.
#pragma once

#include <atomic>
#include <optional>

#include "hil/study/optimize/problem/problem.h"

namespace unlatch::hil {

// Finds the step and makes it that of the problem's scenario and campaign, as `set: {step.dt: ...}` would, with what
// was found in `step_search`. Nothing is done without a tolerance. False: none meets it, or `stop` was set.
bool choose_step(OptimizeProblem& problem, int jobs, const std::atomic<bool>& stop);

// Error of a design at the problem's step, from flights at it and at half of it, relative. Nothing: there is no half,
// or `stop` was set.
std::optional<double> calc_step_error(const OptimizeProblem& problem, const OptimizePoint& point,
                                      const std::atomic<bool>& stop);

}  // namespace unlatch::hil
