// The rows of a loop where its two ways have met, see loop_clusters.h: their pivots and multipliers, and what they add
// to the loops that pass on. A block of Λ has the rows of one loop, and as columns those of another. Compiled once per
// instruction set, see kernel/simd/pack.h.
#pragma once

#include <algorithm>
#include <utility>

#include "kernel/solver/loops/columns.h"
#include "kernel/solver/loops/loop_rows.h"
#include "kernel/tree/loop_storage.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
class LoopClosures {
 public:
  using Numbers = LoopColumns<T>;

  LoopClosures(const PlanData& plan, Evaluation& ev) : plan_(plan), ev_(ev) {}

  const ClosureWork& get_work(std::int32_t closure) const { return ev_.closures[at(closure)]; }
  // What a loop has at a node, SlotRows.
  Numbers get_numbers(std::int32_t slot) const {
    const LoopSlot& s = plan_.loop_slots[at(slot)];
    return {ev_.cluster_columns.data() + s.numbers, kEight, get_work(s.closure).count};
  }
  // A block of Λ; `columns`: the loop of its columns.
  Numbers get_block(std::int32_t block, std::int32_t columns) const {
    return {find_loop_block(ev_.cluster_matrix, block), kEight, get_work(columns).count};
  }
  Numbers get_block(const LoopLink& link) const { return get_block(link.block, link.closure); }

  // Nothing in Λ yet, and the wrenches at the loop's two bodies.
  void begin(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    for (double* sum : {c.own, c.lost}) Numbers(sum, kEight, c.count).clear(1);
    get_block(plan.block, e).clear(c.count);
    for (const LoopLink& link : get_links(plan)) get_block(link).clear(c.count);
    const JointFrame& f = ev_.non_tree_frames[at(plan.non_tree)];
    for (const bool follower : {true, false}) {
      const std::int32_t slot = follower ? plan.on_follower : plan.on_base;
      if (slot == kNone) continue;
      const Numbers F = get_numbers(slot);
      F.clear(SlotRows::kWrenches);
      for (int k = 0; k < c.count; ++k) F.set_column(k, calc_row_wrench(f, c.row[k], follower));
    }
  }

  // Eliminates a loop: its rows, if kFactor, and their right-hand sides.
  template <bool kFactor>
  void close(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    if (c.count == 0) return;
    if constexpr (kFactor) factor(e);
    reduce_target(e);
    if (plan.slot == kNone) return;
    const Numbers F = get_numbers(plan.slot);
    const LaneOf<SubtreeLane> body = get_lane<SubtreeLane>(ev_.blocks.data(), plan_.cluster_nodes[at(plan.node)].place);
    Spatial load = body.read(&SubtreeLane::wrench);
    for (int k = 0; k < c.rank; ++k) load = load + (c.target[c.order[k]] * c.inverse[k]) * F.get_column(c.order[k]);
    body.write(&SubtreeLane::wrench, load);
    if constexpr (kFactor) {
      Articulated A = body.read(&SubtreeLane::A);
      for (int k = 0; k < c.rank; ++k) A = downdated(A, -c.inverse[k], F.get_column(c.order[k]));
      body.write(&SubtreeLane::A, A);
    }
  }

  // μ, the last pivot first; `a`: acceleration of the body where the loop closes.
  void find_multipliers(int e, const Spatial* a) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    const Numbers D = get_block(plan.block, e);
    for (double& mu : c.mu) mu = 0;
    for (int k = c.rank; k-- > 0;) {
      const int p = c.order[k];
      double left = c.target[p];
      if (a != nullptr) left -= dot(get_numbers(plan.slot).get_column(p), *a);
      for (const LoopLink& link : get_links(plan)) {
        const ClosureWork& other = get_work(link.closure);
        left -= combine(get_block(link).row(p), other.mu, other.count);
      }
      for (int j = k + 1; j < c.rank; ++j) left -= D.row(p)[c.order[j]] * c.mu[c.order[j]];
      c.mu[p] = left * c.inverse[k];
    }
  }

 private:
  std::span<const LoopLink> get_links(const LoopClosure& plan) const {
    return {plan_.loop_links.data() + plan.first_link, static_cast<std::size_t>(plan.links)};
  }

  // The independent row whose pivot is largest beside its own entry, ties to the earlier, to the place `rank` of the
  // order.
  static bool find_pivot(ClosureWork& c, const Numbers& D) {
    double largest = 0;
    int best = kNone;
    for (int k = c.rank; k < c.count; ++k) {
      const int r = c.order[k];
      const double pivot = D.row(r)[r];
      if (pivot > largest * c.own[r] && is_independent(c.get_entry(r), pivot)) {
        largest = pivot / c.own[r];
        best = k;
      }
    }
    if (best != kNone) std::swap(c.order[c.rank], c.order[best]);
    return best != kNone;
  }

  void factor(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    const Numbers D = get_block(plan.block, e);
    for (int r = 0; r < c.count; ++r) c.order[r] = r;
    const int most = std::min(c.count, c.most);
    for (c.rank = 0; c.rank < most && find_pivot(c, D); ++c.rank) {
      const int p = c.order[c.rank];
      const double inverse = 1 / D.row(p)[p];
      c.inverse[c.rank] = inverse;
      for (int k = c.rank + 1; k < c.count; ++k) eliminate(plan, c, D, p, c.order[k], D.row(p)[c.order[k]] * inverse);
    }
    update_links(plan, c);
  }
  // Row r −= part · row p
  void eliminate(const LoopClosure& plan, ClosureWork& c, const Numbers& D, int p, int r, double part) const {
    c.lost[r] += part * part * c.own[p];
    subtract<T>(D.row(r), c.count, part, D.row(p));
    for (const LoopLink& link : get_links(plan)) {
      const Numbers V = get_block(link);
      subtract<T>(V.row(r), V.get_count(), part, V.row(p));
    }
    if (plan.slot == kNone) return;
    const Numbers F = get_numbers(plan.slot);
    F.set_column(r, F.get_column(r) - part * F.get_column(p));
  }
  void update_links(const LoopClosure& plan, const ClosureWork& c) const {
    if (c.rank == 0) return;
    const std::span<const LoopLink> links = get_links(plan);
    const std::int32_t* pair = plan_.loop_pairs.data() + plan.first_pair;
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Numbers left = get_block(links[i]);
      ClosureWork& other = ev_.closures[at(links[i].closure)];
      if (other.count == 0) {
        pair += links.size() - i;
        continue;
      }
      double x[kRows][kEight];
      for (int k = 0; k < c.rank; ++k)
        for (int r = 0; r < other.count; ++r) x[k][r] = -c.inverse[k] * left.row(c.order[k])[r];
      for (std::size_t j = i; j < links.size(); ++j, ++pair) {
        const Numbers block = get_block(*pair, links[j].closure), right = get_block(links[j]);
        const double* y[kRows];
        for (int k = 0; k < c.rank; ++k) y[k] = right.row(c.order[k]);
        block.add_outers(other.count, c.rank, x, y);
      }
      add_lost(c, left, other);
      if (plan.slot != kNone) update_wrenches(c, get_numbers(plan.slot), left, get_numbers(links[i].slot));
    }
  }
  // By the pivots, which the rows of another loop meet with `left`.
  static void add_lost(const ClosureWork& c, const Numbers& left, ClosureWork& other) {
    for_packs<T>(other.count, [&](int i) UNLATCH_INLINE_LAMBDA {
      T lost = load<T>(other.lost + i);
      for (int k = 0; k < c.rank; ++k) {
        const T part = left.get(c.order[k], i) * T(c.inverse[k]);
        lost = lost + (part * part) * T(c.own[c.order[k]]);
      }
      store(other.lost + i, lost);
    });
  }
  // Wrenches `to` of another loop, by those of this one.
  static void update_wrenches(const ClosureWork& c, const Numbers& F, const Numbers& left, const Numbers& to) {
    to.for_packs([&](int i) UNLATCH_INLINE_LAMBDA {
      for (int n = 0; n < SlotRows::kWrenches; ++n) {
        T wrench = to.get(n, i);
        for (int k = 0; k < c.rank; ++k)
          wrench = wrench - T(F.row(n)[c.order[k]] * c.inverse[k]) * left.get(c.order[k], i);
        to.set(n, i, wrench);
      }
    });
  }
  void reduce_target(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    const Numbers D = get_block(plan.block, e);
    for (int k = 0; k < c.rank; ++k) {
      const int p = c.order[k];
      const double reply = c.target[p] * c.inverse[k];
      for (int j = k + 1; j < c.count; ++j) c.target[c.order[j]] -= D.row(p)[c.order[j]] * reply;
      for (const LoopLink& link : get_links(plan)) {
        ClosureWork& other = ev_.closures[at(link.closure)];
        subtract<T>(other.target, other.count, reply, get_block(link).row(p));
      }
    }
  }

  const PlanData& plan_;
  Evaluation& ev_;
};

}  // namespace unlatch::UNLATCH_ISA
