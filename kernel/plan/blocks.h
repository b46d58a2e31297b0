// Blocks: how the numbers of bodies and joints lie in memory. Positions are known to this file and to the two that
// build on it, group.h (where the blocks of a group are) and lanes.h (one body at a time); all other code uses typed
// members.
//
// Bodies or joints that are computed side by side lie side by side, one per lane. A block's struct is written once,
// over a number type N:
//   N = Wide<W>  the block itself, each member W numbers wide (kernel/simd/wide.h)
//   N = double   one lane of it, read and written at a Place: read(memory, place, &BodyBlock<double>::motion)
//
// Bodies by themselves (Runge–Kutta, kinematics, forces) are computed in blocks of eight, wherever they are in the
// tree. Joints and the solver work on groups: nodes of one level and kind, 8, 4, 2 or 1 wide. The bodies of a group are
// neighbours in one block of eight. The division into groups depends on the model alone, never on the processor; a
// processor with narrower registers computes a wide block in parts. No lane reads another one, and children are added
// to their parent in one fixed order, so every width gives the same bits.
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
//   [ ]: only where the group needs it. Blocks begin at cache lines. A system that is larger than the caches is solved
//   as fast as its blocks are fetched, so what the solver reads lies apart from the rest, in the order of its sweeps.
//
// A lane without a node has a body of mass 0 at rest, held by nothing; it adds nothing to any other lane. Masks are
// numbers with all bits set or none.
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
// Numbers of a cache line, at which blocks begin.
inline constexpr int kLineNumbers = 64 / sizeof(double);

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
  MotionT<N> sum;                       // of the rates of the stages so far, weighted as runge_kutta.h says
  Vec3T<N> start_v_rate, start_w_rate;  // dv/dt (inertial axes), dw/dt (body axes) at the beginning of the sub-step
  Mat3T<N> R;                           // R_WB
  Vec3T<N> w_W;                         // angular velocity, world axes
};
// Sum of the loads that are fixed in the body.
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
// What a joint's mode remembers: the displacements at which its point–plane rows hold. Behind this block, for each axis
// in Group::carried: the axis as the follower carries it (follower axes), times its weight in the residual.
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

// Inertia and wrench of a body that has others outboard of it: the elimination adds to them what the children pass on.
template <class N>
struct SubtreeBlock {
  ArticulatedT<N> A;   // inertia of the body and all outboard of it
  SpatialT<N> wrench;  // force and torque on them, as far as their joints pass it on
};
inline constexpr int kWrenchIndex = sizeof(ArticulatedT<double>) / sizeof(double);  // position of the wrench
static_assert(offsetof(SubtreeBlock<double>, wrench) == kWrenchIndex * sizeof(double));

template <class N>
struct SolverBlock {
  Vec3T<N> arm_child;    // from the child's origin to the follower's point
  Vec3T<N> offset;       // from the parent's origin to the child's
  SpatialT<N> bias;      // relative acceleration that the rows prescribe, at the child's origin
  Mat3T<N> axes;         // n of the point–plane rows
  N multipliers[kRows];  // in the order of Row; 0 where no row holds
  N by_freedoms;         // mask: three rows or more hold, the child is eliminated through its freedoms
};
// A body that is held by nothing, or by one or two rows: its whole block is factored.
template <class N>
struct FreeBlock {
  FreeFactorT<N> factor;
  SpatialT<N> response;  // A⁻¹ wrench
};
// A degree of freedom s of the joint.
template <class N>
struct FreedomBlock {
  N mask;           // the lane's mode leaves it free
  SpatialT<N> U;    // A s
  N inverse_pivot;  // 1 / sᵀ A s
  N beta;           // sᵀ wrench, by the backward pass
  N acceleration;   // along s, by the forward pass
};
// A row of a joint of which one or two rows hold.
template <class N>
struct RowBlock {
  N mask;                // it holds in the lane's mode
  SpatialT<N> wrench;    // w, on the child at its origin
  SpatialT<N> response;  // A⁻¹ w
  N inverse_pivot;       // 1 / wᵀ A⁻¹ w
  N mu;                  // w·(A⁻¹ wrench − bias) / pivot: it passes on μ w
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

// --- Neighbours: blocks that lie beside another one, without a position of their own --------------------------------

inline constexpr int kAppliedAfterBody = kNumbers<BodyBlock>;         // the AppliedBlock, from the BodyBlock on
inline constexpr int kSubtreeBeforeSolver = kNumbers<SubtreeBlock>;   // the SubtreeBlock, before the SolverBlock
inline constexpr int kRotationAfterJoint = kNumbers<JointConstants>;  // RotationConstants, from JointConstants on
inline constexpr int kAxesAfterCarried = kNumbers<CarriedBlock>;      // the carried axes, from the CarriedBlock on

}  // namespace unlatch
