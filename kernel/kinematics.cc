#include "kernel/kinematics.h"

#include "kernel/elementary.h"

namespace unlatch {
namespace {

constexpr double kTwoPi = 6.283185307179586;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The value of `angle` + 2πk nearest to `previous`.
double unwind(double angle, double previous) { return angle - kTwoPi * std::nearbyint((angle - previous) / kTwoPi); }

// In its modes with rot_z as the only rotation row a universal joint's rotation frame follows the cross: x of the base,
// y of the follower, and their common normal, which the row is about.
Mat3 universal_frame(const Mat3& base, const Mat3& follower) {
  const Vec3 normal = cross(base.x, follower.y);
  const Vec3 z = (1.0 / norm(normal)) * normal;
  return {base.x, cross(z, base.x), z};
}

}  // namespace

double calc_twist(const Mat3& base, const Mat3& follower, int k) noexcept {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  const Vec3 &bi = column(base, i), &bj = column(base, j), &fi = column(follower, i), &fj = column(follower, j);
  return elementary::atan2(dot(bj, fi) - dot(bi, fj), dot(bi, fi) + dot(bj, fj));
}

Quat calc_relative_attitude(const Plan& plan, const State& state, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  const Quat base = j.base == kGround ? j.quat_base : state.bodies[at(j.base)].q * j.quat_base;
  return conjugate(base) * (state.bodies[at(j.follower)].q * j.quat_follower);
}

BodyFrame get_body_frame(const State& state, const Workspace& ws, int body) noexcept {
  if (body == kGround) return {kIdentity3, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const BodyState& s = state.bodies[at(body)];
  const BodyKinematics& k = ws.kinematics[at(body)];
  return {k.R, s.p, s.v, k.w};
}

void update_kinematics(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    BodyKinematics& k = ws.kinematics[b];
    k.R = rotation_matrix(state.bodies[b].q);
    k.w = k.R * state.bodies[b].w;
    k.J = rotate(k.R, plan.bodies[b].inertia);
  }
}

void update_joint_frames(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const PlanJoint& joint = plan.joints[at(j)];
    const BodyFrame base = get_body_frame(state, ws, joint.base);
    const BodyFrame follower = get_body_frame(state, ws, joint.follower);
    JointFrame& f = ws.frames[at(j)];

    f.r_follower = follower.R * joint.point_follower;
    const Vec3 separation = follower.p - base.p;
    f.r_base = separation + f.r_follower;
    f.n = base.R * joint.axes;
    f.w_rel = follower.w - base.w;
    f.v_rel = (follower.v + cross(follower.w, f.r_follower)) - (base.v + cross(base.w, f.r_base));

    const Vec3 displacement = transpose_times(f.n, f.r_base - base.R * joint.point_base);
    f.gap = displacement - state.joints[at(j)].offset;

    const RowSet rows = get_active_rows(plan, state, j);
    const Mat3 rotation_follower = follower.R * joint.rotation_follower;
    f.m = base.R * joint.rotation_base;
    f.follower_axes = rotation_follower;
    f.crossed = joint.universal && (rows & kRotationRows) == row_bit(kRotZ);

    double* coordinates = &ws.coordinates[at(j) * kRows];
    double* speeds = &ws.speeds[at(j) * kRows];
    coordinates[kX] = displacement.x;
    coordinates[kY] = displacement.y;
    coordinates[kZ] = displacement.z;
    for (int k = 0; k < 3; ++k) {
      const bool read = (joint.angles >> k & 1) != 0;
      const double previous = state.joints[at(j)].angle[k];
      coordinates[kRotX + k] = read ? unwind(calc_twist(f.m, rotation_follower, k), previous) : 0;
    }
    if (f.crossed) f.m = universal_frame(f.m, rotation_follower);
    for (int k = 0; k < 3; ++k) {
      speeds[kX + k] = dot(column(f.n, k), f.v_rel);
      speeds[kRotX + k] = dot(column(f.m, k), f.w_rel);
    }
  }
}

}  // namespace unlatch
