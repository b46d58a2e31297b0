#include "kernel/rows.h"

#include <algorithm>

#include "kernel/kinematics.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Components of `a` along those axes whose rows hold, put together again. `shift`: row of the first axis.
Vec3 restrict_to(RowSet rows, int shift, const Mat3& axes, const Vec3& components) {
  Vec3 sum{0, 0, 0};
  if (has_row(rows, shift)) sum += components.x * axes.x;
  if (has_row(rows, shift + 1)) sum += components.y * axes.y;
  if (has_row(rows, shift + 2)) sum += components.z * axes.z;
  return sum;
}

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
  const JointFrame& f = ws.frames[at(joint)];
  const RowSet rotation = get_active_rows(plan, state, joint) & kRotationRows;
  const Quat& locked = state.joints[at(joint)].locked;
  if (rotation == kRotationRows) {
    const Quat error = calc_relative_attitude(plan, state, joint) * conjugate(locked);
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

void update_acceleration_bias(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (std::size_t j = 0; j < plan.joints.size(); ++j) {
    const PlanJoint& joint = plan.joints[j];
    const JointFrame& f = ws.frames[j];
    const Vec3 w_base = get_body_frame(state, ws, joint.base).w;
    const Vec3 w_follower = get_body_frame(state, ws, joint.follower).w;
    ws.bias[j].lin = (cross(w_base, cross(w_base, f.r_base)) + 2.0 * cross(w_base, f.v_rel)) -
                     cross(w_follower, cross(w_follower, f.r_follower));
    ws.bias[j].ang = f.crossed
                         ? calc_crossed_bias(f, calc_follower_axes(plan, ws, static_cast<int>(j)).y, w_base, w_follower)
                         : cross(w_base, w_follower);
  }
}

void update_velocity_bias(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const RowSet rows = get_active_rows(plan, state, j);
    const JointFrame& f = ws.frames[at(j)];
    ws.bias[at(j)].lin = -restrict_to(rows, kX, f.n, transpose_times(f.n, f.v_rel));
    ws.bias[at(j)].ang = -restrict_to(rows, kRotX, f.m, transpose_times(f.m, f.w_rel));
  }
}

void update_position_bias(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const RowSet rows = get_active_rows(plan, state, j);
    const JointFrame& f = ws.frames[at(j)];
    const Vec3 angles = calc_orientation_gap(plan, state, ws, j);
    ws.bias[at(j)].lin = -restrict_to(rows, kX, f.n, f.displacement - state.joints[at(j)].offset);
    ws.bias[at(j)].ang = -restrict_to(rows, kRotX, f.m, angles);
  }
}

double calc_drift(const Plan& plan, const State& state, const Workspace& ws) noexcept {
  double drift = 0;
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const RowSet rows = get_active_rows(plan, state, j);
    const JointFrame& f = ws.frames[at(j)];
    const Vec3 angles = calc_orientation_gap(plan, state, ws, j);
    const Vec3 gap = f.displacement - state.joints[at(j)].offset;
    const double gaps[kRows] = {gap.x, gap.y, gap.z, angles.x, angles.y, angles.z};
    for (int r = 0; r < kRows; ++r)
      if (has_row(rows, r)) drift = std::max(drift, std::abs(gaps[r]));
  }
  return drift;
}

}  // namespace unlatch
