// One lane of the blocks: the numbers of one body and its joint, as plain vectors and matrices. For code that takes
// bodies one at a time.
#pragma once

#include <utility>

#include "kernel/plan/group.h"

namespace unlatch {

using BodyLane = BodyBlock<double>;
using SharedLane = SharedBlock<double>;
using JointLane = JointBlock<double>;
using SolverLane = SolverBlock<double>;
using SubtreeLane = SubtreeBlock<double>;

// Place of one body's lane and its joint's.
struct Place {
  std::int32_t solver, joint;
  std::int32_t body, shared;
  std::int32_t width;  // of its group
};
constexpr Place get_place(const Group& group, int lane) {
  return {group.solver + lane, group.joint + lane, group.body + lane, group.shared + lane, group.width};
}

// Place of one number in Evaluation::blocks.
struct NumberPlace {
  std::int32_t at = kNone;
  UNLATCH_INLINE double& in(double* blocks) const { return blocks[at]; }
  UNLATCH_INLINE double in(const double* blocks) const { return blocks[at]; }
};

// Numbers of one lane, `stride` apart, as a number, vector or matrix, whose members they are in order; and back.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-braces"
template <class M, std::size_t... I>
UNLATCH_INLINE M collect(const double* from, std::ptrdiff_t stride, std::index_sequence<I...>) {
  return M{from[static_cast<std::ptrdiff_t>(I) * stride]...};
}
#pragma GCC diagnostic pop
template <class M>
UNLATCH_INLINE M collect(const double* from, std::ptrdiff_t stride) {
  static_assert(sizeof(M) % sizeof(double) == 0);
  return collect<M>(from, stride, std::make_index_sequence<sizeof(M) / sizeof(double)>{});
}
template <class M>
UNLATCH_INLINE void spread(double* to, std::ptrdiff_t stride, const M& a) {
  static_assert(sizeof(M) % sizeof(double) == 0);
  constexpr std::size_t kCount = sizeof(M) / sizeof(double);
  double numbers[kCount];
  __builtin_memcpy(numbers, &a, sizeof(a));
  for (std::size_t i = 0; i < kCount; ++i) to[static_cast<std::ptrdiff_t>(i) * stride] = numbers[i];
}

// One lane of a block.
template <class Block>
struct LaneOf {
  double* first;
  std::ptrdiff_t stride;

  UNLATCH_INLINE Block read() const { return collect<Block>(first, stride); }
  UNLATCH_INLINE void write(const Block& a) const { spread(first, stride, a); }

  template <class M>
  UNLATCH_INLINE double* find(M Block::*member) const {
    return first + get_index(member) * stride;
  }
  template <class M>
  UNLATCH_INLINE M read(M Block::*member) const {
    return collect<M>(find(member), stride);
  }
  // The k-th column of a matrix; the k-th number of a vector.
  UNLATCH_INLINE Vec3 read_column(Mat3 Block::*member, int k) const {
    return collect<Vec3>(find(member) + kNumbers<Vec3T> * k * stride, stride);
  }
  UNLATCH_INLINE double read_component(Vec3 Block::*member, int k) const { return find(member)[k * stride]; }
  template <class M>
  UNLATCH_INLINE void write(M Block::*member, const M& a) const {
    spread(find(member), stride, a);
  }
  template <class M>
  UNLATCH_INLINE void add(M Block::*member, const M& a) const {
    write(member, read(member) + a);
  }
};

// First number of a lane of a block, and the distance from one number to the next.
struct LanePosition {
  std::int32_t first, stride;
};
template <class Block>
constexpr LanePosition get_position(const Place& place) {
  if constexpr (std::is_same_v<Block, BodyBlock<double>>) return {place.body, kEight};
  if constexpr (std::is_same_v<Block, AppliedBlock<double>>) return {place.body + kAppliedAfterBody * kEight, kEight};
  if constexpr (std::is_same_v<Block, SharedBlock<double>>) return {place.shared, kEight};
  if constexpr (std::is_same_v<Block, JointBlock<double>>) return {place.joint, place.width};
  if constexpr (std::is_same_v<Block, SolverBlock<double>>) return {place.solver, place.width};
  if constexpr (std::is_same_v<Block, SubtreeBlock<double>>)
    return {place.solver - kSubtreeBeforeSolver * place.width, place.width};
  static_assert(std::is_same_v<Block, BodyBlock<double>> || std::is_same_v<Block, AppliedBlock<double>> ||
                    std::is_same_v<Block, SharedBlock<double>> || std::is_same_v<Block, JointBlock<double>> ||
                    std::is_same_v<Block, SolverBlock<double>> || std::is_same_v<Block, SubtreeBlock<double>>,
                "optional parts have no position without their group: LaneParts has them");
}
template <class Block>
UNLATCH_INLINE LaneOf<Block> get_lane(double* blocks, const Place& place) {
  const LanePosition position = get_position<Block>(place);
  return {blocks + position.first, position.stride};
}
template <class Block, class M>
UNLATCH_INLINE M read(const double* blocks, const Place& place, M Block::*member) {
  return get_lane<Block>(const_cast<double*>(blocks), place).read(member);
}
template <class Block, class M>
UNLATCH_INLINE void write(double* blocks, const Place& place, M Block::*member, const std::type_identity_t<M>& a) {
  get_lane<Block>(blocks, place).write(member, a);
}
template <class Block, class M>
UNLATCH_INLINE void add(double* blocks, const Place& place, M Block::*member, const std::type_identity_t<M>& a) {
  get_lane<Block>(blocks, place).add(member, a);
}
// The i-th number of a member.
template <class Block, class M>
UNLATCH_INLINE NumberPlace find_number(const Place& place, M Block::*member, int i = 0) {
  const LanePosition position = get_position<Block>(place);
  return {position.first + (static_cast<std::int32_t>(get_index(member)) + i) * position.stride};
}

// Parts of a group's blocks, one lane of each.
struct OneLane {
  std::ptrdiff_t width;  // of the group

  template <template <class> class Block>
  UNLATCH_INLINE LaneOf<Block<double>> get(double* numbers) const {
    return {numbers, width};
  }
  UNLATCH_INLINE double& get_number(double* number) const { return *number; }
  UNLATCH_INLINE std::ptrdiff_t get_width() const { return width; }
};
class LaneParts : public GroupParts<OneLane> {
 public:
  UNLATCH_INLINE LaneParts(const Group& group, double* blocks, const Place& place)
      : GroupParts(group, blocks + place.joint, blocks + place.solver, {place.width}) {}
};

using LaneConstants = ConstantParts<OneLane, double>;
UNLATCH_INLINE LaneOf<BodyConstants<double>> get_constants(const BodyEight& eight, double* all, int lane) {
  return {all + eight.constants + lane, kEight};
}

// The pivot of an implicit spring's freedom, and the acceleration along it.
UNLATCH_INLINE NumberPlace find_pivot(const Group& group, const Place& place, int r) {
  return {place.solver + group.at.pivots[r] * place.width};
}
UNLATCH_INLINE NumberPlace find_acceleration(const Group& group, const Place& place, int r) {
  const auto acceleration = static_cast<std::int32_t>(get_index(&FreedomBlock<double>::acceleration));
  return {place.solver + (group.at.freedoms[r] + acceleration) * place.width};
}

}  // namespace unlatch
