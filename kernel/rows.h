// Right-hand sides of the constraint rows, per joint into ws.bias: what the follower does relative to the base besides
// the joint's freedoms, at the follower's point (`lin`) and about it (`ang`), world axes. All need ws.kinematics and
// ws.frames.
#pragma once

#include "kernel/plan.h"
#include "kernel/workspace.h"

namespace unlatch {

// Acceleration level: H acc = c of (4.11) and (4.12), with the signs of kernel/README.md.
void update_acceleration_bias(const Plan& plan, const State& state, Workspace& ws) noexcept;

// Velocity level: minus the velocity with which the active rows are violated.
void update_velocity_bias(const Plan& plan, const State& state, Workspace& ws) noexcept;

// Position level: minus the gap of the active rows. A single rotation row fixed in the base is non-holonomic and has
// none.
void update_position_bias(const Plan& plan, const State& state, Workspace& ws) noexcept;

// Largest gap of any active row: m or rad. What the projections keep small.
double calc_drift(const Plan& plan, const State& state, const Workspace& ws) noexcept;

}  // namespace unlatch
