// Special path: groups whose lanes all have one and the same freedom, such as hinges, are factored without branches
// between the sums. The sums and their order are those of eliminate() (tree_sweeps.h). Worth: see "Special paths" in
// bench/README.md. Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/solver/four_siblings.h"
#include "kernel/solver/freedoms.h"

namespace unlatch::UNLATCH_ISA {

UNLATCH_INLINE bool has_single_freedom(const GroupModes& modes) {
  return modes.by_freedoms && !modes.by_rows && std::has_single_bit(static_cast<unsigned>(modes.freedoms));
}

// Returns kNone, or the node whose pivot vanished.
template <bool kLeaf, class T, int kWidth>
[[gnu::noinline]] int factor_single_freedom(const PlanData& plan, Evaluation& ev, const Sweep& sweep, std::size_t g,
                                            SiblingSums& sums) {
  const int r = std::countr_zero(static_cast<unsigned>(ev.modes[g].freedoms));
  for (int lane = 0; lane < kWidth; lane += T::kWidth) {
    const GroupView<T, kWidth> v(plan, ev, g, lane);
    const Node<T, kLeaf> node(v, sweep.source);
    T bad(0.0);
    Passed<T> passed;
    passed.wrench = node.wrench - node.times(get_bias(v, sweep.biased));
    with_freedom(v, r, [&](const auto& s) UNLATCH_INLINE_LAMBDA {
      passed.A = get_whole(eliminate_first(v, node, sweep, r, s, passed.wrench, bad));
    });
    if (any(bad)) return find_bad_node(plan, v.group, lane, bad);
    if (v.group.link == ParentLink::kRoot) continue;
    pass_to_parents<true>(v, move<true>(passed, load<T>(v.blocks.solver().offset)), sweep.source, sums);
  }
  return kNone;
}

}  // namespace unlatch::UNLATCH_ISA
