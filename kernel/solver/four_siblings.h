// Special path: four children of one parent that are the first to add to it are summed in registers, and the parent's
// block begins with this sum and the parent's own numbers, without a detour through memory. The sums and their order
// are those of close_siblings() (parents.h). Worth: see "Special paths" in bench/README.md. Compiled once per
// instruction set, see kernel/simd/pack.h.
#pragma once

#include <utility>

#include "kernel/solver/parents.h"

namespace unlatch::UNLATCH_ISA {

// Calls use(number) for each number, in the order of memory.
template <class T, class Use>
UNLATCH_INLINE void for_numbers(const Vec3T<T>& a, const Use& use) {
  use(a.x);
  use(a.y);
  use(a.z);
}
template <class T, class Use>
UNLATCH_INLINE void for_numbers(const Sym3T<T>& a, const Use& use) {
  for_numbers(Vec3T<T>{a.xx, a.yy, a.zz}, use);
  for_numbers(Vec3T<T>{a.xy, a.xz, a.yz}, use);
}
template <class T, class Use>
UNLATCH_INLINE void for_numbers(const Mat3T<T>& a, const Use& use) {
  for_numbers(a.x, use);
  for_numbers(a.y, use);
  for_numbers(a.z, use);
}

// Numbers of a block and wrench in the order of a SubtreeBlock; without kFactor those of the wrench alone.
template <bool kFactor, class T>
UNLATCH_INLINE void list_numbers(const Passed<T>& a, T* to) {
  int i = 0;
  const auto put = [&](const T& number) UNLATCH_INLINE_LAMBDA { to[i++] = number; };
  if constexpr (kFactor) {
    for_numbers(a.A.M, put);
    for_numbers(a.A.H, put);
    for_numbers(a.A.I, put);
  } else {
    i = kWrenchIndex;
  }
  for_numbers(a.wrench.lin, put);
  for_numbers(a.wrench.ang, put);
}

template <bool kFactor>
UNLATCH_INLINE void add_four_siblings(const GroupView<Pack<4>, 4>& v, const Passed<Pack<4>>& passed, Source source) {
  constexpr int kCount = kNumbers<SubtreeBlock>, kFirst = kFactor ? 0 : kWrenchIndex;
  Pack<4> numbers[kCount];
  list_numbers<kFactor>(passed, numbers);
  const GroupView<Pack<1>, 1> parent(v.plan, v.ev, static_cast<std::size_t>(v.group.begins), 0);
  Pack<1> own[kCount];
  list_numbers<kFactor>(get_own(parent, source), own);
  double* const block = parent.blocks.subtree().A.M.xx.lane;
  const auto begin_four = [&](int i) UNLATCH_INLINE_LAMBDA {
    const Pack<4> first(Pack<4>::Numbers{own[i].v, own[i + 1].v, own[i + 2].v, own[i + 3].v});
    store(block + i, first + sum_lanes(numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]));
  };
  // Four numbers of the parent's block at a time, because a processor reads back quickly only what it wrote in one
  // piece; the last four overlap those before them.
  [&]<int... K>(std::integer_sequence<int, K...>) UNLATCH_INLINE_LAMBDA { (begin_four(kFirst + 4 * K), ...); }
  (std::make_integer_sequence<int, (kCount - kFirst) / 4>{});
  begin_four(kCount - 4);
}

// True for a group with one parent (ParentLink::kSiblings) that takes this path: it begins its parent's block. That is
// so where it is four wide, has all of the siblings, and is the first to add to a parent that is alone in its group
// (find_beginnings() in kernel/compile/layout.cc).
template <int kWidest>
UNLATCH_INLINE bool sums_in_registers(const Group& siblings) {
  return kWidest >= 4 && siblings.begins != kNone;
}

// Adds to the parents by the path that fits. `at_parent`: at the parent's origin, see move().
template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void pass_to_parents(const GroupView<T, kWidth>& v, const Passed<T>& at_parent, Source source,
                                    SiblingSums& sums) {
  if constexpr (kWidth == 4 && T::kWidth == 4)
    if (v.group.link == ParentLink::kSiblings && sums_in_registers<4>(v.group))
      return add_four_siblings<kFactor>(v, at_parent, source);
  add_to_parents<kFactor>(v, at_parent, source, sums);
}

}  // namespace unlatch::UNLATCH_ISA
