// Positions of the optional parts of a group's blocks: for the layout of a plan, and for the check of an image.
#pragma once

#include <bit>

#include "kernel/plan/lanes.h"

namespace unlatch {

// Numbers per lane of a group's JointBlock with its parts, and of its constants; 0 without a joint.
struct JointNumbers {
  int joint, constants;
};

// Sets `size` and `at` of a group by its other members.
inline JointNumbers place_parts(Group& group) {
  int numbers = group.has_joint ? kNumbers<SolverBlock> : 0;
  const auto take = [&](std::uint8_t& part, int count) {
    part = static_cast<std::uint8_t>(numbers);
    numbers += count;
  };
  if (group.shared_axes)
    group.at.rotation_axes = static_cast<std::uint8_t>(get_index(&SolverLane::axes));
  else
    take(group.at.rotation_axes, kNumbers<Mat3T>);
  if (group.may_be_by_rows) take(group.at.free, kNumbers<FreeBlock>);
  for (int r = 0; r < kRows; ++r) {
    if (has_row(group.freedoms, r)) take(group.at.freedoms[r], kNumbers<FreedomBlock>);
    if (has_row(group.rows, r)) take(group.at.rows[r], kNumbers<RowBlock>);
    if (has_row(group.compliant, r)) take(group.at.pivots[r], 1);
  }
  group.size = static_cast<std::uint8_t>(numbers);
  group.at.crossed = kNumbers<JointBlock>;
  group.at.carried = static_cast<std::int16_t>(group.at.crossed + (group.universal ? 1 : 0));
  if (!group.has_joint) return {0, 0};
  return {group.at.carried + kAxesAfterCarried + kNumbers<Vec3T> * std::popcount(group.carried),
          kRotationAfterJoint + (group.shared_axes ? 0 : kNumbers<RotationConstants>)};
}

}  // namespace unlatch
