// Values of the events' guards: ≥ 0 where a guard holds.
#pragma once

#include <span>

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Computes ev.guards from the rest of the evaluation: values for armed and repeating events, a large negative number
// for others; then those of pairs of shapes, which touch or part at zero. `stack`: PlanData::guard_depth numbers of
// scratch.
//
void update_guards(const Instant& now, Evaluation& ev, std::span<double> stack) noexcept;

// True if the guards with which a step ends are those with which the next one begins, if that has the same commands: no
// forces are evaluated anew for it, and no round of rigid contacts follows the latest guards.
inline bool keeps_guards(const PlanData& plan) noexcept { return !plan.commanded_loads && plan.rigid_pairs == 0; }

}  // namespace unlatch
