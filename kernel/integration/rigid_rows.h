// Closed rigid contacts in the equations of motion: a few rows W on top of whatever tree and loops solve,
//
//   a = a₀ + H⁻¹ Wᵀ f,   Λ f = c − W a₀,   Λ = W H⁻¹ Wᵀ,
//
// where H⁻¹ is the latest factor, joints' rows and loops included, a₀ the solution without contacts, and c what the
// rows ask for: −bias of accelerations, −gap of displacements, −rate of velocities. Each column of Λ is one back-solve,
// one more has the forces among its loads, so that the joints' multipliers come out with it.
//
// Rows that follow from those before them (four feet on a floor) are found by vanishing pivots, in the order of the
// pairs. Their forces are not decided by rigid bodies; of all forces with one effect those of least Σ f² are taken, as
// if all contacts were equally stiff: with Λ = L D Lᵀ, L having a column per independent row,
//
//   f = L (LᵀL)⁻¹ D⁻¹ (LᵀL)⁻¹ Lᵀ (c − W a₀).
//
// A row that the joints hold by themselves has no force: they bear what there is.
//
// A redundant row says what its gap does: a surface that turns away under a foot leaves it a surplus of acceleration
// inwards or outwards, which no force changes while the others hold. Outwards the row itself has to open, inwards one
// of those that it follows from with a positive weight; their forces are reported as negative, so that they do. Stages
// and projections of a sub-step have the rows that were independent at its beginning, as loops do.
//
// Cost: for n closed pairs n + 1 back-solves a solution, and n³. Nothing where none is closed.
#pragma once

#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

enum class RigidTarget { kAcceleration, kPosition, kVelocity };

// Stands for a node whose pivot vanished, where it was a rigid contact that failed: Evaluation::rigid.failed.
inline constexpr int kRigidFailure = -2;

// Some pair of a rigid contact may be closed.
inline bool has_rigid_rows(const PlanData& plan) { return plan.rigid_pairs > 0; }

// Rows of ev.rigid.rows.
using RigidSet = std::uint64_t;  // bit r: row r
static_assert(kMostRigidRows <= 64, "each row has a bit");
inline constexpr RigidSet kAllRigidRows = ~RigidSet{0};
inline bool has_rigid(RigidSet set, int r) { return (set >> r & 1) != 0; }
// Those that were independent in the latest solution.
RigidSet get_independent_rigid_rows(const Evaluation& ev) noexcept;

// Adds the closed rigid contacts, those in `set`, to the latest solution, which is of `sweep` and of the latest factor.
// With accelerations the forces remain among those of the bodies, in ev.pair_forces and in the contacts' totals; the
// gaps are in ev.pair_distances. Returns kNone or kRigidFailure.
int solve_rigid_rows(const Instant& now, RigidTarget target, const Sweep& sweep, RigidSet set, Evaluation& ev) noexcept;

// Λ of ev.rigid.rows, by the latest factor.
void update_rigid_matrix(const PlanData& plan, double gamma_h, Evaluation& ev) noexcept;

// Of the rows in `set`, the forces f that give them ev.rigid.loads, in ev.rigid.forces; 0 for all others.
void solve_rigid_set(RigidSet set, Evaluation& ev) noexcept;

// The row that has to leave the set of the latest solve_rigid_set(), because a redundant row's load is not met: itself
// if it gets more, else the first of those that it follows from with a positive weight; kNone if all are met to within
// `tolerance`.
int find_contradiction(RigidSet set, double tolerance, Evaluation& ev) noexcept;

// Bodies' forces are those of the rows alone, as Source::kBodyForces takes them.
void set_rigid_impulses(const PlanData& plan, Evaluation& ev) noexcept;

}  // namespace unlatch
