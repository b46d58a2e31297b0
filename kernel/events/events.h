// Events at one instant: which are due, and what their actions do. The instant is located by event_search.h.
#pragma once

#include "kernel/integration/run.h"

namespace unlatch {

// The earliest time after `now` at which an event is known to act, by the end of its delay or by a plain time guard;
// infinite if there is none.
double calc_next_due(const PlanData& plan, const State& state, double now) noexcept;

// Executes all events that are due at time `now`, in rounds: those whose guards hold, in the order of their index;
// then, after a new evaluation, those that hold as a consequence. An event acts once at an instant. The evaluation is
// of the state before and after, guards included. `tolerances`: in the first round a guard holds from this much below
// zero on. On kSingular `run.node` is the node whose pivot vanished.
StepStatus act(Run& run, double now, std::span<const double> tolerances) noexcept;

// Arms repeating events again once their guards are negative. Sets the edge of a pair of shapes back to zero once its
// distance is beyond the edge of its last change.
void rearm(const PlanData& plan, State& state, Evaluation& ev) noexcept;

}  // namespace unlatch
