// What happens at one instant: which events are due, and what their actions do. Locating the instant is step.cc's part.
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"
#include "unlatch/step.h"

namespace unlatch {

// Times nearer than this part of a step are one instant.
inline constexpr double kSameInstant = 1e-9;

// The earliest time after `now` at which an event is known to act: a delay that runs out or a plain time guard;
// infinite if there is none.
double calc_next_due(const Plan& plan, const State& state, double now) noexcept;

// Lets every event act that is due at `now`, in rounds: all that hold, in the order of their index; then, with the
// state that they left evaluated afresh, those that hold because of it. An event acts once at an instant. Needs
// ws.guards and an evaluation of `state`, and leaves the same for the state after it. `node`: where a pivot vanished.
StepStatus act(const Plan& plan, const Inputs& inputs, double now, State& state, Workspace& ws, int& node) noexcept;

// Arms repeating events again whose guards have gone negative.
void rearm(const Plan& plan, State& state, const Workspace& ws) noexcept;

}  // namespace unlatch
