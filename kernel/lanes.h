// Lanes: how the bodies of a plan lie side by side, so that siblings, levels and samples are computed together.
//
// The nodes of the tree, level by level, are cut into groups of 8, 4, 2 or 1. A group owns two blocks of
// Workspace::lanes in which every field is a row of `width` numbers, one per lane: an array of structures of arrays.
// One holds what moves the bodies, the other what the solver reads: beyond the caches the solver costs what it fetches,
// and its blocks follow each other.
// The cut depends on the model alone, never on the processor; a narrower processor takes a wide group in parts. Since
// lanes never meet, and children are added to a parent in one frozen order, every width gives the same bits.
//
// A lane that no node fills holds a body at rest which nothing holds; it gives its neighbours nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernel/model.h"

namespace unlatch {

class Plan;
struct PlanNode;

// Rows of a group's first block, from LaneGroup::motion on.
enum MotionField : std::int16_t {
  // of the body
  kPose = 0,               // p_WB, q_WB at the stage
  kVelocity = kPose + 7,   // v_WB, w_WB_B
  kStart = kVelocity + 6,  // pose and velocity at the beginning of the sub-step
  kSum = kStart + 13,      // weighted sum of the stages' rates
  kFirst = kSum + 13,      // dv/dt, dw/dt at the beginning of the sub-step
  kRotation = kFirst + 6,  // R_WB, column by column
  kOmega = kRotation + 9,  // w_WB in world axes
  kBodyMotionEnd = kOmega + 3,
  // of the joint to the parent
  kArmParent = kBodyMotionEnd,  // from the parent's origin to the follower's point
  kGap = kArmParent + 3,        // displacement of the follower's point along n
  kSlip = kGap + 3,             // v_rel, w_rel
  kMotionEnd = kSlip + 6,
};
constexpr MotionField operator+(MotionField row, int rows) {
  return static_cast<MotionField>(static_cast<int>(row) + rows);
}
// Rows of its second block, from LaneGroup::data on. Both blocks have parts that not every group needs, see LaneGroup.
enum LaneField : std::int32_t {
  // of a body with something beyond it, before the rest
  kBlock = -27,  // A of the body and all beyond it: M, H, I (21), then the load (6)
  // of the body
  kInertia = 0,                // in world axes: xx yy zz xy xz yz
  kForce = kInertia + 6,       // applied force and torque, gyroscopic torque included
  kAcceleration = kForce + 6,  // of the latest solve, world axes
  kBodyEnd = kAcceleration + 6,
  // of the joint to the parent
  kArmChild = kBodyEnd,      // from the child's origin to the follower's point
  kOffset = kArmChild + 3,   // from the parent's origin to the child's
  kBias = kOffset + 3,       // what the joint imposes on the child besides its freedoms, at the child's origin
  kAxes = kBias + 6,         // n
  kMultipliers = kAxes + 9,  // in the order of Row
  kHeld = kMultipliers + 6,  // mask: three rows or more hold, the child is eliminated through its freedoms
  kJointEnd = kHeld + 1,
};
// A freedom's part: mask, U = A s, 1 / sᵀ A s, sᵀ b and later the freedom's acceleration.
enum FreedomField : std::int32_t { kMask = 0, kU = 1, kInverse = 7, kBeta = 8, kFreedomEnd = 9 };
// A row's part, where one or two hold: mask, its wrench w at the child's origin, A⁻¹ w, 1 / wᵀ A⁻¹ w, and μ.
enum RowField : std::int32_t { kRowMask = 0, kWrench = 1, kReply = 7, kRowInverse = 13, kMu = 14, kRowEnd = 15 };
inline constexpr int kBlockFields = -kBlock;
inline constexpr int kFreeFields = 27;  // factor of A (21), then A⁻¹ b (6)

// What a joint's mode keeps, per lane: the offsets of its point rows along n, and per carried axis where it is in the
// follower, times its weight.
inline constexpr int kOffsetFields = 3;

// Constants of a lane, apart for the same reason: in Plan::lane_constants, from LaneGroup::constants on, as many as the
// group needs,
enum MotionConstant : std::int32_t {
  kBodyInertia = 0,
  kBodyConstants = 6,
  kPointBase = kBodyConstants,
  kPointFollower = 9,
  kBaseAxes = 12,  // axes of the point–plane rows in base axes, column by column
  kSharedConstants = 21,
  kRotationAxes = kSharedConstants,  // of the rotation rows, where they are others
  kFollowerY = 30,                   // y of the rotation frame in follower axes
  kAllConstants = 33,
};
constexpr MotionConstant operator+(MotionConstant row, int rows) {
  return static_cast<MotionConstant>(static_cast<std::int32_t>(row) + rows);
}
// and in Plan::solver_constants, from kSolverConstants · LaneGroup::first on.
enum SolverConstant : std::int32_t {
  kMass = 0,
  kSide = 1,  // +1: the child is the joint's follower; −1: its base; 0: the lane is empty
  kSolverConstants = 2,
};

// How a group finds its parents.
enum class LaneLink : std::uint8_t {
  kRoot,        // they have none
  kFan,         // one parent for the whole group
  kContiguous,  // the parents are the lanes of one group, in the same order
  kGather,      // anywhere in the levels above
};

// What the modes of its joints make of a group. Computed by update_phases().
struct LanePhase {
  RowSet freedoms, rows;  // that some lane has
  bool held, loose;       // some lane is held by three rows or more, by fewer
  bool hinged;            // every lane is held, and has no freedom but one, the same for all
};

// Nodes that the lanes leave to flexible.h in the solver.
enum class LaneSpecial : std::uint8_t {
  kOrdinary,
  kFlexible,  // a flexible body
  kMarker,    // a marker beyond its body
};

enum class LaneSides : std::uint8_t { kFollowers, kBases, kMixed };

struct alignas(64) LaneGroup {
  std::int32_t first;   // of its lanes: into Plan::lane_nodes and Plan::lane_parents
  std::int32_t motion;  // its blocks in Workspace::lanes, in numbers
  std::int32_t data;
  std::int32_t size;       // of the second, in rows from LaneField 0 on
  std::int32_t constants;  // its block in Plan::lane_constants
  std::int32_t begins;     // group whose blocks it is the first to add to, all of them; or kNone
  std::uint8_t width;      // 1, 2, 4 or 8
  std::uint8_t count;      // lanes in use
  LaneLink link;
  bool fan_begins : 1, fan_ends : 1;  // first and last group of a fan as the sums go, from the leaves to the root
  bool leaf : 1;                      // nothing is beyond any of its bodies
  bool has_joint : 1;                 // to the parent or the ground
  bool shared_axes : 1;               // one frame for point–plane and rotation rows
  bool universal : 1;
  bool may_be_loose : 1;  // some mode leaves fewer than three rows, or a lane is empty
  LaneSides sides;        // what the children are to their joints
  RowSet freedoms;        // that some mode of three rows or more leaves
  RowSet rows;            // that some mode of one or two rows holds
  RowSet compliant;       // freedoms with springs that are integrated implicitly
  LaneSpecial special;
  std::uint8_t carried;  // bit a: some mode's orientation is measured by where axis a has gone
  // where the optional parts begin, in rows
  MotionField crossed, carried_axes;
  MotionField applied;  // force and torque of loads fixed in the bodies, body axes; kPose: there are none
  std::uint8_t rotation_axes, free;
  std::uint8_t freedom_parts[kRows], row_parts[kRows];  // per row, of those in `freedoms` and in `rows`
  std::uint8_t pivots[kRows];                           // of those in `compliant`: what is added to the pivot
};
static_assert(sizeof(LaneGroup) == 64, "a cache line: the solver reads one for each group");
static_assert(kJointEnd + 9 + kFreeFields + kRows * 25 < 256, "the last row that there can be");
static_assert(kFreedomEnd + int{kRowEnd} + 1 == 25);

// Where one body's or joint's numbers are: row r of it is lanes[offset + r · stride], or lanes[motion + r · stride] for
// a MotionField.
struct LaneSlot {
  std::int32_t motion, offset;
  std::int32_t stride;
};

// Orders the nodes of the tree by groups, parents before children, and lays out the lanes. O(n log n) for sorting.
void compile_lanes(const Model& model, Plan& plan);

}  // namespace unlatch
