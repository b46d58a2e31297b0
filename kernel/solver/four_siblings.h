// Special path: four children of one parent, and the first to add to it, are summed in registers, and the sum begins
// the parent's block with the parent's own, without a detour through memory. The sums and their order are those of
// close_siblings() (parents.h). Worth: see "Special paths" in bench/README.md. Compiled once per instruction set, see
// kernel/simd/pack.h.
#pragma once

#include "kernel/solver/parents.h"

namespace unlatch::UNLATCH_ISA {

template <bool kFactor>
UNLATCH_INLINE void add_four_siblings(const GroupView<Pack<4>, 4>& v, const Passed<Pack<4>>& passed, Source source) {
  using Four = Pack<4>::Numbers;
  constexpr int kLoad = kNumbers<ArticulatedT>;
  Pack<4> numbers[kNumbers<SubtreeBlock>];
  const auto put_three = [&](int i, const Vec3T<Pack<4>>& a) {
    numbers[i] = a.x;
    numbers[i + 1] = a.y;
    numbers[i + 2] = a.z;
  };
  put_three(kLoad, passed.load.lin);
  put_three(kLoad + 3, passed.load.ang);
  if constexpr (kFactor) {
    const ArticulatedT<Pack<4>>& A = passed.A;
    put_three(0, {A.M.xx, A.M.yy, A.M.zz});
    put_three(3, {A.M.xy, A.M.xz, A.M.yz});
    put_three(6, A.H.x);
    put_three(9, A.H.y);
    put_three(12, A.H.z);
    put_three(15, {A.I.xx, A.I.yy, A.I.zz});
    put_three(18, {A.I.xy, A.I.xz, A.I.yz});
  }
  // Four numbers of the parent's block at a time, since what is written in other parts than it is read in must reach
  // the cache first; the last four overlap those before them.
  const GroupView<Pack<1>, 1> parent(v.plan, v.ev, static_cast<std::size_t>(v.group.begins), 0);
  double* const block = parent.blocks.subtree().A.M.xx.lane;
  const Passed<Pack<1>> own = get_own(parent, source);
  const auto begin = [&](int i, const Four& first) {
    store(block + i, Pack<4>(first) + sum_lanes(numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]));
  };
  const Vec3T<Pack<1>>&force = own.load.lin, &torque = own.load.ang;
  if constexpr (kFactor) {
    const Pack<4> mass(own.A.M.xx.v), first_three = Pack<4>(Four{1, 1, 1, 0}) > Pack<4>(0.0);
    const Sym3T<Pack<1>>& I = own.A.I;
    begin(0,
          (first_three & mass).v);  // not put together: g++ would use an instruction that valgrind 3.19 does not know
    begin(4, Four{0, 0, 0, 0});
    begin(8, Four{0, 0, 0, 0});
    begin(12, Four{0, 0, 0, I.xx.v});
    begin(16, Four{I.yy.v, I.zz.v, I.xy.v, I.xz.v});
    begin(20, Four{I.yz.v, force.x.v, force.y.v, force.z.v});
  } else {
    begin(21, Four{force.x.v, force.y.v, force.z.v, torque.x.v});
  }
  begin(23, Four{force.z.v, torque.x.v, torque.y.v, torque.z.v});
}

// A group with one parent (ParentLink::kSiblings) takes this path. The plan lets it begin its parent's block
// where it is four wide, has all of the siblings, and is the first to add to a parent that is alone in its group
// (find_beginnings() in kernel/compile/layout.cc).
template <int kWidest>
UNLATCH_INLINE bool sums_in_registers(const Group& siblings) {
  return kWidest >= 4 && siblings.begins != kNone;
}

// To the parents, by the path that fits. `at_parent`: at the parent's origin, see move().
template <bool kFactor, class T, int kWidth>
UNLATCH_INLINE void pass_to_parents(const GroupView<T, kWidth>& v, const Passed<T>& at_parent, Source source,
                                    SiblingSums& sums) {
  if constexpr (kWidth == 4 && T::kWidth == 4)
    if (v.group.link == ParentLink::kSiblings && sums_in_registers<4>(v.group))
      return add_four_siblings<kFactor>(v, at_parent, source);
  add_to_parents<kFactor>(v, at_parent, source, sums);
}

}  // namespace unlatch::UNLATCH_ISA
