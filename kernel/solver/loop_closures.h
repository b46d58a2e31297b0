// The rows of a loop where its two ways have met, see loop_clusters.h: their pivots and multipliers, and what they give
// to the loops that pass on. A block of Λ has the rows of one loop, and in kEight lanes each those of another. Compiled
// once per instruction set, see kernel/simd/pack.h.
#pragma once

#include <algorithm>
#include <utility>

#include "kernel/solver/loop_columns.h"
#include "kernel/solver/loop_rows.h"

namespace unlatch::UNLATCH_ISA {

// Packs of lanes that hold the first `count` rows.
template <class T, class Run>
UNLATCH_INLINE void for_lanes(int count, const Run& run) {
  for (int c = 0; c < count; c += T::kWidth) run(c);
}
// Six numbers per lane.
template <class T>
UNLATCH_INLINE SpatialT<T> load_lanes(const double* F, int c) {
  const auto get = [&](int i) UNLATCH_INLINE_LAMBDA { return load<T>(F + i * kEight + c); };
  return {{get(0), get(1), get(2)}, {get(3), get(4), get(5)}};
}
template <class T>
UNLATCH_INLINE void store_lanes(double* F, int c, const SpatialT<T>& a) {
  store(F + c, a.lin.x);
  store(F + kEight + c, a.lin.y);
  store(F + 2 * kEight + c, a.lin.z);
  store(F + 3 * kEight + c, a.ang.x);
  store(F + 4 * kEight + c, a.ang.y);
  store(F + 5 * kEight + c, a.ang.z);
}
// Zeros; `numbers`: whole rows of lanes. A loop over packs, since g++ makes "rep stos" of a fill, which begins slowly.
template <class T>
UNLATCH_INLINE void clear_lanes(double* to, int numbers) {
  const T o(0.0);
  for (int i = 0; i < numbers; i += T::kWidth) store(to + i, o);
}
// Those of one lane.
UNLATCH_INLINE Spatial get_lane_numbers(const double* F, int r) { return collect<Spatial>(F + r, kEight); }
UNLATCH_INLINE double combine(const double* lanes, const double* weights, int count) {
  double sum = 0;
  for (int r = 0; r < count; ++r) sum += lanes[r] * weights[r];
  return sum;
}
// to −= scale · lanes
template <class T>
UNLATCH_INLINE void subtract_lanes(double* to, int count, double scale, const double* lanes) {
  for_lanes<T>(count,
               [&](int c) UNLATCH_INLINE_LAMBDA { store(to + c, load<T>(to + c) - T(scale) * load<T>(lanes + c)); });
}
// block += scale x yᵀ
template <class T>
UNLATCH_INLINE void add_outer_block(double* block, int rows, int count, double scale, const double* x,
                                    const double* y) {
  for_lanes<T>(count, [&](int c) UNLATCH_INLINE_LAMBDA {
    const T lanes = load<T>(y + c);
    for (int r = 0; r < rows; ++r) {
      double* row = block + r * kEight + c;
      store(row, load<T>(row) + T(scale * x[r]) * lanes);
    }
  });
}

template <class T>
class LoopClosures {
 public:
  LoopClosures(const PlanData& plan, Evaluation& ev) : plan_(plan), ev_(ev) {}

  double* get_numbers(std::int32_t slot) const {
    return ev_.cluster_columns.data() + plan_.loop_slots[at(slot)].numbers;
  }
  double* get_block(std::int32_t block) const {
    return ev_.cluster_matrix.data() + static_cast<std::ptrdiff_t>(block) * kBlockNumbers;
  }

  // Nothing in Λ yet, and the wrenches at the loop's two bodies.
  void begin(const LoopClosure& plan, ClosureWork& c) const {
    clear_lanes<T>(c.own, kEight);
    const auto clear = [&](std::int32_t block) { clear_lanes<T>(get_block(block), c.count * kEight); };
    clear(plan.block);
    for (int i = 0; i < plan.links; ++i) clear(plan_.loop_links[at(plan.first_link + i)].block);
    const JointFrame& f = ev_.non_tree_frames[at(plan.non_tree)];
    for (const bool follower : {true, false}) {
      const std::int32_t slot = follower ? plan.on_follower : plan.on_base;
      if (slot == kNone) continue;
      double* F = get_numbers(slot);
      clear_lanes<T>(F, 6 * kEight);
      for (int k = 0; k < c.count; ++k) spread(F + k, kEight, calc_row_wrench(f, c.row[k], follower));
    }
  }

  // Eliminates a loop: its rows, if kFactor, and their right-hand sides.
  template <bool kFactor>
  void close(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    if (c.count == 0) return;
    if constexpr (kFactor) factor(plan, c);
    reduce_target(plan, c);
    if (plan.slot == kNone) return;
    const double* F = get_numbers(plan.slot);
    const LaneOf<SubtreeLane> body = get_lane<SubtreeLane>(ev_.blocks.data(), plan_.cluster_nodes[at(plan.node)].place);
    Spatial load = body.read(&SubtreeLane::wrench);
    for (int k = 0; k < c.rank; ++k)
      load = load + (c.target[c.order[k]] * c.inverse[k]) * get_lane_numbers(F, c.order[k]);
    body.write(&SubtreeLane::wrench, load);
    if constexpr (kFactor) {
      Articulated A = body.read(&SubtreeLane::A);
      for (int k = 0; k < c.rank; ++k) A = downdated(A, -c.inverse[k], get_lane_numbers(F, c.order[k]));
      body.write(&SubtreeLane::A, A);
    }
  }

  // μ, the last pivot first; `a`: acceleration of the body where the loop closes.
  void find_multipliers(int e, const Spatial* a) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    const double* D = get_block(plan.block);
    const LoopLink* links = plan_.loop_links.data() + plan.first_link;
    for (double& mu : c.mu) mu = 0;
    for (int k = c.rank; k-- > 0;) {
      const int p = c.order[k];
      double left = c.target[p];
      if (a != nullptr) left -= dot(get_lane_numbers(get_numbers(plan.slot), p), *a);
      for (int i = 0; i < plan.links; ++i) {
        const ClosureWork& other = ev_.closures[at(links[i].closure)];
        left -= combine(get_block(links[i].block) + p * kEight, other.mu, other.count);
      }
      for (int j = k + 1; j < c.rank; ++j) left -= D[p * kEight + c.order[j]] * c.mu[c.order[j]];
      c.mu[p] = left * c.inverse[k];
    }
  }

 private:
  // The row whose pivot is largest beside its own entry, ties to the earlier, to the place `rank` of the order.
  static bool find_pivot(ClosureWork& c, const double* D) {
    double largest = kRedundant;
    int best = kNone;
    for (int k = c.rank; k < c.count; ++k) {
      const int r = c.order[k];
      const double pivot = D[r * kEight + r];
      if (pivot > largest * c.own[r] && pivot > kHeldByTree * c.free[r]) {
        largest = pivot / c.own[r];
        best = k;
      }
    }
    if (best != kNone) std::swap(c.order[c.rank], c.order[best]);
    return best != kNone;
  }

  void factor(const LoopClosure& plan, ClosureWork& c) const {
    double* D = get_block(plan.block);
    const LoopLink* links = plan_.loop_links.data() + plan.first_link;
    double* F = plan.slot == kNone ? nullptr : get_numbers(plan.slot);
    for (int r = 0; r < c.count; ++r) c.order[r] = r;
    const int most = std::min(c.count, c.most);
    for (c.rank = 0; c.rank < most && find_pivot(c, D); ++c.rank) {
      const int p = c.order[c.rank];
      const double* row = D + p * kEight;
      const double inverse = 1 / row[p];
      c.inverse[c.rank] = inverse;
      for (int k = c.rank + 1; k < c.count; ++k) {
        const int r = c.order[k];
        const double part = row[r] * inverse;
        subtract_lanes<T>(D + r * kEight, c.count, part, row);
        for (int i = 0; i < plan.links; ++i) {
          double* V = get_block(links[i].block);
          subtract_lanes<T>(V + r * kEight, ev_.closures[at(links[i].closure)].count, part, V + p * kEight);
        }
        if (F == nullptr) continue;
        for (int i = 0; i < 6; ++i) F[i * kEight + r] -= F[i * kEight + p] * part;
      }
    }
    update_links(plan, c, links, F);
  }
  void update_links(const LoopClosure& plan, const ClosureWork& c, const LoopLink* links, const double* F) const {
    const std::int32_t* pair = plan_.loop_pairs.data() + plan.first_pair;
    for (int i = 0; i < plan.links; ++i) {
      const double* left = get_block(links[i].block);
      const int rows = ev_.closures[at(links[i].closure)].count;
      for (int j = i; j < plan.links; ++j, ++pair) {
        if (rows == 0) continue;
        double* block = get_block(*pair);
        const double* right = get_block(links[j].block);
        const int count = ev_.closures[at(links[j].closure)].count;
        for (int k = 0; k < c.rank; ++k)
          add_outer_block<T>(block, rows, count, -c.inverse[k], left + c.order[k] * kEight,
                             right + c.order[k] * kEight);
      }
      if (F == nullptr) continue;
      double* to = get_numbers(links[i].slot);
      for (int k = 0; k < c.rank; ++k)
        for (int n = 0; n < 6; ++n)
          subtract_lanes<T>(to + n * kEight, rows, F[n * kEight + c.order[k]] * c.inverse[k],
                            left + c.order[k] * kEight);
    }
  }
  void reduce_target(const LoopClosure& plan, ClosureWork& c) const {
    const double* D = get_block(plan.block);
    const LoopLink* links = plan_.loop_links.data() + plan.first_link;
    for (int k = 0; k < c.rank; ++k) {
      const int p = c.order[k];
      const double reply = c.target[p] * c.inverse[k];
      for (int j = k + 1; j < c.count; ++j) c.target[c.order[j]] -= D[p * kEight + c.order[j]] * reply;
      for (int i = 0; i < plan.links; ++i) {
        ClosureWork& other = ev_.closures[at(links[i].closure)];
        subtract_lanes<T>(other.target, other.count, reply, get_block(links[i].block) + p * kEight);
      }
    }
  }

  const PlanData& plan_;
  Evaluation& ev_;
};

}  // namespace unlatch::UNLATCH_ISA
