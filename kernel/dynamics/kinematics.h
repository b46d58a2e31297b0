// Where everything is and how it moves at one stage: rotation matrices, world inertias, joint frames and coordinates.
#pragma once

#include "kernel/dispatch/lane_kernels.h"
#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// Position, velocity and attitude of a body or of the ground.
struct BodyFrame {
  Mat3 R;
  Vec3 p, v, w;  // world axes
};
BodyFrame get_body_frame(const Workspace& ws, int body) noexcept;

// Any joint's frame, wherever it is kept.
JointFrame get_joint_frame(const Plan& plan, const State& state, const Workspace& ws, int joint) noexcept;

// Parts of it, for those who need no more: the axis of a row; the arm from a body's origin to the follower's point.
Vec3 get_axis(const Plan& plan, const Workspace& ws, int joint, int row) noexcept;
Vec3 get_arm(const Plan& plan, const Workspace& ws, int joint, bool of_follower) noexcept;

// Rotations, angular velocities and inertias of all bodies.
void update_kinematics(const Plan& plan, Workspace& ws) noexcept;

// The same where only velocities have changed since.
void update_rates(const Plan& plan, Workspace& ws) noexcept;

// Frames of all joints and the right-hand sides of their rows; needs kinematics. For accelerations also the forces that
// the lanes sum (init_forces() in lane_kernels.h); needs loads.
void update_joints(const Plan& plan, const State& state, BiasKind kind, Workspace& ws) noexcept;

// The same for accelerations, where neither poses nor modes have changed since: only velocities have.
void renew_joints(const Plan& plan, const State& state, Workspace& ws) noexcept;

// ws.coordinates and ws.speeds that springs, or all that springs, guards and sensors, read; needs the joints' frames.
// Angles are counted on from those in the state's joints.
void update_coordinates(const Plan& plan, const State& state, bool all, Workspace& ws) noexcept;

// The rotation frame as the follower carries it, in world axes.
Mat3 calc_follower_axes(const Plan& plan, const Workspace& ws, int joint) noexcept;

// The turn about axis k of the rotation frame by which the follower's frame stands from the base's, in (−π, π]: exact
// for a turn about that axis alone, and for both axes of a universal joint.
double calc_twist(const Mat3& base, const Mat3& follower, int k) noexcept;

// Relative attitude of a joint's rotation frame, follower to base.
Quat calc_relative_attitude(const Plan& plan, const Workspace& ws, int joint) noexcept;

// Whether a universal joint's rotation frame follows its cross.
inline bool is_crossed(const PlanJoint& joint, RowSet rows) noexcept {
  return joint.universal && (rows & kRotationRows) == row_bit(kRotZ);
}

// Which rows of a joint hold now.
inline RowSet get_active_rows(const Plan& plan, const State& state, int joint) noexcept {
  return plan.get_rows(joint, state.joints[static_cast<std::size_t>(joint)].mode);
}

}  // namespace unlatch
