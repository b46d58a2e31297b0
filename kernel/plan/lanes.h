// Lanes: how the bodies of a plan lie side by side, so that siblings, levels and samples are computed together. Every
// field is a row of numbers, one per lane: an array of structures of arrays, Workspace::lanes.
//
// What bodies do by themselves they do in octets, eight of them side by side, whatever they are and wherever in the
// tree. What joints and the solver do goes by groups: the nodes of the tree, level by level, are cut into groups of 8,
// 4, 2 or 1 of one kind. A group's bodies are neighbours in one octet.
// The cut depends on the model alone, never on the processor; a narrower processor takes a wide group in parts. Since
// lanes never meet, and children are added to a parent in one frozen order, every width gives the same bits.
//
// Beyond the caches the solver costs what it fetches: what it reads lies apart from the rest, block after block.
//
// A lane that no node fills holds a body at rest which nothing holds; it gives its neighbours nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "unlatch/model.h"

namespace unlatch {

class Plan;
struct PlanNode;

inline constexpr int kOctet = 8;

// Rows of an octet's first block, from LaneOctet::body on.
enum BodyField : std::int16_t {
  kPose = 0,               // p_WB, q_WB at the stage
  kVelocity = kPose + 7,   // v_WB, w_WB_B
  kStart = kVelocity + 6,  // pose and velocity at the beginning of the sub-step
  kSum = kStart + 13,      // weighted sum of the stages' rates
  kFirst = kSum + 13,      // dv/dt, dw/dt at the beginning of the sub-step
  kRotation = kFirst + 6,  // R_WB, column by column
  kOmega = kRotation + 9,  // w_WB in world axes
  kBodyEnd = kOmega + 3,
  kApplied = kBodyEnd,  // force and torque of loads fixed in the bodies, body axes, if LaneOctet::loaded
  kLoadedEnd = kApplied + 6,
};
// Rows of its second, from LaneOctet::shared on: what bodies and solver have in common.
enum SharedField : std::int16_t {
  kInertia = 0,                // in world axes: xx yy zz xy xz yz
  kForce = kInertia + 6,       // applied force and torque, gyroscopic torque included
  kAcceleration = kForce + 6,  // of the latest solve, world axes
  kSharedEnd = kAcceleration + 6,
};
// Rows of the joints that hold a group to their parents, from LaneGroup::joint on, before those that not every group
// needs.
enum JointField : std::int16_t {
  kArmParent = 0,         // from the parent's origin to the follower's point
  kGap = kArmParent + 3,  // displacement of the follower's point along n
  kSlip = kGap + 3,       // v_rel, w_rel
  kJointMotionEnd = kSlip + 6,
};
// Rows of a group in the solver, from LaneGroup::data on, before those that not every group needs.
enum LaneField : std::int32_t {
  // of bodies with something beyond them, before the rest
  kBlock = -27,  // A of the body and all beyond it: M, H, I (21), then the load (6)
  // of the joint to the parent
  kArmChild = 0,             // from the child's origin to the follower's point
  kOffset = kArmChild + 3,   // from the parent's origin to the child's
  kBias = kOffset + 3,       // what the joint imposes on the child besides its freedoms, at the child's origin
  kAxes = kBias + 6,         // n
  kMultipliers = kAxes + 9,  // in the order of Row
  kHeld = kMultipliers + 6,  // mask: three rows or more hold, the child is eliminated through its freedoms
  kJointEnd = kHeld + 1,
};
constexpr BodyField operator+(BodyField row, int rows) { return static_cast<BodyField>(static_cast<int>(row) + rows); }
constexpr SharedField operator+(SharedField row, int rows) {
  return static_cast<SharedField>(static_cast<int>(row) + rows);
}
constexpr JointField operator+(JointField row, int rows) {
  return static_cast<JointField>(static_cast<int>(row) + rows);
}
// A freedom's part: mask, U = A s, 1 / sᵀ A s, sᵀ b and later the freedom's acceleration.
enum FreedomField : std::int32_t { kMask = 0, kU = 1, kInverse = 7, kBeta = 8, kFreedomEnd = 9 };
// A row's part, where one or two hold: mask, its wrench w at the child's origin, A⁻¹ w, 1 / wᵀ A⁻¹ w, and μ.
enum RowField : std::int32_t { kRowMask = 0, kWrench = 1, kReply = 7, kRowInverse = 13, kMu = 14, kRowEnd = 15 };
inline constexpr int kBlockFields = -kBlock;
inline constexpr int kFreeFields = 27;  // factor of A (21), then A⁻¹ b (6)

// What a joint's mode keeps, per lane: the offsets of its point rows along n, and per carried axis where it is in the
// follower, times its weight.
inline constexpr int kOffsetFields = 3;

// Constants of bodies, in Plan::body_constants from LaneOctet::constants on,
enum BodyConstant : std::int32_t {
  kBodyInertia = 0,
  kBodyMass = 6,
  kBodyConstants = 7,
};
// of joints, in Plan::joint_constants from LaneGroup::constants on, as many as the group needs,
enum JointConstant : std::int32_t {
  kPointBase = 0,
  kPointFollower = 3,
  kBaseAxes = 6,  // axes of the point–plane rows in base axes, column by column
  kSharedConstants = 15,
  kRotationAxes = kSharedConstants,  // of the rotation rows, where they are others
  kFollowerY = 24,                   // y of the rotation frame in follower axes
  kAllConstants = 27,
};
// and of the solver, in Plan::solver_constants from kSolverConstants · LaneGroup::first on.
enum SolverConstant : std::int32_t {
  kMass = 0,
  kSide = 1,  // +1: the child is the joint's follower; −1: its base; 0: the lane is empty
  kSolverConstants = 2,
};
constexpr BodyConstant operator+(BodyConstant row, int rows) {
  return static_cast<BodyConstant>(static_cast<int>(row) + rows);
}
constexpr JointConstant operator+(JointConstant row, int rows) {
  return static_cast<JointConstant>(static_cast<int>(row) + rows);
}

struct LaneOctet {
  std::int32_t body, shared;  // its blocks in Workspace::lanes, in numbers
  std::int32_t constants;     // its block in Plan::body_constants
  std::uint8_t lanes;         // bit i: lane i belongs to a group
  std::uint8_t bodies;        // bit i: it has a body
  bool loaded;                // some body has a load that is fixed in it
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
  std::int32_t first;         // of its lanes: into Plan::lane_nodes and Plan::lane_parents
  std::int32_t body, shared;  // where its first lane is in Workspace::lanes, in the octet's blocks
  std::int32_t joint, data;   // its own blocks there
  std::int32_t constants;     // its block in Plan::joint_constants
  std::int32_t begins;        // group whose blocks it is the first to add to, all of them; or kNone
  std::uint8_t size;          // of its block in the solver, in rows from LaneField 0 on
  std::uint8_t width;         // 1, 2, 4 or 8
  std::uint8_t count;         // lanes in use
  LaneLink link;
  LaneSpecial special;
  LaneSides sides;                    // what the children are to their joints
  bool fan_begins : 1, fan_ends : 1;  // first and last group of a fan as the sums go, from the leaves to the root
  bool leaf : 1;                      // nothing is beyond any of its bodies
  bool has_joint : 1;                 // to the parent or the ground
  bool shared_axes : 1;               // one frame for point–plane and rotation rows
  bool universal : 1;
  bool may_be_loose : 1;  // some mode leaves fewer than three rows, or a lane is empty
  RowSet freedoms;        // that some mode of three rows or more leaves
  RowSet rows;            // that some mode of one or two rows holds
  RowSet compliant;       // freedoms with springs that are integrated implicitly
  std::uint8_t carried;   // bit a: some mode's orientation is measured by where axis a has gone
  // where the optional parts begin, in rows: of its joints' block
  JointField crossed, carried_axes;
  // and of its block in the solver
  std::uint8_t rotation_axes, free;
  std::uint8_t freedom_parts[kRows], row_parts[kRows];  // per row, of those in `freedoms` and in `rows`
  std::uint8_t pivots[kRows];                           // of those in `compliant`: what is added to the pivot
};
static_assert(sizeof(LaneGroup) == 64, "a cache line: the solver reads one for each group");
static_assert(kJointEnd + 9 + kFreeFields + kRows * 25 < 256, "the last row that there can be");
static_assert(kFreedomEnd + int{kRowEnd} + 1 == 25);

// Where one body's and its joint's numbers are in Workspace::lanes: row r is at the block's place + r · kOctet, or
// + r · stride for what goes by groups.
struct LaneSlot {
  std::int32_t data, joint;
  std::int32_t body, shared;
  std::int32_t stride;
};

constexpr LaneSlot get_slot(const LaneGroup& group, int lane) {
  return {group.data + lane, group.joint + lane, group.body + lane, group.shared + lane, group.width};
}

// Numbers of Workspace::lanes that are a stride apart.
struct LaneColumn {
  std::int32_t first, stride;
};

// Orders the nodes of the tree by groups, parents before children, and lays out the lanes. O(n log n) for sorting.
void compile_lanes(const Model& model, Plan& plan);

}  // namespace unlatch
