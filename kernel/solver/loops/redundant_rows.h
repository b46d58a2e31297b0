// The split of reactions where rows of loops are redundant. Their multipliers are not unique: to any of them may be
// added what balances itself, N z with Gᵀ N = 0. Of all sets with the same effect on the bodies, this gives the one of
// least
//   Σ λ² / k,   k the row's stiffness:
// what joints of these stiffnesses carry between rigid bodies (least complementary energy). With equal stiffnesses it
// is the solution of least norm. It is unique, does not depend on which rows were found to be redundant, and is as
// smooth as the motion while their number stays. (On such reactions: García de Jalón and Gutiérrez-López, Multibody
// Syst. Dyn. 30, 2013; Udwadia and Kalaba, Analytical Dynamics, 1996, on the generalised inverse.)
//
// The factor of Λ (loop_rows.h) shows that row d follows from the r independent ones, W_d − X_r W_r = rows of the tree,
// with X_r = L₂₁ L₁₁⁻¹. The tree carries the difference without any acceleration, so statics alone give the rows' parts
// X_t of its joints: a loop's unit force is moved along the loop to each joint of the tree and resolved there. With all
// rows divided by √k, the independent ones' multipliers λ and X = (X_r, X_t),
//   μ = (I + X Xᵀ)⁻¹ X λ = X (I + Xᵀ X)⁻¹ λ   for the redundant rows,   λ − Xᵀ μ for the others.
// The smaller of the two systems is solved; its condition is that of stiffnesses and arms, and no pivot is small. Cost:
// with d redundant and c other rows in loops, O(d c min(d, c) + d r²) beside an O(k³) factor that was there before.
//
// k of a rotation row is that of a point–plane row times a length squared, Joint::share_length.
//
// Near a change of rank a row counts as redundant while its pivot is below kRedundant of its own entry of Λ
// (loop_rows.h): the gap to exact balance is then at most the root of that, 2e-6 of what the row carries. At the
// instant itself the split jumps, as the reactions of such a mechanism do.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// Corrects ev.multipliers, which are a solution for the forces, of loops in one dense matrix, whose factor
// ev.loop_matrix is. Accelerations stay as they are. Loops that are eliminated where they close: split_clusters.h.
void split_dense_rows(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

}  // namespace unlatch
