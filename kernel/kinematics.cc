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

void update_kinematics(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    BodyKinematics& k = ws.kinematics[b];
    k.R = rotation_matrix(state.bodies[b].q);
    k.w = k.R * state.bodies[b].w;
    k.J = rotate(k.R, plan.bodies[b].inertia);
  }
}

Mat3 calc_follower_axes(const Plan& plan, const Workspace& ws, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  return ws.kinematics[at(j.follower)].R * j.rotation_follower;
}

void update_joint_frames(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const PlanJoint& joint = plan.joints[at(j)];
    const BodyFrame base = get_body_frame(state, ws, joint.base);
    const BodyFrame follower = get_body_frame(state, ws, joint.follower);
    JointFrame& f = ws.frames[at(j)];
    f.r_follower = follower.R * joint.point_follower;
    f.r_base = (follower.p - base.p) + f.r_follower;
    f.n = base.R * joint.axes;
    f.m = joint.shared_axes ? f.n : base.R * joint.rotation_base;
    f.w_rel = follower.w - base.w;
    f.v_rel = (follower.v + cross(follower.w, f.r_follower)) - (base.v + cross(base.w, f.r_base));
    f.displacement = transpose_times(f.n, f.r_base - base.R * joint.point_base);
    f.crossed = joint.universal && (get_active_rows(plan, state, j) & kRotationRows) == row_bit(kRotZ);
    if (f.crossed) f.m = universal_frame(f.m, calc_follower_axes(plan, ws, j));
  }
}

void update_coordinates(const Plan& plan, const State& state, Workspace& ws) noexcept {
  for (int j = 0; j < static_cast<int>(plan.joints.size()); ++j) {
    const PlanJoint& joint = plan.joints[at(j)];
    if (!joint.measured) continue;
    const JointFrame& f = ws.frames[at(j)];
    double* coordinates = &ws.coordinates[at(j) * kRows];
    double* speeds = &ws.speeds[at(j) * kRows];
    coordinates[kX] = f.displacement.x;
    coordinates[kY] = f.displacement.y;
    coordinates[kZ] = f.displacement.z;
    for (int k = 0; k < 3; ++k) {
      speeds[kX + k] = dot(column(f.n, k), f.v_rel);
      speeds[kRotX + k] = dot(column(f.m, k), f.w_rel);
      coordinates[kRotX + k] = 0;
    }
    if (joint.angles == 0) continue;
    const Mat3 base = get_body_frame(state, ws, joint.base).R * joint.rotation_base;
    const Mat3 follower = calc_follower_axes(plan, ws, j);
    for (int k = 0; k < 3; ++k)
      if ((joint.angles >> k & 1) != 0)
        coordinates[kRotX + k] = unwind(calc_twist(base, follower, k), state.joints[at(j)].angle[k]);
  }
}

}  // namespace unlatch
