// Accelerations and multipliers, M a = F + Gᵀ λ with G a = c, in O(n): the tree on lanes (lane_solver.h), and the
// joints that close loops on top of it (loops.h).
#pragma once

#include "kernel/dispatch/lane_kernels.h"
#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// Factors at the present kinematics and joint frames for the modes that were loaded, and solves. Returns kNone, or the
// node whose pivot vanished.
int factor_and_solve(const Plan& plan, const State& state, Workspace& ws, const Sweep& sweep) noexcept;

// With the latest factors. With velocity or position biases and no forces it gives velocity or position corrections and
// impulses.
void solve(const Plan& plan, Workspace& ws, const Sweep& sweep) noexcept;

// Whether what the factorisation took in at a node, masses and arms, was finite.
bool has_finite_block(const Plan& plan, const Workspace& ws, int node) noexcept;

}  // namespace unlatch
