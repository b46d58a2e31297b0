// The solver of the kernel, M a = F + Gᵀ λ with G a = c, for one body after the other and with plain 6×6 matrices: what
// kernel/solver computes in groups, lanes and closed forms, to be read in one sitting. Tests compare it with the
// kernel's sweeps and with a dense solve.
//
// **The tree.** Let A be the inertia of a body and of all that is outboard of it, as far as its joints pass it on, and
// p the load (force and torque) likewise; both in world axes, at the body's own origin. At first they are the body's
// own, diag(m 1, J) and F. From the leaves to the root, the joint between a child and its parent passes on Â and p̂:
//
//   three rows or more hold: the k freedoms S are eliminated (Featherstone's articulated body; c: what the rows
//   prescribe)
//       p' = p − A c,   Â = A − A S (Sᵀ A S)⁻¹ Sᵀ A,   p̂ = p' − A S (Sᵀ A S)⁻¹ Sᵀ p'
//     one freedom s at a time, each from what the one before has left:  U = A s,  d = sᵀ U,  β = sᵀ p',
//       A ← A − U Uᵀ / d,   p' ← p' − U β / d
//   one or two rows W hold: the body is eliminated, then its rows
//       Â = W Λ⁻¹ Wᵀ,   p̂ = W Λ⁻¹ Wᵀ (A⁻¹ p − c),   Λ = Wᵀ A⁻¹ W
//   no row holds: nothing.
//
// Both formulas give the same for any number of rows; each is used where it inverts the smaller matrix. The parent
// takes them at its own origin: with the offset r from there to the child's, a motion of the parent is X = (1 −r̃; 0 1)
// at the child, so that A_parent += Xᵀ Â X, p_parent += Xᵀ p̂.
//
// From the root to the leaves the accelerations follow, with a_X = X a_parent (0 at the ground):
//   through freedoms   a = a_X, then for each freedom, the last to be eliminated first,  q = (β − Uᵀ a) / d,  a ← a + s
//   q;
//                      in the end  a ← a + c
//   through rows       a = A⁻¹ p + A⁻¹ W Λ⁻¹ Wᵀ (a_X + c − A⁻¹ p)
// The joint's wrench on the child is A a − p; its components along the rows are λ.
//
// **Loops.** A joint that closes a loop is no edge of the tree. Each of its rows is a pair of unit wrenches w on two
// bodies. With a_w the tree's answer to w alone, and a₀ its answer to the loads,
//   Λ_rs = w_r · a_ws,   Λ μ = c − w · a₀,   a = a₀ + Σ μ_r a_wr,   and λ of the tree's joints likewise.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kernel/plan/evaluation.h"

namespace unlatch::test {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Solution: of bodies in world axes, at their origins; of joints by Row, 0 where no row holds.
struct ScalarSolution {
  std::vector<Vector6> accelerations;  // per body: linear, angular
  std::vector<Vector6> multipliers;    // per joint
};

// For rigid bodies of constant mass without implicit springs. `ev` has kinematics, joint frames, and forces to which no
// solve has added reactions of loops yet: update_forces().
ScalarSolution solve_one_by_one(const PlanData& plan, const State& state, const Evaluation& ev);

}  // namespace unlatch::test
