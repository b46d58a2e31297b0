#include "kernel/dynamics/rows.h"

#include <algorithm>

#include "kernel/dynamics/kinematics.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// What relative angular acceleration the rotation rows ask for. The second, with y the follower's y axis:
//   n fixed in the base:   d/dt n·(w_f − w_b) = n·(α_f − α_b + w_f × w_b) = 0, so α_f − α_b = w_b × w_f along n;
//   n = N/|N|, N = x_b × y_f: g = x_b·y_f, dg/dt = −N·w_rel, so N·α_rel = −(dN/dt)·w_rel.
Vec3 calc_crossed_bias(const JointFrame& f, const Vec3& y, const Vec3& w_base, const Vec3& w_follower) {
  const Vec3 normal = cross(f.m.x, y);
  const Vec3 normal_rate = cross(cross(w_base, f.m.x), y) + cross(f.m.x, cross(w_follower, y));
  return (-dot(normal_rate, f.w_rel) / norm(normal)) * f.m.z;
}

// q a q*
Vec3 turn(const Quat& q, const Vec3& a) {
  const Vec3 u{q.x, q.y, q.z};
  const Vec3 t = 2.0 * cross(u, a);
  return (a + q.w * t) + cross(u, t);
}

// Orientation residual along the rotation frame's axes, built so that its rate is that axis' component of w_rel.
//   three rows: the rotation vector from the relative attitude `locked`;
//   two rows, free axis a: m_k·(a_base × a_follower), a_follower being where the locked attitude had a;
//   the row of a universal joint: −x_b·y_f / |x_b × y_f|.
Vec3 calc_orientation_gap(const Plan& plan, const State& state, const Workspace& ws, int joint) {
  const JointFrame f = get_joint_frame(plan, state, ws, joint);
  const RowSet rotation = get_active_rows(plan, state, joint) & kRotationRows;
  const Quat& locked = state.joints[at(joint)].locked;
  if (rotation == kRotationRows) {
    const Quat error = calc_relative_attitude(plan, ws, joint) * conjugate(locked);
    const double twice = error.w < 0 ? -2 : 2;
    return {twice * error.x, twice * error.y, twice * error.z};
  }
  const Mat3 follower = calc_follower_axes(plan, ws, joint);
  if (f.crossed) return {0, 0, -dot(f.m.x, follower.y) / norm(cross(f.m.x, follower.y))};
  for (int a = 0; a < 3; ++a) {
    const RowSet others = kRotationRows & static_cast<RowSet>(~row_bit(kRotX + a));
    if (rotation != others) continue;
    const Vec3 carried = follower * turn(conjugate(locked), column(kIdentity3, a));
    return transpose_times(f.m, cross(column(f.m, a), carried));
  }
  return {0, 0, 0};
}

}  // namespace

Vec3 calc_carried_axis(const PlanJoint& joint, const JointState& memory, RowSet rows, int a) noexcept {
  const RowSet rotation = rows & kRotationRows;
  const Vec3 carried = turn(joint.rotation_follower, turn(conjugate(memory.locked), column(kIdentity3, a)));
  if (rotation == (kRotationRows & static_cast<RowSet>(~row_bit(kRotX + a)))) return carried;
  if (rotation == kRotationRows) return 0.5 * carried;
  return {0, 0, 0};
}

Spatial calc_bias(const Plan& plan, const State& state, const Workspace& ws, int joint, BiasKind kind) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  const JointFrame f = get_joint_frame(plan, state, ws, joint);
  if (kind == BiasKind::kVelocity) return {-f.v_rel, -f.w_rel};
  if (kind == BiasKind::kPosition)
    return {-(f.n * (f.displacement - state.joints[at(joint)].offset)),
            -(f.m * calc_orientation_gap(plan, state, ws, joint))};
  const Vec3 w_base = get_body_frame(ws, j.base).w, w_follower = get_body_frame(ws, j.follower).w;
  return {(cross(w_base, cross(w_base, f.r_base)) + 2.0 * cross(w_base, f.v_rel)) -
              cross(w_follower, cross(w_follower, f.r_follower)),
          f.crossed ? calc_crossed_bias(f, calc_follower_axes(plan, ws, joint).y, w_base, w_follower)
                    : cross(w_base, w_follower)};
}

double calc_drift(const Plan& plan, const State& state, const Workspace& ws) noexcept {
  double drift = 0;
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const RowSet rows = get_active_rows(plan, state, j);
    const JointFrame f = get_joint_frame(plan, state, ws, j);
    const Vec3 angles = calc_orientation_gap(plan, state, ws, j);
    const Vec3 gap = f.displacement - state.joints[at(j)].offset;
    const double gaps[kRows] = {gap.x, gap.y, gap.z, angles.x, angles.y, angles.z};
    for (int r = 0; r < kRows; ++r)
      if (has_row(rows, r)) drift = std::max(drift, std::abs(gaps[r]));
  }
  return drift;
}

}  // namespace unlatch
