// Residuals of joints one at a time: of non-tree joints, of drift, and the memory of a mode. Joints of the tree have
// theirs in groups (tree_joints.h), from the same formulas (joint_motion.h).
#pragma once

#include "kernel/joints/joint_motion.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// All non-tree joints, or those that hold at least one row: in a stage nothing else reads a frame if no force is driven
// by a coordinate (PlanData::driven_coordinates).
enum class JointSet { kAll, kHolding };

// Frames of the non-tree joints and the right-hand sides of their rows, from the bodies' kinematics.
void update_non_tree_joints(const PlanData& plan, const State& state, RowTarget target, JointSet joints,
                            Evaluation& ev) noexcept;

// Axis `a` of the rotation frame as the follower carries it (follower axes), times its weight in the orientation
// residual Σ a × carried: 1 where the two other rotation rows hold, ½ where all three do, 0 elsewhere.
Vec3 calc_carried_axis(const PlanJoint& joint, const JointState& memory, RowSet rows, int a) noexcept;

// Largest position residual of any active row: m or rad. The projections keep it small.
double calc_drift(const PlanData& plan, const State& state, const Evaluation& ev) noexcept;

}  // namespace unlatch
