#include "kernel/joints/residuals.h"

#include <algorithm>
#include <cmath>

#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

// q a q*
Vec3 turn(const Quat& q, const Vec3& a) {
  const Vec3 u{q.x, q.y, q.z};
  const Vec3 t = 2.0 * cross(u, a);
  return (a + q.w * t) + cross(u, t);
}

// Orientation residual along the rotation frame's axes, built so that its rate is that axis' component of w_rel.
//   three rows: the rotation vector from the relative attitude `locked`, as 2 e sin(θ/2); groups take e sin θ instead,
//     see THEORY.md, section 4;
//   two rows, free axis a: m_k·(a_base × a_follower), a_follower being where the locked attitude had a;
//   the row of a universal joint: −x_b·y_f / |x_b × y_f|.
// A single row fixed in the base is non-holonomic and has none.
Vec3 calc_orientation_residual(const PlanData& plan, const State& state, const Evaluation& ev, int joint,
                               const JointFrame& f) {
  const RowSet rotation = get_active_rows(plan, state, joint) & kRotationRows;
  const Quat& locked = state.joints[at(joint)].locked;
  if (rotation == kRotationRows) {
    const Quat error = calc_relative_attitude(plan, ev, joint) * conjugate(locked);
    const double twice = error.w < 0 ? -2 : 2;
    return {twice * error.x, twice * error.y, twice * error.z};
  }
  const Mat3 follower = calc_follower_axes(plan, ev, joint);
  if (f.crossed) return {0, 0, -calc_cross_target(follower.y, f)};
  for (int a = 0; a < 3; ++a) {
    if ((get_carried_axes(rotation) >> a & 1) == 0) continue;
    const Vec3 carried = follower * turn(conjugate(locked), column(kIdentity3, a));
    return transpose_times(f.m, cross(column(f.m, a), carried));
  }
  return {0, 0, 0};
}

// The right-hand sides of a non-tree joint's rows, at the follower's point and about it.
Spatial calc_target(const PlanData& plan, const State& state, const Evaluation& ev, int joint, RowTarget target) {
  const PlanJoint& j = plan.joints[at(joint)];
  const JointFrame& f = ev.non_tree_frames[at(j.non_tree)];
  if (target == RowTarget::kVelocity) return calc_velocity_target(f);
  if (target == RowTarget::kPosition)
    return {calc_position_target(f, state.joints[at(joint)].offset),
            -(f.m * calc_orientation_residual(plan, state, ev, joint, f))};
  const BodyFrame base = get_body_frame(ev, j.base), follower = get_body_frame(ev, j.follower);
  Spatial bias = calc_acceleration_target(base, follower, f);
  if (f.crossed) bias.ang = calc_cross_acceleration(base.w, follower.w, calc_follower_axes(plan, ev, joint).y, f);
  return bias;
}

}  // namespace

void update_non_tree_joints(const PlanData& plan, const State& state, RowTarget target, JointSet joints,
                            Evaluation& ev) noexcept {
  BodyFrame base{}, follower{};
  std::int32_t of_base = kNone - 1, of_follower = of_base;  // whose these are: bolts in a row have the same two
  for (std::size_t i = 0; i < plan.non_tree_joints.size(); ++i) {
    const PlanNonTreeJoint& own = plan.non_tree_joints[i];
    const PlanJoint& joint = plan.joints[at(own.joint)];
    const RowSet rows = get_active_rows(plan, state, own.joint);
    if (joints == JointSet::kHolding && rows == 0) continue;
    if (joint.base != of_base) base = get_body_frame(ev, of_base = joint.base);
    if (joint.follower != of_follower) follower = get_body_frame(ev, of_follower = joint.follower);
    JointFrame& f = ev.non_tree_frames[i];
    f = calc_joint_frame(base, follower, own.point_base, own.point_follower, own.axes);
    f.m = base.R * own.rotation_axes;
    f.crossed = is_crossed(joint, rows);
    if (f.crossed) cross_axes(follower.R * own.follower_y, f);
  }
  for (const std::int32_t j : plan.loops) {
    Spatial& bias = ev.non_tree_bias[at(plan.joints[at(j)].non_tree)];
    bias = get_active_rows(plan, state, j) == 0 ? Spatial{} : calc_target(plan, state, ev, j, target);
  }
}

Vec3 calc_carried_axis(const PlanJoint& joint, const JointState& memory, RowSet rows, int a) noexcept {
  if ((get_carried_axes(rows) >> a & 1) == 0) return {0, 0, 0};
  const Vec3 carried = turn(joint.rotation_follower, turn(conjugate(memory.locked), column(kIdentity3, a)));
  return (rows & kRotationRows) == kRotationRows ? 0.5 * carried : carried;
}

double calc_drift(const PlanData& plan, const State& state, const Evaluation& ev) noexcept {
  double drift = 0;
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const RowSet rows = get_active_rows(plan, state, j);
    const JointFrame f = get_joint_frame(plan, state, ev, j);
    const Vec3 angles = calc_orientation_residual(plan, state, ev, j, f);
    const Vec3 gap = f.displacement - state.joints[at(j)].offset;
    const double residuals[kRows] = {gap.x, gap.y, gap.z, angles.x, angles.y, angles.z};
    for (int r = 0; r < kRows; ++r)
      if (has_row(rows, r)) drift = std::max(drift, std::abs(residuals[r]));
  }
  return drift;
}

}  // namespace unlatch
