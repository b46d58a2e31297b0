// Special path: in large systems the next group's solver blocks are fetched before their turn, in the direction in
// which the sweep goes through the memory. A processor does this by itself only for lines that rise or fall one by one.
// Worth: see "Special paths" in bench/README.md. Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch::UNLATCH_ISA {

// Blocks larger than this, bytes, are beyond the caches; of smaller ones fetching ahead costs more than it saves.
inline constexpr std::size_t kCacheBytes = std::size_t{32} << 20;
inline bool is_far(const PlanData& plan) { return at(plan.block_numbers) > kCacheBytes / sizeof(double); }

template <int kDirection>
UNLATCH_INLINE void prefetch_block(const PlanData& plan, const Evaluation& ev, std::size_t g) {
  const Group& group = plan.groups[g];
  const double* block = ev.blocks.data() + group.solver;
  const auto [first, end] = get_solver_range(group);
  for (int i = first; i < end; i += kLineNumbers)
    __builtin_prefetch(block + (kDirection > 0 ? i : first + end - 1 - i), 1);
}

}  // namespace unlatch::UNLATCH_ISA
