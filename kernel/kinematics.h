// Where everything is and how it moves at one stage: rotation matrices, world inertias, joint frames and coordinates.
#pragma once

#include "kernel/plan.h"
#include "kernel/workspace.h"

namespace unlatch {

// Position, velocity and attitude of a body or of the ground.
struct BodyFrame {
  Mat3 R;
  Vec3 p, v, w;  // world axes
};
inline BodyFrame get_body_frame(const State& state, const Workspace& ws, int body) noexcept {
  if (body == kGround) return {kIdentity3, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const BodyState& s = state.bodies[static_cast<std::size_t>(body)];
  const BodyKinematics& k = ws.kinematics[static_cast<std::size_t>(body)];
  return {k.R, s.p, s.v, k.w};
}

// ws.kinematics from the poses and velocities of `state`.
void update_kinematics(const Plan& plan, const State& state, Workspace& ws) noexcept;

// ws.frames; needs ws.kinematics.
void update_joint_frames(const Plan& plan, const State& state, Workspace& ws) noexcept;

// ws.coordinates and ws.speeds of the joints that a spring, guard or sensor reads; needs ws.frames. Angles are counted
// on from those in the state's joints.
void update_coordinates(const Plan& plan, const State& state, Workspace& ws) noexcept;

// The rotation frame as the follower carries it, in world axes.
Mat3 calc_follower_axes(const Plan& plan, const Workspace& ws, int joint) noexcept;

// The turn about axis k of the rotation frame by which the follower's frame stands from the base's, in (−π, π]: exact
// for a turn about that axis alone, and for both axes of a universal joint.
double calc_twist(const Mat3& base, const Mat3& follower, int k) noexcept;

// Relative attitude of a joint's rotation frame, follower to base.
Quat calc_relative_attitude(const Plan& plan, const State& state, int joint) noexcept;

// Which rows of a joint hold now.
inline RowSet get_active_rows(const Plan& plan, const State& state, int joint) noexcept {
  return plan.get_rows(joint, state.joints[static_cast<std::size_t>(joint)].mode);
}

}  // namespace unlatch
