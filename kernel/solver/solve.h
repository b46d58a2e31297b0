// Accelerations and multipliers, M a = F + Gᵀ λ with G a = c, in O(n): the tree (tree_sweeps.h), and the joints that
// close loops on top of it (loop_rows.h, loop_columns.h). Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/solver/loops/loop_clusters.h"
#include "kernel/solver/loops/loop_columns.h"
#include "kernel/solver/tree_sweeps.h"

namespace unlatch::UNLATCH_ISA {

// The forward pass where joints close loops: the tree's own solution, the loops' rows, and the tree with their
// wrenches.
template <int kWidest>
[[gnu::noinline]] void solve_loops(const PlanData& plan, Evaluation& ev, const Sweep& sweep) {
  const bool holds = ev.loop_count > 0;
  sweep_forth<kWidest>(plan, ev,
                       {.source = sweep.source,
                        .biased = sweep.biased,
                        .multipliers = sweep.multipliers && !holds,
                        .gamma_h = sweep.gamma_h});
  clear_loop_multipliers(plan, ev);
  if (!holds) return;
  solve_loop_rows(plan, ev, sweep.biased);
  store_loop_multipliers(ev);
  const LoopReactions reactions(plan, ev, sweep.source);
  Sweep whole = sweep;
  whole.source = reactions.get_source();
  (void)sweep_back<kWidest, false>(plan, ev, whole);
  sweep_forth<kWidest>(plan, ev, whole);
}

// Both passes while all joints that might close loops have parted.
template <int kWidest, bool kFactor>
int sweep_tree(const PlanData& plan, Evaluation& ev, const Sweep& sweep) {
  if (const int node = sweep_back<kWidest, kFactor>(plan, ev, sweep); node != kNone) return node;
  sweep_forth<kWidest>(plan, ev, sweep);
  if (sweep.multipliers) clear_loop_multipliers(plan, ev);
  return kNone;
}

// Both passes where loops are eliminated where they close.
template <int kWidest, bool kFactor>
[[gnu::noinline]] int sweep_clusters(const PlanData& plan, Evaluation& ev, const Sweep& sweep) {
  if (ev.loop_count == 0) return sweep_tree<kWidest, kFactor>(plan, ev, sweep);
  using Clusters = LoopClusters<Pack<kWidest>>;
  struct Backward {
    Clusters clusters;
    bool biased;
    UNLATCH_INLINE void before(std::size_t g) const { clusters.template close<kFactor>(g); }
    UNLATCH_INLINE void after(std::size_t g) const { clusters.template pass<kFactor>(g, biased); }
  };
  struct Forward {
    Clusters clusters;
    bool multipliers;
    UNLATCH_INLINE void before(std::size_t g) const { clusters.add_reactions(g); }
    UNLATCH_INLINE void after(std::size_t g) const { clusters.finish(g, multipliers); }
  };
  const Clusters clusters(plan, ev);
  if (kFactor) clusters.begin_factor();
  begin_cluster_targets(plan, ev, sweep.biased);
  const int node = sweep_back<kWidest, kFactor>(plan, ev, sweep, Backward{clusters, sweep.biased});
  if (node != kNone) return node;
  clusters.template close_at_ground<kFactor>();
  if (kFactor) count_redundant_rows(ev);
  clusters.find_multipliers_at_ground();
  sweep_forth<kWidest>(plan, ev, sweep, Forward{clusters, sweep.multipliers});
  if (!sweep.multipliers) return kNone;
  clear_loop_multipliers(plan, ev);
  clusters.store_multipliers();
  return kNone;
}

// The forward pass.
template <int kWidest>
UNLATCH_INLINE void finish_solution(const PlanData& plan, Evaluation& ev, const Sweep& sweep) {
  if (plan.loops.empty())
    sweep_forth<kWidest>(plan, ev, sweep);
  else
    solve_loops<kWidest>(plan, ev, sweep);
}

// Factors at the present kinematics, joint frames and modes, and solves. At most `most` rows of loops count as
// independent: stages of a step are slightly off the rows, so that redundant rows contradict each other there; their
// number, and of loops that are eliminated where they close which they are, is that at the beginning of the step.
// Returns kNone, or the node whose pivot vanished.
template <int kWidest>
int factor_and_solve(const PlanData& plan, const State& state, Evaluation& ev, const Sweep& sweep, std::int32_t most) {
  if (!plan.closures.empty()) {
    begin_clusters(plan, state, choose_loop_rows(sweep, most), ev);
    return sweep_clusters<kWidest, true>(plan, ev, sweep);
  }
  if (const int node = sweep_back<kWidest, true>(plan, ev, sweep); node != kNone) return node;
  if (!plan.loops.empty()) {
    update_loop_rows(plan, state, ev);
    if (ev.loop_count > 0) update_loop_matrix<kWidest>(plan, ev);
    factor_loop_matrix<kWidest>(plan, ev, most);
  }
  finish_solution<kWidest>(plan, ev, sweep);
  return kNone;
}

// With the latest factors. With velocity or position targets and no forces it gives velocity or position corrections
// and impulses.
template <int kWidest>
void solve(const PlanData& plan, Evaluation& ev, const Sweep& sweep) {
  if (!plan.closures.empty()) {
    (void)sweep_clusters<kWidest, false>(plan, ev, sweep);
    return;
  }
  (void)sweep_back<kWidest, false>(plan, ev, sweep);
  finish_solution<kWidest>(plan, ev, sweep);
}

}  // namespace unlatch::UNLATCH_ISA
