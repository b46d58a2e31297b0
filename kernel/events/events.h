// Events at one instant: which are due, and what their actions do. The instant is located by event_search.h.
#pragma once

#include "kernel/integration/run.h"

namespace unlatch {

// The earliest time after `now` at which an event is known to act: a delay that runs out or a plain time guard;
// infinite if there is none.
double calc_next_due(const PlanData& plan, const State& state, double now) noexcept;

// Lets every event act that is due at time `now`, in rounds: all that hold, in the order of their index; then, with the
// state that they left evaluated anew, those that hold because of it. An event acts once at an instant. Takes and
// leaves an evaluation of the state, guards included. `tolerances`: how far below zero each guard may stand in the
// first round. On kSingular `run.node` is the node whose pivot vanished.
StepStatus act(Run& run, double now, std::span<const double> tolerances) noexcept;

// Arms repeating events again whose guards have gone negative; sets the edge of pairs of shapes back to zero that have
// gone beyond the edge of their last change.
void rearm(const PlanData& plan, State& state, Evaluation& ev) noexcept;

}  // namespace unlatch
