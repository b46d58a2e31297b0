// Special path: large systems ask for the next group's solver blocks before their turn, in the direction in which the
// sweep goes through the memory: a processor foresees a stream of lines that rise or fall one by one, and of no others.
// Worth: see "Special paths" in bench/README.md. Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch::UNLATCH_ISA {

// More blocks than caches hold, 32 MiB: within them asking costs more than waiting.
inline bool is_far(const PlanData& plan) { return plan.block_numbers > (32 << 20) / 8; }

template <int kDirection>
UNLATCH_INLINE void prefetch_block(const PlanData& plan, const Evaluation& ev, std::size_t g) {
  const Group& group = plan.groups[g];
  const double* block = ev.blocks.data() + group.solver;
  // The first group of a block of eight has the SharedBlock before its own.
  const bool first_of_eight = group.shared % kEight == 0;
  const int first =
      (group.leaf ? 0 : -kNumbers<SubtreeBlock> * group.width) - (first_of_eight ? kNumbers<SharedBlock> * kEight : 0);
  const int end = group.size * group.width;
  for (int i = first; i < end; i += 8) __builtin_prefetch(block + (kDirection > 0 ? i : first + end - 1 - i), 1);
}

}  // namespace unlatch::UNLATCH_ISA
