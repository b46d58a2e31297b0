// Rows of the joints that close loops over the tree, one at a time: k auxiliary rows and a dense k × k matrix
//   Λ μ = c − W a₀,   Λ = W H⁻¹ Wᵀ,   a = a₀ + H⁻¹ Wᵀ μ,
// where row r of W is the pair of unit wrenches that the row puts on its two bodies and a₀ the tree's own solution. The
// tree's pattern is untouched; the cost is O(k n + k² p), p the pivots on the way from the loops to the root, and k³/6.
// A second solve has the rows' wrenches among its loads, so that the multipliers of the tree's joints come out with it.
//
// Rows that follow from the others (a planar four-bar in space, a Bricard linkage) show as vanishing pivots of Λ, which
// takes the most independent first; they are left out here, with a multiplier of 0, and counted.
// split_redundant_rows() gives them their part of the reactions (redundant_rows.h).
#pragma once

#include <limits>

#include "kernel/plan/evaluation.h"
#include "kernel/solver/dense_ldl.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

// No limit on the number of rows that may count as independent.
inline constexpr std::int32_t kAllRows = std::numeric_limits<std::int32_t>::max();

// A pivot this small beside the row's own diagonal entry: the row follows from those before it.
inline constexpr double kRedundant = 1e-10;
// An entry this small beside the one that free bodies would give is rounding: the tree alone holds the row.
inline constexpr double kHeldByTree = 1e-13;

inline LowerTriangle get_loop_matrix(const PlanData& plan, const Evaluation& ev) {
  return {ev.loop_matrix.data(), plan.loop_columns};
}

// The row that is eliminated as number r.
inline const LoopRow& get_pivot_row(const Evaluation& ev, int r) { return ev.loop_rows[at(ev.loop_rows[at(r)].pivot)]; }

// The rows that hold in the present modes, with their unit wrenches; needs the joints' frames.
void update_loop_rows(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

// Loops that are eliminated where they close (loop_clusters.h). Their rows, after update_loop_rows(); `limited`: no more
// of a loop's rows are independent than at the beginning of the sub-step, which keep_cluster_ranks() keeps.
void begin_clusters(const PlanData& plan, Evaluation& ev, bool limited) noexcept;
void keep_cluster_ranks(Evaluation& ev) noexcept;
void count_redundant_rows(Evaluation& ev) noexcept;
// Right-hand sides of their rows, 0 if not biased.
void begin_cluster_targets(Evaluation& ev, bool biased) noexcept;

// Takes every row for independent so far, and keeps its diagonal entry of Λ.
void begin_pivots(const PlanData& plan, Evaluation& ev) noexcept;
// The row, from `first` on, whose pivot is largest beside its own diagonal entry, ties to the earlier; kNone if all of
// them follow from the rows before.
int find_pivot(const PlanData& plan, const Evaluation& ev, int first) noexcept;
// Eliminates row `r` as number `rank`.
void take_pivot(const PlanData& plan, Evaluation& ev, int rank, int r) noexcept;

// μ, in ev.loop_solution, from the tree's own solution: accelerations that the rows ask for (if biased) less those that
// are there, through the factor of Λ; 0 for redundant rows.
void solve_loop_rows(const PlanData& plan, Evaluation& ev, bool biased) noexcept;

// Sets the multipliers of all non-tree joints: 0, or those of their rows.
void clear_loop_multipliers(const PlanData& plan, Evaluation& ev) noexcept;
void store_loop_multipliers(Evaluation& ev) noexcept;

// Adds the rows' wrenches to the bodies' forces; with kNothing they are all that pushes. Whatever evaluates forces
// overwrites them.
void add_loop_forces(const PlanData& plan, Evaluation& ev, Source source) noexcept;

}  // namespace unlatch
