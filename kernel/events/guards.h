// Values of the events' guards: ≥ 0 where a guard holds.
#pragma once

#include <span>

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// ev.guards: real values for armed events and repeating ones, a large negative number for the others; behind them those
// of pairs of shapes, which touch or part at zero. Needs the evaluation of this instant. `stack`: as long as
// PlanData::guard_depth.
void update_guards(const Instant& now, Evaluation& ev, std::span<double> stack) noexcept;

}  // namespace unlatch
