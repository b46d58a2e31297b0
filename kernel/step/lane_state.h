// Between the state, one structure per body in the model's order, and the lanes.
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// Poses and velocities into the lanes, rest into empty ones, and what the joints' modes make of the groups.
void load_state(const Plan& plan, const State& state, Workspace& ws) noexcept;

// The joints' modes alone: masks of freedoms and rows, offsets, carried axes; ws.phases.
void load_modes(const Plan& plan, const State& state, Workspace& ws) noexcept;

// Poses and velocities out of the lanes into the bodies of `state`.
void store_bodies(const Plan& plan, const Workspace& ws, State& state) noexcept;

}  // namespace unlatch
