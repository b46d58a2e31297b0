// The block LDLᵀ of the KKT matrix [M −Gᵀ; −G 0] over the tree, in O(n), for whatever rows hold.
//
// Baraff 1996 (CMU-RI-TR-95-44) eliminates, leaves to root, a body block and then the block of its joint's multipliers.
// The same factorisation in closed form: with A the block of a body and all beyond it, and S the freedoms that its
// joint leaves, the multipliers' Schur complement is
//     A − A S (Sᵀ A S)⁻¹ Sᵀ A,
// so a joint with k freedoms is k rank-one downdates (Pivot: s, U = A s, 1/sᵀAs), whichever rows it holds. The block of
// a body that nothing holds is solved by its linear and angular parts. The multipliers come back on the way down as the
// wrench A a − b that crosses the joint. All vectors are in world axes at each body's own origin, so that
// passing to the parent is a translation. About 550 flop per revolute joint and body.
#pragma once

#include "kernel/plan.h"
#include "kernel/workspace.h"

namespace unlatch {

// Factors at ws.kinematics and ws.frames, for the modes in `state`, loops included. Returns kNone, or the node whose
// pivot vanished.
int factor(const Plan& plan, const State& state, Workspace& ws) noexcept;

// Whether what factor() took in at a node, masses and arms, was finite.
bool has_finite_block(const Plan& plan, const Workspace& ws, int node) noexcept;

// Accelerations and multipliers for ws.forces and ws.bias, with the latest factor(): M a = F + Gᵀ λ, rows as biased.
// With velocity or position biases and no forces the same call gives velocity or position corrections and impulses.
void solve(const Plan& plan, Workspace& ws) noexcept;

// The tree's own solution for the loads that stand in ws.factors, with or without the rows' biases: what solve() and
// the columns of the loops are made of.
enum class Bias { kApplied, kIgnored };
void sweep(const Plan& plan, Workspace& ws, Bias bias) noexcept;

}  // namespace unlatch
