// Blocks and wrenches on their way from children to their parents, in one fixed order of sums. Compiled once per
// instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/solver/node.h"

namespace unlatch::UNLATCH_ISA {

// Block and wrench that a joint passes to its parent, at the child's origin.
template <class T>
struct Passed {
  ArticulatedT<T> A;
  SpatialT<T> wrench;
};
template <class T>
UNLATCH_INLINE Passed<T> get_nothing() {
  const T o(0.0);
  return {get_body_block(o, Sym3T<T>{o, o, o, o, o, o}), {{o, o, o}, {o, o, o}}};
}

// Sums over the children of one parent, one partial sum per lane: child k is added to the (k mod 8)-th. As wide as the
// first group of siblings in the pass.
struct SiblingSums {
  double numbers[kNumbers<SubtreeBlock> * 8];

  template <int W>
  UNLATCH_INLINE SubtreeBlock<Wide<W>>& from_lane(int lane) {
    return as_block<SubtreeBlock, W>(numbers + lane);
  }
};

// A body's own inertia and wrench, with which the sums at it begin.
template <class V, class T = typename V::T>
UNLATCH_INLINE Passed<T> get_own(const V& v, Source source) {
  return {get_body_block(load<T>(v.constants.solver().mass), load<T>(v.blocks.shared().inertia)),
          get_own_wrench(v, source)};
}

// kFactor: block and wrench; else the wrench alone.
template <bool kFactor, class T, int W>
UNLATCH_INLINE void store(SubtreeBlock<Wide<W>>& to, const Passed<T>& passed) {
  store(to.wrench, passed.wrench);
  if constexpr (kFactor) store(to.A, passed.A);
}
template <bool kFactor, class T, int W>
UNLATCH_INLINE void add(SubtreeBlock<Wide<W>>& to, const Passed<T>& passed) {
  store(to.wrench, load<T>(to.wrench) + passed.wrench);
  if constexpr (kFactor) store(to.A, load<T>(to.A) + passed.A);
}

// The same at the parent's origin.
template <bool kFactor, class T>
UNLATCH_INLINE Passed<T> move(const Passed<T>& passed, const Vec3T<T>& offset) {
  Passed<T> out;
  if constexpr (kFactor) out.A = shift(passed.A, offset);
  out.wrench = shift_wrench(passed.wrench, offset);
  return out;
}

// Begins the blocks of a group with those of its bodies alone.
template <int kWidest, bool kFactor>
UNLATCH_INLINE void begin_block(const PlanData& plan, Evaluation& ev, std::int32_t group, Source source) {
  for_width<kWidest>(plan.groups[at(group)], [&]<class T, int kWidth>() {
    for (int lane = 0; lane < kWidth; lane += T::kWidth) {
      const GroupView<T, kWidth> v(plan, ev, at(group), lane);
      store<kFactor>(v.blocks.subtree(), get_own(v, source));
    }
  });
}

// --- Siblings: their partial sums in a fixed tree --------------------------------------------------------------------

// Sum of one number of the block over the siblings' lanes; `width`: 4 or 8.
UNLATCH_INLINE double sum_lanes(const double* s, int width) {
  const double four = (s[0] + s[1]) + (s[2] + s[3]);
  return width == 4 ? four : four + ((s[4] + s[5]) + (s[6] + s[7]));
}

// Sums of four numbers of the block, each over four lanes: (s0 + s1) + (s2 + s3).
UNLATCH_INLINE Pack<4> sum_lanes(const Pack<4>& r0, const Pack<4>& r1, const Pack<4>& r2, const Pack<4>& r3) {
  const auto add_pairs = [](const Pack<4>& a, const Pack<4>& b) {
    return Pack<4>(__builtin_shufflevector(a.v, b.v, 0, 4, 2, 6)) +
           Pack<4>(__builtin_shufflevector(a.v, b.v, 1, 5, 3, 7));
  };
  const Pack<4> first = add_pairs(r0, r1), last = add_pairs(r2, r3);
  return Pack<4>(__builtin_shufflevector(first.v, last.v, 0, 1, 4, 5)) +
         Pack<4>(__builtin_shufflevector(first.v, last.v, 2, 3, 6, 7));
}
UNLATCH_INLINE Pack<4> sum_four(const double* s, int width) {
  const auto sum_half = [&](const double* h) {
    return sum_lanes(load<Pack<4>>(h), load<Pack<4>>(h + width), load<Pack<4>>(h + 2 * width),
                     load<Pack<4>>(h + 3 * width));
  };
  return width == 4 ? sum_half(s) : sum_half(s) + sum_half(s + 4);
}

// Adds the sums of all siblings to their parent, after their last group.
template <int kWidest, bool kFactor>
UNLATCH_INLINE void close_siblings(const PlanData& plan, Evaluation& ev, const Group& group, Source source,
                                   const SiblingSums& sums) {
  if (group.begins != kNone) begin_block<kWidest, kFactor>(plan, ev, group.begins, source);
  const int width = group.siblings_begin ? group.width : 8;  // of several groups the first to come is full
  const LaneOf<SubtreeLane> to = get_lane<SubtreeLane>(ev.blocks.data(), plan.lane_parents[at(group.first)]);
  int i = kFactor ? 0 : kWrenchIndex;
  if constexpr (kWidest >= 4)
    for (; i + 4 <= kNumbers<SubtreeBlock>; i += 4) {
      const Pack<4> sum = sum_four(sums.numbers + i * width, width);
      double* const first = to.first + i * to.stride;
      if (to.stride == 1)
        store(first, load<Pack<4>>(first) + sum);
      else
        for (int k = 0; k < 4; ++k) first[k * to.stride] += sum.v[k];
    }
  for (; i < kNumbers<SubtreeBlock>; ++i) to.first[i * to.stride] += sum_lanes(sums.numbers + i * width, width);
}

// --- Parents of any link ----------------------------------------------------------------------------------------

template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void add_to_parents(const GroupView<T, kWidth>& v, const Passed<T>& passed, Source source,
                                   SiblingSums& sums) {
  if (v.group.link == ParentLink::kSiblings) {
    if (v.group.siblings_begin) return store<kFactor>(sums.from_lane<kWidth>(v.lane), passed);
    return add<kFactor>(sums.from_lane<8>(v.lane), passed);
  }
  double* blocks = v.ev.blocks.data();
  if (v.group.link == ParentLink::kContiguous) {
    // From the group's first lane on, since an empty lane has its neighbour's parent.
    const Place& first = v.plan.lane_parents[at(v.group.first)];
    SubtreeBlock<Wide<kWidth>>& block =
        as_block<SubtreeBlock, kWidth>(blocks + get_position<SubtreeBlock<double>>(first).first + v.lane);
    if (v.group.begins == kNone) return add<kFactor>(block, passed);
    const GroupView<T, kWidth> parent(v.plan, v.ev, static_cast<std::size_t>(v.group.begins), v.lane);
    const Passed<T> own = get_own(parent, source);
    Passed<T> sum{{}, own.wrench + passed.wrench};
    if constexpr (kFactor) sum.A = own.A + passed.A;
    return store<kFactor>(block, sum);
  }
  double each[kNumbers<SubtreeBlock> * T::kWidth];
  store<kFactor>(as_block<SubtreeBlock, T::kWidth>(each), passed);
  for (int i = 0; i < T::kWidth; ++i) {
    const LaneOf<SubtreeBlock<double>> to = get_lane<SubtreeBlock<double>>(blocks, v.parents[i]);
    const LaneOf<SubtreeBlock<double>> from{each + i, T::kWidth};
    for (int n = kFactor ? 0 : kWrenchIndex; n < kNumbers<SubtreeBlock>; ++n)
      to.first[n * to.stride] += from.first[n * from.stride];
  }
}

}  // namespace unlatch::UNLATCH_ISA
