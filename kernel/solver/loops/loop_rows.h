// Rows of the joints that close loops over the tree, one at a time: k auxiliary rows and a dense k × k matrix
//   Λ μ = c − W a₀,   Λ = W H⁻¹ Wᵀ,   a = a₀ + H⁻¹ Wᵀ μ,
// where row r of W is the pair of unit wrenches that the row puts on its two bodies and a₀ the tree's own solution. The
// tree's pattern is untouched; the cost is O(k n + k² p), p the pivots on the way from the loops to the root, and k³/6.
// A second solve has the rows' wrenches among its loads, so that the multipliers of the tree's joints come out with it.
//
// Rows that follow from the others (a planar four-bar in space, a Bricard linkage) show as vanishing pivots of Λ, which
// takes the most independent first; they are left out here, with a multiplier of 0, and counted.
// redundant_rows.h gives them their part of the reactions.
#pragma once

#include <limits>

#include "kernel/plan/evaluation.h"
#include "kernel/solver/dense_ldl.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

// No limit on the number of rows that may count as independent.
inline constexpr std::int32_t kAllRows = std::numeric_limits<std::int32_t>::max();

// --- Which rows are independent
// A pivot is what the other rows leave of a row's diagonal entry of Λ.
// This small beside the entry: the row follows from those before it, as exactly as geometry is usually given: axes that
// should be parallel and are given with six digits, 3e-7 rad off, leave so much.
inline constexpr double kRedundant = 3e-12;
// This small beside the entries that it is the difference of: rounding, of which redundant rows leave 4 units at most
// (rings of 250 units), and independent ones 20,000 at least (masts of 10,000).
inline constexpr double kRounding = 300 * std::numeric_limits<double>::epsilon();
// This small beside the entry that free bodies would give: the tree alone holds the row.
inline constexpr double kHeldByTree = 1e-13;

inline bool is_beyond_rounding(const RowEntry& row, double pivot) {
  return pivot > kRounding * (row.own + row.lost) && pivot > kHeldByTree * row.free;
}
inline bool is_independent(const RowEntry& row, double pivot) {
  return pivot > kRedundant * row.own && is_beyond_rounding(row, pivot);
}
// Taken for redundant, but not by rounding: rows that are not quite parallel, or inertias beyond those of kRedundant.
inline bool is_nearly_redundant(const RowEntry& row, double pivot) {
  return !(pivot > kRedundant * row.own) && is_beyond_rounding(row, pivot);
}

inline LowerTriangle get_loop_matrix(const PlanData& plan, const Evaluation& ev) {
  return {ev.loop_matrix.data(), plan.loop_columns};
}

// The row that is eliminated as number r.
inline const LoopRow& get_pivot_row(const Evaluation& ev, int r) { return ev.loop_rows[at(ev.loop_rows[at(r)].pivot)]; }
inline LoopRow& find_pivot_row(Evaluation& ev, int r) { return ev.loop_rows[at(ev.loop_rows[at(r)].pivot)]; }

// The unit wrench of a row on one of its bodies, at that body's origin.
inline Spatial calc_row_wrench(const JointFrame& f, int row, bool on_follower) noexcept {
  const bool turns = row >= kRotX;
  const Vec3 axis = turns ? column(f.m, row - kRotX) : column(f.n, row);
  const Vec3 moment = turns ? axis : cross(on_follower ? f.r_follower : f.r_base, axis);
  const Vec3 force = turns ? Vec3{0, 0, 0} : axis;
  return on_follower ? Spatial{force, moment} : Spatial{turns ? force : -force, -moment};
}

// --- Loops that are eliminated where they close (loop_clusters.h)

// Which rows a factorisation has. The stages of a sub-step and its projection take those that were independent at its
// beginning: one choice for the whole sub-step, and less work. Where multipliers are read, all rows take part.
enum class LoopRows {
  kAll,      // that hold
  kLimited,  // likewise; no more of a loop's rows are independent than at the beginning of the sub-step
  kKept,     // those that were independent then
};
inline LoopRows choose_loop_rows(const Sweep& sweep, std::int32_t most) {
  if (most == kAllRows) return LoopRows::kAll;
  return sweep.multipliers ? LoopRows::kLimited : LoopRows::kKept;
}

// The rows of a factorisation, at ev.non_tree_frames.
void begin_clusters(const PlanData& plan, const State& state, LoopRows rows, Evaluation& ev) noexcept;
// Keeps what the sub-step that begins at this evaluation needs of it.
void keep_cluster_rows(Evaluation& ev) noexcept;
void count_redundant_rows(Evaluation& ev) noexcept;
// Of one loop's redundant rows, those that are so only nearly.
std::int32_t count_nearly_redundant_rows(const PlanData& plan, const Evaluation& ev, std::size_t closure) noexcept;
// Right-hand sides of the rows, 0 if not biased.
void begin_cluster_targets(const PlanData& plan, Evaluation& ev, bool biased) noexcept;

// --- One dense matrix of all loops

// The rows that hold in the present modes, with their unit wrenches, at ev.non_tree_frames.
void update_loop_rows(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

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

// While it lives, the bodies' forces have the rows' reactions as well; with kNothing, these alone. The loads of a sweep
// are then those of get_source().
class LoopReactions {
 public:
  LoopReactions(const PlanData& plan, Evaluation& ev, Source source) noexcept;
  ~LoopReactions();
  LoopReactions(const LoopReactions&) = delete;
  LoopReactions& operator=(const LoopReactions&) = delete;

  [[nodiscard]] Source get_source() const { return source_ == Source::kForces ? source_ : Source::kBodyForces; }

 private:
  Evaluation& ev_;
  Source source_;
};

}  // namespace unlatch
