// Blocks: how the numbers of bodies and joints lie in memory. This file alone knows where they are; all other code uses
// typed members.
//
// Bodies or joints that are computed side by side lie side by side, one per lane. A block's struct is written once,
// over a number type N:
//   N = Wide<W>  the block itself, each member W numbers wide (kernel/simd/wide.h)
//   N = double   one lane of it, read and written at a Place: read(memory, place, &BodyBlock<double>::motion)
//
// Bodies by themselves (Runge–Kutta, kinematics, forces) are computed in blocks of eight, wherever they are in the
// tree. Joints and the solver work on groups: nodes of one level and kind, 8, 4, 2 or 1 wide. The bodies of a
// group are neighbours in one block of eight. The cut depends on the model alone, never on the processor; a narrower
// processor takes a wide block in parts. Lanes never meet, and children are added to their parent in one fixed order,
// so every width gives the same bits.
//
//   Evaluation::blocks
//   ┌──────────────────────────────┬─────────────────────────────┬────────────────────────────────────────┬───────────┐
//   │ bodies, per block of eight   │ joints, per group           │ solver, per group                      │ non-tree  │
//   │ BodyBlock                    │ JointBlock                  │ SharedBlock (before the first group of │ joints    │
//   │ [AppliedBlock]               │ [crossed]                   │   each block of eight, 8 wide)         │ 6 multi-  │
//   │ 8 wide                       │ [CarriedBlock, 1…3 axes]    │ [SubtreeBlock] SolverBlock [rotation   │ pliers    │
//   │                              │                             │   axes] [FreeBlock] per row:           │ each      │
//   │                              │                             │   [FreedomBlock] [RowBlock] [pivot]    │           │
//   └──────────────────────────────┴─────────────────────────────┴────────────────────────────────────────┴───────────┘
//   [ ]: only where the group needs it. Blocks begin at cache lines. Beyond the caches the solver costs what it
//   fetches, so what it reads lies apart from the rest, in the order of its sweeps.
//
// A lane without a node holds a body at rest which nothing holds; it gives its neighbours nothing. Masks are numbers
// with all bits set or none.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "kernel/math/spatial.h"
#include "kernel/simd/wide.h"
#include "unlatch/model.h"

namespace unlatch {

inline constexpr int kEight = 8;  // lanes of a block of bodies

// --- Bodies ----------------------------------------------------------------------------------------------------------

// Pose and velocity of a body, their rates, or a weighted sum of rates.
template <class N>
struct MotionT {
  Vec3T<N> p;  // p_WB, m
  QuatT<N> q;  // q_WB
  Vec3T<N> v;  // v_WB, inertial axes, m/s
  Vec3T<N> w;  // w_WB_B, body axes, rad/s
};

template <class N>
struct BodyBlock {
  MotionT<N> motion;                    // at the stage
  MotionT<N> start;                     // at the beginning of the sub-step
  MotionT<N> sum;                       // weighted sum of the stages' rates
  Vec3T<N> start_v_rate, start_w_rate;  // dv/dt (inertial axes), dw/dt (body axes) at the beginning of the sub-step
  Mat3T<N> R;                           // R_WB
  Vec3T<N> w_W;                         // angular velocity, world axes
};
// Loads that are fixed in the body, summed.
template <class N>
struct AppliedBlock {
  SpatialT<N> wrench;  // at the origin, body axes
};
// Written by the body's dynamics, read by the solver, or the reverse; world axes, at the body's origin.
template <class N>
struct SharedBlock {
  Sym3T<N> inertia;          // about the origin
  SpatialT<N> force;         // applied force and torque, gyroscopic torque included
  SpatialT<N> acceleration;  // of the latest solve
};

template <class N>
struct BodyConstants {
  Sym3T<N> inertia;  // body axes; 0 of bodies with a mass law, flexible bodies and markers
  N mass;            // likewise
};

// --- Joints to the parent --------------------------------------------------------------------------------------------

template <class N>
struct JointBlock {
  Vec3T<N> arm_parent;    // from the parent's origin to the follower's point, world axes
  Vec3T<N> displacement;  // of the follower's point from the base's, along n
  SpatialT<N> slip;       // v_rel, w_rel: velocity of the follower's point seen from the base; world axes
};
// Memory of a joint's mode: the displacements at which its point–plane rows hold, and, behind this block, for each
// axis in Group::carried where it is in the follower (follower axes), times its weight in the residual.
template <class N>
struct CarriedBlock {
  Vec3T<N> offset;
};

template <class N>
struct JointConstants {
  Vec3T<N> point_base, point_follower;  // in each body's axes, from its origin
  Mat3T<N> axes;                        // of the point–plane rows, base axes
};
// Axes of the rotation rows of a joint, where they are not those of its point–plane rows.
template <class N>
struct RotationConstants {
  Mat3T<N> axes;        // base axes
  Vec3T<N> follower_y;  // y of the rotation frame, follower axes
};

// --- The solver ------------------------------------------------------------------------------------------------------

// Inertia and load of a body that has others outboard of it: the block LDLᵀ adds to them what the children pass on.
template <class N>
struct SubtreeBlock {
  ArticulatedT<N> A;  // inertia of the body and all outboard of it
  SpatialT<N> load;   // and what pushes them
};

template <class N>
struct SolverBlock {
  Vec3T<N> arm_child;    // from the child's origin to the follower's point
  Vec3T<N> offset;       // from the parent's origin to the child's
  SpatialT<N> bias;      // relative acceleration that the rows ask for, at the child's origin
  Mat3T<N> axes;         // n of the point–plane rows
  N multipliers[kRows];  // in the order of Row; 0 where no row holds
  N by_freedoms;         // mask: three rows or more hold, the child is eliminated through its freedoms
};
// A body that nothing, or one or two rows, hold: its whole block is factored.
template <class N>
struct FreeBlock {
  FreeFactorT<N> factor;
  SpatialT<N> response;  // A⁻¹ load
};
// A degree of freedom s of the joint.
template <class N>
struct FreedomBlock {
  N mask;           // it is one in this lane's mode
  SpatialT<N> U;    // A s
  N inverse_pivot;  // 1 / sᵀ A s
  N beta;           // sᵀ load, and after the forward pass its acceleration
};
// A row, where one or two hold.
template <class N>
struct RowBlock {
  N mask;
  SpatialT<N> wrench;    // w, on the child at its origin
  SpatialT<N> response;  // A⁻¹ w
  N inverse_pivot;       // 1 / wᵀ A⁻¹ w
  N mu;
};

template <class N>
struct SolverConstants {
  N mass;
  N side;  // +1: the child is the joint's follower; −1: its base; 0: the lane is empty
};

// Numbers per lane of a block.
template <template <class> class Block>
inline constexpr int kNumbers = sizeof(Block<double>) / sizeof(double);

// Position of a member in its block, in numbers: what a pointer to a data member of such a struct is (Itanium ABI).
template <class Block, class M>
UNLATCH_INLINE std::ptrdiff_t get_index(M Block::*member) {
  static_assert(sizeof(member) == sizeof(std::ptrdiff_t) && sizeof(Block) % sizeof(double) == 0);
  return std::bit_cast<std::ptrdiff_t>(member) / static_cast<std::ptrdiff_t>(sizeof(double));
}

// Overlays a block on numbers in memory.
template <template <class> class Block, int W>
UNLATCH_INLINE Block<Wide<W>>& as_block(double* numbers) {
  return *reinterpret_cast<Block<Wide<W>>*>(numbers);
}
template <template <class> class Block, int W>
UNLATCH_INLINE const Block<Wide<W>>& as_block(const double* numbers) {
  return *reinterpret_cast<const Block<Wide<W>>*>(numbers);
}

// --- Blocks of eight bodies ------------------------------------------------------------------------------------------

struct BodyEight {
  std::int32_t body, shared;  // its blocks, in numbers from the beginning of Evaluation::blocks
  std::int32_t constants;     // its BodyConstants, in PlanData::body_constants
  std::uint8_t used;          // bit i: lane i belongs to a group
  std::uint8_t filled;        // bit i: it has a body
  bool loaded;                // some body has a load that is fixed in it: there is an AppliedBlock

  // From one lane on.
  UNLATCH_INLINE BodyBlock<Wide<kEight>>& get_body(double* blocks, int lane) const {
    return as_block<BodyBlock, kEight>(blocks + body + lane);
  }
  UNLATCH_INLINE AppliedBlock<Wide<kEight>>& get_applied(double* blocks, int lane) const {
    return as_block<AppliedBlock, kEight>(blocks + body + kNumbers<BodyBlock> * kEight + lane);
  }
  UNLATCH_INLINE SharedBlock<Wide<kEight>>& get_shared(double* blocks, int lane) const {
    return as_block<SharedBlock, kEight>(blocks + shared + lane);
  }
  UNLATCH_INLINE const BodyConstants<Wide<kEight>>& get_constants(const double* all, int lane) const {
    return as_block<BodyConstants, kEight>(all + constants + lane);
  }
  constexpr int count_body_numbers() const {
    return (kNumbers<BodyBlock> + (loaded ? kNumbers<AppliedBlock> : 0)) * kEight;
  }
};

// --- Groups of joints and nodes --------------------------------------------------------------------------------------

// Relation of a group to its parents.
enum class ParentLink : std::uint8_t {
  kRoot,        // they have none
  kSiblings,    // one parent for the whole group
  kContiguous,  // the parents are the lanes of one group, in the same order
  kGather,      // anywhere in the levels above
};

enum class BodyKind : std::uint8_t {
  kRigid,
  kFlexible,  // solved by kernel/solver/flexible_solver.h
  kMarker,    // outboard of its flexible body, which solves it too
};

// Bodies of the joints that the children of a group are.
enum class ChildSide : std::uint8_t { kFollower, kBase, kMixed };

// A mode whose rows leave a body's own block to be eliminated through the joint's freedoms: three rows or more, or any
// in a joint with implicit springs, which act on freedoms. The freedoms are the rows that do not hold: the three
// point–plane rows and the three rotation rows are each about axes across one another.
constexpr bool is_by_freedoms(RowSet rows, RowSet compliant) {
  const RowSet without_one = static_cast<RowSet>(rows & (rows - 1));
  return (without_one & (without_one - 1)) != 0 || compliant != 0;
}

// Axes whose place in the follower a mode keeps, bit a for axis a: all of three rotation rows; the free one of two.
// They measure its orientation.
constexpr std::uint8_t get_carried_axes(RowSet rows) {
  const RowSet rotation = rows & kRotationRows;
  if (rotation == kRotationRows) return 0b111;
  for (int a = 0; a < 3; ++a)
    if (rotation == (kRotationRows & ~row_bit(kRotX + a))) return static_cast<std::uint8_t>(1u << a);
  return 0;
}

struct alignas(64) Group {
  std::int32_t first;         // of its lanes, in PlanData::lane_nodes and PlanData::lane_parents
  std::int32_t body, shared;  // where the first lane's blocks are, in numbers from the beginning of Evaluation::blocks
  std::int32_t joint, solver;
  std::int32_t constants;  // its JointConstants, in PlanData::joint_constants
  std::int32_t begins;     // group whose SubtreeBlocks it is the first to add to, all of them, and begins; or kNone
  std::uint8_t size;       // numbers per lane from its SolverBlock on
  std::uint8_t width;      // 1, 2, 4 or 8
  std::uint8_t count;      // lanes in use
  ParentLink link;
  BodyKind kind;
  ChildSide side;
  bool siblings_begin : 1, siblings_end : 1;  // first and last group of one parent's, in the order of the backward pass
  bool leaf : 1;                              // nothing is outboard of any of its bodies
  bool has_joint : 1;                         // to the parent or the ground
  bool shared_axes : 1;                       // one frame for point–plane and rotation rows
  bool universal : 1;
  bool may_be_by_rows : 1;  // some mode leaves fewer than three rows, or a lane is empty
  RowSet freedoms;          // that some mode of three rows or more leaves
  RowSet rows;              // that some mode of one or two rows holds
  RowSet compliant;         // freedoms with springs that are integrated implicitly
  std::uint8_t carried;     // bit a: some mode measures orientation by where axis a is in the follower

  struct {  // positions of optional parts, in numbers per lane: from the JointBlock on,
    std::int16_t crossed, carried;
    std::uint8_t rotation_axes, free;                          // and from the SolverBlock on
    std::uint8_t freedoms[kRows], rows[kRows], pivots[kRows];  // of those in `freedoms`, `rows` and `compliant`
  } at;
};
static_assert(sizeof(Group) == 64, "a cache line: the solver reads one for each group");
static_assert(kNumbers<SolverBlock> + 9 + kNumbers<FreeBlock> +
                      kRows * (kNumbers<FreedomBlock> + kNumbers<RowBlock> + 1) <
                  256,
              "positions of optional parts are bytes");

// The blocks of a group from one lane on; W is its width.
template <int W>
class GroupBlocks {
 public:
  using N = Wide<W>;
  using N8 = Wide<kEight>;
  UNLATCH_INLINE GroupBlocks(const Group& group, double* blocks, int lane)
      : group_(group),
        body_(blocks + group.body + lane),
        shared_(blocks + group.shared + lane),
        joint_(blocks + group.joint + lane),
        solver_(blocks + group.solver + lane) {}

  UNLATCH_INLINE BodyBlock<N8>& body() const { return as_block<BodyBlock, kEight>(body_); }
  UNLATCH_INLINE SharedBlock<N8>& shared() const { return as_block<SharedBlock, kEight>(shared_); }

  UNLATCH_INLINE JointBlock<N>& joint() const { return as_block<JointBlock, W>(joint_); }
  UNLATCH_INLINE N& crossed() const { return *reinterpret_cast<N*>(joint_ + group_.at.crossed * W); }
  UNLATCH_INLINE CarriedBlock<N>& carried() const { return as_block<CarriedBlock, W>(joint_ + group_.at.carried * W); }
  UNLATCH_INLINE Vec3T<N>& carried_axis(int k) const {  // the k-th of those that are kept
    return as_block<Vec3T, W>(joint_ + (group_.at.carried + kNumbers<CarriedBlock> + 3 * k) * W);
  }

  UNLATCH_INLINE SubtreeBlock<N>& subtree() const {
    return as_block<SubtreeBlock, W>(solver_ - kNumbers<SubtreeBlock> * W);
  }
  UNLATCH_INLINE SolverBlock<N>& solver() const { return as_block<SolverBlock, W>(solver_); }
  UNLATCH_INLINE const Vec3T<N>& axis(int r) const {  // of row r
    const std::ptrdiff_t axes =
        r < kRotX ? get_index(&SolverBlock<double>::axes) : group_.at.rotation_axes - 3 * static_cast<int>(kRotX);
    return as_block<Vec3T, W>(solver_ + (axes + 3 * r) * W);
  }
  UNLATCH_INLINE Mat3T<N>& rotation_axes() const { return as_block<Mat3T, W>(solver_ + group_.at.rotation_axes * W); }
  UNLATCH_INLINE FreeBlock<N>& free() const { return as_block<FreeBlock, W>(solver_ + group_.at.free * W); }
  UNLATCH_INLINE FreedomBlock<N>& freedom(int r) const {
    return as_block<FreedomBlock, W>(solver_ + group_.at.freedoms[r] * W);
  }
  UNLATCH_INLINE RowBlock<N>& row(int r) const { return as_block<RowBlock, W>(solver_ + group_.at.rows[r] * W); }
  UNLATCH_INLINE N& pivot(int r) const { return *reinterpret_cast<N*>(solver_ + group_.at.pivots[r] * W); }

 private:
  const Group& group_;
  double *body_, *shared_, *joint_, *solver_;
};

// Its constants likewise. `solver`: PlanData::solver_constants, `joint`: PlanData::joint_constants.
template <int W>
class GroupConstants {
 public:
  using N = Wide<W>;
  UNLATCH_INLINE GroupConstants(const Group& group, const double* solver, const double* joint, int lane)
      : solver_(solver + kNumbers<SolverConstants> * group.first + lane), joint_(joint + group.constants + lane) {}

  UNLATCH_INLINE const SolverConstants<N>& solver() const { return as_block<SolverConstants, W>(solver_); }
  UNLATCH_INLINE const JointConstants<N>& joint() const { return as_block<JointConstants, W>(joint_); }
  UNLATCH_INLINE const RotationConstants<N>& rotation() const {
    return as_block<RotationConstants, W>(joint_ + kNumbers<JointConstants> * W);
  }

 private:
  const double *solver_, *joint_;
};

// --- One body at a time ----------------------------------------------------------------------------------------------

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

// Numbers of one lane, `stride` apart, as a number, vector or matrix; and back.
template <class M>
UNLATCH_INLINE M collect(const double* from, std::ptrdiff_t stride) {
  if constexpr (std::is_same_v<M, double>) return *from;
  if constexpr (std::is_same_v<M, Vec3>) return {from[0], from[stride], from[2 * stride]};
  if constexpr (std::is_same_v<M, Quat>) return {from[0], from[stride], from[2 * stride], from[3 * stride]};
  if constexpr (std::is_same_v<M, Spatial>)
    return {collect<Vec3>(from, stride), collect<Vec3>(from + 3 * stride, stride)};
  if constexpr (std::is_same_v<M, Mat3>)
    return {collect<Vec3>(from, stride), collect<Vec3>(from + 3 * stride, stride),
            collect<Vec3>(from + 6 * stride, stride)};
  if constexpr (std::is_same_v<M, Sym3>)
    return {from[0], from[stride], from[2 * stride], from[3 * stride], from[4 * stride], from[5 * stride]};
  if constexpr (std::is_same_v<M, Factor3T<double>>)
    return {from[0], from[stride], from[2 * stride], from[3 * stride], from[4 * stride], from[5 * stride]};
  if constexpr (std::is_same_v<M, FreeFactor>)
    return {collect<Factor3T<double>>(from, stride), collect<Mat3>(from + 6 * stride, stride),
            collect<Factor3T<double>>(from + 15 * stride, stride)};
  if constexpr (std::is_same_v<M, Articulated>)
    return {collect<Sym3>(from, stride), collect<Mat3>(from + 6 * stride, stride),
            collect<Sym3>(from + 15 * stride, stride)};
  if constexpr (std::is_same_v<M, MotionT<double>>)
    return {collect<Vec3>(from, stride), collect<Quat>(from + 3 * stride, stride),
            collect<Vec3>(from + 7 * stride, stride), collect<Vec3>(from + 10 * stride, stride)};
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
  // The k-th column of a matrix, the k-th number of a vector.
  UNLATCH_INLINE Vec3 read_column(Mat3 Block::*member, int k) const {
    return collect<Vec3>(find(member) + 3 * k * stride, stride);
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

// Its first number, and the distance from one to the next.
struct LanePosition {
  std::int32_t first, stride;
};
template <class Block>
constexpr LanePosition get_position(const Place& place) {
  if constexpr (std::is_same_v<Block, BodyBlock<double>>) return {place.body, kEight};
  if constexpr (std::is_same_v<Block, AppliedBlock<double>>) return {place.body + kNumbers<BodyBlock> * kEight, kEight};
  if constexpr (std::is_same_v<Block, SharedBlock<double>>) return {place.shared, kEight};
  if constexpr (std::is_same_v<Block, JointBlock<double>>) return {place.joint, place.width};
  if constexpr (std::is_same_v<Block, SolverBlock<double>>) return {place.solver, place.width};
  if constexpr (std::is_same_v<Block, SubtreeBlock<double>>)
    return {place.solver - kNumbers<SubtreeBlock> * place.width, place.width};
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

UNLATCH_INLINE NumberPlace find_pivot(const Group& group, const Place& place, int r) {
  return {place.solver + group.at.pivots[r] * place.width};
}
UNLATCH_INLINE NumberPlace find_beta(const Group& group, const Place& place, int r) {
  const auto beta = static_cast<std::int32_t>(get_index(&FreedomBlock<double>::beta));
  return {place.solver + (group.at.freedoms[r] + beta) * place.width};
}

// Optional parts of one lane.
class LaneParts {
 public:
  UNLATCH_INLINE LaneParts(const Group& group, double* blocks, const Place& place)
      : group_(group), joint_(blocks + place.joint), solver_(blocks + place.solver), width_(place.width) {}

  UNLATCH_INLINE double& crossed() const { return joint_[group_.at.crossed * width_]; }
  UNLATCH_INLINE LaneOf<CarriedBlock<double>> carried() const { return {joint_ + group_.at.carried * width_, width_}; }
  UNLATCH_INLINE LaneOf<Vec3> carried_axis(int k) const {
    return {joint_ + (group_.at.carried + kNumbers<CarriedBlock> + 3 * k) * width_, width_};
  }
  UNLATCH_INLINE LaneOf<Mat3> rotation_axes() const { return {solver_ + group_.at.rotation_axes * width_, width_}; }
  UNLATCH_INLINE LaneOf<FreeBlock<double>> free() const { return {solver_ + group_.at.free * width_, width_}; }
  UNLATCH_INLINE LaneOf<FreedomBlock<double>> freedom(int r) const {
    return {solver_ + group_.at.freedoms[r] * width_, width_};
  }
  UNLATCH_INLINE LaneOf<RowBlock<double>> row(int r) const { return {solver_ + group_.at.rows[r] * width_, width_}; }
  UNLATCH_INLINE double& pivot(int r) const { return solver_[group_.at.pivots[r] * width_]; }

 private:
  const Group& group_;
  double *joint_, *solver_;
  std::ptrdiff_t width_;
};

}  // namespace unlatch
