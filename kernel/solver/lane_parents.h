// What children add to their parents: blocks and loads on their way to the root, and what a parent's begin with.
// Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/solver/lane_node.h"

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

// Its own inertia and load: what the sums at a body begin with.
template <class V, class C, class T = typename V::T>
UNLATCH_INLINE Passed<T> get_own(const V& v, const C& c, Source source) {
  return {get_body_block(c.get(kMass), v.get_sym(kInertia)), get_source(v, source)};
}

// Hands 27 rows, or the last six of them, to put(row, three numbers).
template <bool kFactor, class T, class Put>
UNLATCH_INLINE void put_rows(const Passed<T>& passed, const Put& put) {
  put(21, passed.load.lin);
  put(24, passed.load.ang);
  if constexpr (kFactor) {
    const ArticulatedT<T>& A = passed.A;
    put(0, {A.M.xx, A.M.yy, A.M.zz});
    put(3, {A.M.xy, A.M.xz, A.M.yz});
    put(6, A.H.x);
    put(9, A.H.y);
    put(12, A.H.z);
    put(15, {A.I.xx, A.I.yy, A.I.zz});
    put(18, {A.I.xy, A.I.xz, A.I.yz});
  }
}
template <bool kFactor, int kStride, class T>
// NOLINTNEXTLINE(readability-non-const-parameter): it is written to, through the view
UNLATCH_INLINE void write(double* rows, const Passed<T>& passed) {
  const View<T, kStride> to{rows};
  put_rows<kFactor>(passed, [&](int row, const Vec3T<T>& a) { to.set(row, a); });
}
template <bool kFactor, int kStride, class T>
// NOLINTNEXTLINE(readability-non-const-parameter)
UNLATCH_INLINE void add(double* rows, const Passed<T>& passed) {
  const View<T, kStride> to{rows};
  put_rows<kFactor>(passed, [&](int row, const Vec3T<T>& a) { to.set(row, to.get_vec(row) + a); });
}

// As the parent sees it.
template <bool kFactor, class T>
UNLATCH_INLINE Passed<T> move(const Passed<T>& passed, const Vec3T<T>& offset) {
  Passed<T> out;
  if constexpr (kFactor) out.A = shift(passed.A, offset);
  out.load = {passed.load.lin, passed.load.ang + cross(offset, passed.load.lin)};
  return out;
}

// The parents are the lanes of one group. Whoever comes first begins with what is their own.
template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void add_to_lanes(const Part<T, kWidth>& part, const Passed<T>& passed, Source source) {
  double* const block = part.lanes + part.parents[0].data + kBlock * kWidth;
  if (part.group.begins == kNone) return add<kFactor, kWidth>(block, passed);
  const Part<T, kWidth> parent(part.plan, part.ws, static_cast<std::size_t>(part.group.begins), part.lane);
  const Passed<T> own = get_own(parent.v, parent.c, source);
  Passed<T> sum{{}, own.load + passed.load};
  if constexpr (kFactor) {
    sum.A = own.A;
    sum.A += passed.A;
  }
  write<kFactor, kWidth>(block, sum);
}

// --- A fan: its partial sums in a fixed tree ------------------------------------------------------------------------

// Of one row.
UNLATCH_INLINE double sum_row(const double* s, int width) {
  const double four = (s[0] + s[1]) + (s[2] + s[3]);
  return width == 4 ? four : four + ((s[4] + s[5]) + (s[6] + s[7]));
}

// Of four rows: (s0 + s1) + (s2 + s3) of each.
UNLATCH_INLINE Pack<4> sum_rows(const Pack<4>& r0, const Pack<4>& r1, const Pack<4>& r2, const Pack<4>& r3) {
  const auto add_pairs = [](const Pack<4>& a, const Pack<4>& b) {
    return Pack<4>(__builtin_shufflevector(a.v, b.v, 0, 4, 2, 6)) +
           Pack<4>(__builtin_shufflevector(a.v, b.v, 1, 5, 3, 7));
  };
  const Pack<4> first = add_pairs(r0, r1), last = add_pairs(r2, r3);
  return Pack<4>(__builtin_shufflevector(first.v, last.v, 0, 1, 4, 5)) +
         Pack<4>(__builtin_shufflevector(first.v, last.v, 2, 3, 6, 7));
}
UNLATCH_INLINE Pack<4> sum_four_rows(const double* s, int width) {
  const auto sum_half = [&](const double* h) {
    return sum_rows(load<Pack<4>>(h), load<Pack<4>>(h + width), load<Pack<4>>(h + 2 * width),
                    load<Pack<4>>(h + 3 * width));
  };
  return width == 4 ? sum_half(s) : sum_half(s) + sum_half(s + 4);
}

// A block of width 1, begun with the parent's own; sum(row) has four rows of the fan from this one on. Four at a time,
// since what is written in other parts than it is read in must reach the cache first; the last four overlap those
// before them.
template <bool kFactor, class Sum>
UNLATCH_INLINE void begin_in_fours(const Part<Pack<1>, 1>& parent, Source source, const Sum& sum) {
  using Four = Pack<4>::Numbers;
  const Passed<Pack<1>> own = get_own(parent.v, parent.c, source);
  const Vec3T<Pack<1>>&force = own.load.lin, &torque = own.load.ang;
  const auto put = [&](int row, const Four& begin) { store(parent.v.find(kBlock + row), Pack<4>(begin) + sum(row)); };
  if constexpr (kFactor) {
    const Pack<4> mass(own.A.M.xx.v), first_three = Pack<4>(Four{1, 1, 1, 0}) > Pack<4>(0.0);
    const Sym3T<Pack<1>>& I = own.A.I;
    put(0, (first_three & mass).v);  // not put together: g++ would use an instruction that valgrind 3.19 does not know
    put(4, Four{0, 0, 0, 0});
    put(8, Four{0, 0, 0, 0});
    put(12, Four{0, 0, 0, I.xx.v});
    put(16, Four{I.yy.v, I.zz.v, I.xy.v, I.xz.v});
    put(20, Four{I.yz.v, force.x.v, force.y.v, force.z.v});
  } else {
    put(21, Four{force.x.v, force.y.v, force.z.v, torque.x.v});
  }
  put(23, Four{force.z.v, torque.x.v, torque.y.v, torque.z.v});
}

// Whether the fan is one group of four, and need not go through memory.
template <int kWidest>
UNLATCH_INLINE bool is_four(const LaneGroup& group) {
  return kWidest >= 4 && group.width == 4 && group.fan_begins && group.fan_ends && group.begins != kNone;
}
template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void add_four(const Part<T, kWidth>& part, const Passed<T>& passed, Source source) {
  Pack<4> rows[kBlockFields];
  put_rows<kFactor>(passed, [&](int row, const Vec3T<T>& a) {
    rows[row] = a.x;
    rows[row + 1] = a.y;
    rows[row + 2] = a.z;
  });
  begin_in_fours<kFactor>({part.plan, part.ws, static_cast<std::size_t>(part.group.begins), 0}, source,
                          [&](int row) { return sum_rows(rows[row], rows[row + 1], rows[row + 2], rows[row + 3]); });
}

// Any other fan is as wide as its first group, which is full.
template <int kWidest, bool kFactor>
UNLATCH_INLINE void close_fan(const Plan& plan, Workspace& ws, const LaneGroup& group, Source source,
                              const FanSums& fan) {
  const int width = group.fan_begins ? group.width : 8;
  int row = kFactor ? 0 : 21;
  if (group.begins != kNone) {
    const Part<Pack<1>, 1> parent(plan, ws, static_cast<std::size_t>(group.begins), 0);
    if constexpr (kWidest >= 4)
      return begin_in_fours<kFactor>(parent, source,
                                     [&](int r) { return sum_four_rows(fan.numbers + r * width, width); });
    write<kFactor, 1>(parent.v.find(kBlock), get_own(parent.v, parent.c, source));
  }
  const LaneSlot& parent = plan.lane_parents[static_cast<std::size_t>(group.first)];
  double* to = ws.lanes.data() + parent.data + (kBlock + row) * parent.stride;
  if constexpr (kWidest >= 4)
    for (; row + 4 <= kBlockFields; row += 4) {
      const Pack<4> sum = sum_four_rows(fan.numbers + row * width, width);
      for (int i = 0; i < 4; ++i, to += parent.stride) *to += sum.v[i];
    }
  for (; row < kBlockFields; ++row, to += parent.stride) *to += sum_row(fan.numbers + row * width, width);
}

// --- Whatever the parents are ---------------------------------------------------------------------------------------

template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void add_to_parents(const Part<T, kWidth>& part, const Passed<T>& at_child, Source source,
                                   FanSums& fan) {
  const Passed<T> passed = move<kFactor>(at_child, part.v.get_vec(kOffset));
  if (part.group.link == LaneLink::kFan) {
    if constexpr (T::kWidth == 4 && kWidth == 4)
      if (is_four<4>(part.group)) return add_four<kFactor>(part, passed, source);
    if (part.group.fan_begins) return write<kFactor, kWidth>(fan.numbers + part.lane, passed);
    return add<kFactor, 8>(fan.numbers + part.lane, passed);
  }
  if (part.group.link == LaneLink::kContiguous) return add_to_lanes<kFactor>(part, passed, source);
  double each[kBlockFields * T::kWidth];
  write<kFactor, T::kWidth>(each, passed);
  for (int i = 0; i < T::kWidth; ++i) {
    const std::ptrdiff_t stride = part.parents[i].stride;
    double* sum = part.lanes + part.parents[i].data + (kFactor ? kBlock : kBlock + 21) * stride;
    for (int row = kFactor ? 0 : 21; row < kBlockFields; ++row, sum += stride) *sum += each[row * T::kWidth + i];
  }
}

// Where nothing holds, only what begins sums is to be done.
template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void add_nothing(const Part<T, kWidth>& part, Source source, FanSums& fan) {
  const T o(0.0);
  const Vec3T<T> zero{o, o, o};
  const Passed<T> nothing{{{o, o, o, o, o, o}, {zero, zero, zero}, {o, o, o, o, o, o}}, {zero, zero}};
  if (part.group.link == LaneLink::kFan) {
    if constexpr (T::kWidth == 4 && kWidth == 4)
      if (is_four<4>(part.group)) return add_four<kFactor>(part, nothing, source);
    if (part.group.fan_begins) write<kFactor, kWidth>(fan.numbers + part.lane, nothing);
  }
  if (part.group.link == LaneLink::kContiguous && part.group.begins != kNone)
    add_to_lanes<kFactor>(part, nothing, source);
}

// Blocks that no child begins.
template <int kWidest, bool kFactor>
UNLATCH_INLINE void begin_blocks(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  for (const std::int32_t g : plan.own_beginnings)
    for_width<kWidest>(plan.groups[static_cast<std::size_t>(g)], [&]<class T, int kWidth>() {
      for (int lane = 0; lane < kWidth; lane += T::kWidth) {
        const Part<T, kWidth> part(plan, ws, static_cast<std::size_t>(g), lane);
        write<kFactor, kWidth>(part.v.find(kBlock), get_own(part.v, part.c, sweep.source));
      }
    });
}

}  // namespace unlatch::UNLATCH_ISA
