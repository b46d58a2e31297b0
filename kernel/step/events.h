// Events at one instant: which are due, and what their actions do. Locating the instant is step.cc's part.
#pragma once

#include "kernel/dynamics/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Times nearer than this part of a step are one instant.
inline constexpr double kSameInstant = 1e-9;

// The earliest time after `now` at which an event is known to act: a delay that runs out or a plain time guard;
// infinite if there is none.
double calc_next_due(const PlanData& plan, const State& state, double now) noexcept;

// Lets every event act that is due at time `now`, in rounds: all that hold, in the order of their index; then, with the
// state that they left evaluated anew, those that hold because of it. An event acts once at an instant. Takes and
// leaves an evaluation of `state`, guards included. `tolerances`: how far below zero each guard may stand in the first
// round. `node`: where a pivot vanished.
StepStatus act(const PlanData& plan, const Inputs& inputs, double now, std::span<const double> tolerances, State& state,
               Evaluation& ev, EventSearch& search, int& node) noexcept;

// Arms repeating events again whose guards have gone negative; pairs of shapes that have gone beyond the edge of their
// last change have it at zero again.
void rearm(const PlanData& plan, State& state, Evaluation& ev) noexcept;

}  // namespace unlatch
