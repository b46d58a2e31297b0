// Right-hand sides of a joint's rows, one joint at a time: for joints that close loops, for drift, for what a mode
// keeps. Joints of the tree get theirs on lanes, by the same formulas (lane_motion.h).
#pragma once

#include "kernel/dispatch/lane_kernels.h"
#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// What the follower does relative to the base besides the joint's freedoms, at the follower's point (`lin`) and about
// it
// (`ang`), world axes. Needs kinematics and the joint's frame.
//   kAcceleration: H acc = c of (4.11) and (4.12), with the signs of kernel/README.md
//   kVelocity:     minus the velocity with which the rows are violated
//   kPosition:     minus their gap. A single rotation row fixed in the base is non-holonomic and has none.
Spatial calc_bias(const Plan& plan, const State& state, const Workspace& ws, int joint, BiasKind kind) noexcept;

// Where axis `a` of the rotation frame has gone in the follower, follower axes, times its weight in the orientation gap
// Σ a × carried: 1 where the two other rotation rows hold, ½ where all three do, 0 elsewhere.
Vec3 calc_carried_axis(const PlanJoint& joint, const JointState& memory, RowSet rows, int a) noexcept;

// Largest gap of any active row: m or rad. What the projections keep small.
double calc_drift(const Plan& plan, const State& state, const Workspace& ws) noexcept;

}  // namespace unlatch
