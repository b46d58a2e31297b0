// What children add to their parents: blocks and loads on their way to the root, and what a parent's begin with.
// Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/lane_node.h"

namespace unlatch::UNLATCH_ISA {

// What a joint passes to its parent, at the child's origin.
template <class T>
struct Passed {
  ArticulatedT<T> A;
  SpatialT<T> load;
};

// Sums over the children of one parent, one partial sum per lane; child k counts towards the (k mod 8)-th.
struct FanSums {
  double numbers[kBlockFields * 8];
};

// Adds to 27 rows, `kStride` numbers apart, or writes them: block and load as the parent sees them.
template <bool kFactor, bool kAdd, int kStride, class T>
// NOLINTNEXTLINE(readability-non-const-parameter): it is written to, through the view
UNLATCH_INLINE void accumulate(double* rows, const Passed<T>& passed, const Vec3T<T>& offset) {
  const View<T, kStride> sum{rows, nullptr};
  const auto put = [&](int row, const Vec3T<T>& a) {
    if constexpr (kAdd)
      sum.set(row, sum.get_vec(row) + a);
    else
      sum.set(row, a);
  };
  put(21, passed.load.lin);
  put(24, passed.load.ang + cross(offset, passed.load.lin));
  if constexpr (kFactor) {
    const ArticulatedT<T> A = shift(passed.A, offset);
    put(0, {A.M.xx, A.M.yy, A.M.zz});
    put(3, {A.M.xy, A.M.xz, A.M.yz});
    put(6, A.H.x);
    put(9, A.H.y);
    put(12, A.H.z);
    put(15, {A.I.xx, A.I.yy, A.I.zz});
    put(18, {A.I.xy, A.I.xz, A.I.yz});
  }
}

template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void add_to_parents(const Part<T, kWidth>& part, const Passed<T>& passed, FanSums& fan) {
  const Vec3T<T> offset = part.v.get_vec(kOffset);
  if (part.group.link == LaneLink::kFan) {
    if (part.group.fan_begins) return accumulate<kFactor, false, kWidth>(fan.numbers + part.lane, passed, offset);
    return accumulate<kFactor, true, 8>(fan.numbers + part.lane, passed, offset);
  }
  if (part.group.link == LaneLink::kContiguous)
    return accumulate<kFactor, true, kWidth>(part.lanes + part.parents[0].offset + kBlock * kWidth, passed, offset);
  double each[kBlockFields * T::kWidth];
  accumulate<kFactor, false, T::kWidth>(each, passed, offset);
  for (int i = 0; i < T::kWidth; ++i) {
    const std::ptrdiff_t stride = part.parents[i].stride;
    double* sum = part.lanes + part.parents[i].offset + (kFactor ? kBlock : kBlock + 21) * stride;
    for (int row = kFactor ? 0 : 21; row < kBlockFields; ++row, sum += stride) *sum += each[row * T::kWidth + i];
  }
}

// A block of width 1 is written, and a fan added to it, four rows at a time: what is written in other parts than it is
// read in must reach the cache first. The three rows between these are zero at first, and go one by one.
inline constexpr int kFours[] = {0, 4, 8, 15, 19, 23}, kBetween = 12;

// Of four rows of four partial sums: (s0 + s1) + (s2 + s3) of each.
UNLATCH_INLINE Pack<4> sum_four_rows(const double* s, int width) {
  const auto add_pairs = [](const Pack<4>& a, const Pack<4>& b) {
    return Pack<4>(__builtin_shufflevector(a.v, b.v, 0, 4, 2, 6)) +
           Pack<4>(__builtin_shufflevector(a.v, b.v, 1, 5, 3, 7));
  };
  const Pack<4> first = add_pairs(load<Pack<4>>(s), load<Pack<4>>(s + width));
  const Pack<4> last = add_pairs(load<Pack<4>>(s + 2 * width), load<Pack<4>>(s + 3 * width));
  return Pack<4>(__builtin_shufflevector(first.v, last.v, 0, 1, 4, 5)) +
         Pack<4>(__builtin_shufflevector(first.v, last.v, 2, 3, 6, 7));
}

// The partial sums in a fixed tree, added to the parent. A fan is as wide as its first group, which is full.
template <int kWidest, bool kFactor>
UNLATCH_INLINE void close_fan(double* lanes, const LaneSlot& parent, int width, const FanSums& fan) {
  double* const block = lanes + parent.offset + kBlock * parent.stride;
  const auto add_rows = [&](int begin, int end) {
    double* to = block + begin * parent.stride;
    const double* s = fan.numbers + begin * width;
    for (int row = begin; row < end; ++row, to += parent.stride, s += width) {
      const double four = (s[0] + s[1]) + (s[2] + s[3]);
      *to += width == 4 ? four : four + ((s[4] + s[5]) + (s[6] + s[7]));
    }
  };
  if constexpr (kWidest >= 4 && kFactor) {
    for (const int row : kFours) {
      const double* s = fan.numbers + row * width;
      Pack<4> sum = sum_four_rows(s, width);
      if (width == 8) sum = sum + sum_four_rows(s + 4, width);
      double* to = block + row * parent.stride;
      if (parent.stride == 1)
        store(to, load<Pack<4>>(to) + sum);
      else
        for (int i = 0; i < 4; ++i) to[i * parent.stride] += sum.v[i];
    }
    add_rows(kBetween, kBetween + 3);
  } else {
    add_rows(kFactor ? 0 : 21, kBlockFields);
  }
}

template <class V>
UNLATCH_INLINE void init_in_fours(const V& v, double mass, const SpatialT<Pack<1>>& own) {
  using Four = Pack<4>::Numbers;
  double* to = v.find(kBlock);
  const auto put = [&](int row, const Four& numbers) { store(to + row, Pack<4>(numbers)); };
  put(0, Four{mass, mass, mass, 0});
  put(4, Four{0, 0, 0, 0});
  put(8, Four{0, 0, 0, 0});
  for (int row = kBetween; row < kBetween + 3; ++row) to[row] = 0;
  put(15, load<Pack<4>>(v.find(kInertia)).v);
  put(19, Four{v.get(kInertia + 4).v, v.get(kInertia + 5).v, own.lin.x.v, own.lin.y.v});
  put(23, Four{own.lin.z.v, own.ang.x.v, own.ang.y.v, own.ang.z.v});
}

// Bodies with something beyond them begin with what is their own.
template <int kWidest, bool kFactor>
UNLATCH_INLINE void init_blocks(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  for_groups<kWidest>(plan, ws, [&]<class V>(const LaneGroup& group, const V& v, const auto& c, const auto&) {
    if (group.leaf) return;
    const auto own = get_source(v, sweep.source);
    if constexpr (kWidest >= 4 && kFactor && V::kStride == 1) {
      init_in_fours(v, c.get(kMass).v, own);
    } else {
      if (kFactor) set_block(v.from(kBlock), get_body_block(c.get(kMass), v.get_sym(kInertia)));
      v.set(kBlock + 21, own);
    }
  });
}

}  // namespace unlatch::UNLATCH_ISA
