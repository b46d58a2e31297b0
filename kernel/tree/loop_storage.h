// How the numbers of loops that are eliminated where they close lie in memory: rows of kEight numbers, of which each
// belongs to a row of a loop's joint. Positions of these rows are known to this file alone.
#pragma once

#include <bit>
#include <cstddef>

#include "kernel/plan/plan_data.h"

namespace unlatch {

// Blocks of Λ and of the split of redundant reactions: the rows of one loop, as columns those of another.
inline double* find_loop_block(std::span<double> blocks, std::int32_t block) {
  return blocks.data() + static_cast<std::ptrdiff_t>(block) * kBlockNumbers;
}
inline double get_diagonal(const double* loop_block, int row) { return loop_block[row * kEight + row]; }

// What a loop has at a node of the tree (LoopSlot).
class SlotRows {
 public:
  static constexpr int kWrench = 0, kWrenches = 6;  // of a unit multiplier, at the node's origin

  constexpr explicit SlotRows(const Group& group)
      : freedoms_(group.freedoms), rows_(group.rows), by_rows_(group.may_be_by_rows) {}

  // What the wrench does along a freedom of the node's joint.
  constexpr int freedom(int r) const { return kWrenches + count_below(freedoms_, r); }
  // Where the joint is solved by rows: the acceleration of the body if the joint did not hold it, and its component
  // along a row.
  constexpr int response() const { return kWrenches + std::popcount(freedoms_); }
  constexpr int row(int r) const { return response() + kWrenches + count_below(rows_, r); }

  // Of a loop that passes on to the parent; one that closes at the node has its wrench alone.
  constexpr int count() const { return response() + (by_rows_ ? kWrenches : 0) + std::popcount(rows_); }

 private:
  static constexpr int count_below(unsigned all, int r) {
    return std::popcount(all & ((1u << static_cast<unsigned>(r)) - 1));
  }
  unsigned freedoms_, rows_;
  bool by_rows_;
};

}  // namespace unlatch
