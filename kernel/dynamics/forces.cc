#include "kernel/dynamics/forces.h"

#include <algorithm>

#include "kernel/dynamics/compliance.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/kinematics.h"
#include "kernel/dynamics/loads.h"
#include "kernel/dynamics/varying.h"
#include "kernel/plan/lane_access.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A force at an arm from the body's origin, or a torque; nothing can push the ground.
void push(Workspace& ws, int body, const Vec3& force, const Vec3& torque) {
  if (body == kGround) return;
  const LaneSlot slot = ws.slots[at(body)];
  add_vec(ws.lanes.data(), slot, kForce, force);
  add_vec(ws.lanes.data(), slot, kForce + 3, torque);
}

// What burns propellant, and loads that keep their direction in the world; the others are in the lanes.
void add_loads(const Plan& plan, Workspace& ws) {
  for (const std::int32_t i : plan.busy_loads) {
    const PlanLoad& load = plan.loads[at(i)];
    const double size = ws.load_sizes[at(i)];
    if (load.consumption != 0) ws.extras.rate[at(load.varying)] += load.consumption * std::abs(size) * load.length;
    if (!load.world || size == 0) continue;
    const Mat3 R = read_mat(ws.lanes.data(), ws.slots[at(load.body)], kRotation);
    const Vec3 force = size * load.wrench.lin;
    push(ws, load.body, force, cross(R * load.point, force) + size * load.wrench.ang);
  }
}

void add_point_springs(const Plan& plan, const State& state, double t, Workspace& ws) {
  for (const PlanPointSpring& spring : plan.point_springs) {
    const double scale = calc_scale(state.elements[at(spring.element)], t);
    if (scale == 0) continue;
    const BodyFrame base = get_body_frame(ws, spring.base);
    const BodyFrame follower = get_body_frame(ws, spring.follower);
    const Vec3 r_base = base.R * spring.point_base, r_follower = follower.R * spring.point_follower;
    const Vec3 line = (follower.p + r_follower) - (base.p + r_base);
    const double length = norm(line);
    if (length == 0 || (spring.push_only && length >= spring.free_length)) continue;
    const Vec3 direction = (1.0 / length) * line;
    const double rate = dot(direction, (follower.v + cross(follower.w, r_follower)) - (base.v + cross(base.w, r_base)));
    double size = -(spring.stiffness * (length - spring.free_length) + spring.damping * rate) * scale;
    if (spring.push_only && size < 0) size = 0;
    const Vec3 force = size * direction;
    push(ws, spring.follower, force, cross(r_follower, force));
    push(ws, spring.base, -force, -cross(r_base, force));
  }
}

void add_joint_springs(const Plan& plan, const State& state, double t, Workspace& ws) {
  for (const PlanJointSpring& spring : plan.joint_springs) {
    const double scale = calc_scale(state.elements[at(spring.element)], t);
    if (scale == 0) continue;
    const std::size_t coordinate = at(spring.coordinate);
    double x = ws.coordinates[coordinate], rate = ws.speeds[coordinate], lead = 0;
    if (spring.compliant != kNone) lead = calc_lead(ws.compliant[at(spring.compliant)], ws.implicit, x, rate);
    const double size = (spring.effort - spring.stiffness * (x - spring.rest) - spring.damping * rate) * scale + lead;
    const PlanJoint& joint = plan.joints[at(spring.joint)];
    const Vec3 vector = size * get_axis(plan, ws, spring.joint, spring.axis);
    if (spring.axis < kRotX) {
      push(ws, joint.follower, vector, cross(get_arm(plan, ws, spring.joint, true), vector));
      push(ws, joint.base, -vector, -cross(get_arm(plan, ws, spring.joint, false), vector));
    } else {
      push(ws, joint.follower, {0, 0, 0}, vector);
      push(ws, joint.base, {0, 0, 0}, -vector);
    }
  }
}

// (4.17) with φ = atan2(n_i·n_j, |n_i × n_j|), positive where n_j stands out of the plane along n_i. A turn of the
// follower about e = n_i × n_j / |n_i × n_j| carries n_j away from n_i, dφ/dt = −e·w_rel, so the restoring moment is
// +kφ along e.
void add_plane_torsions(const Plan& plan, const State& state, double t, Workspace& ws) {
  for (const PlanPlaneTorsion& spring : plan.plane_torsions) {
    const double scale = calc_scale(state.elements[at(spring.element)], t);
    if (scale == 0) continue;
    const BodyFrame base = get_body_frame(ws, spring.base);
    const BodyFrame follower = get_body_frame(ws, spring.follower);
    const Vec3 normal = base.R * spring.normal_base, axis = follower.R * spring.axis_follower;
    const Vec3 across = cross(normal, axis);
    const double size = norm(across);
    if (size == 0) continue;  // the axis stands on the plane: no direction is nearer to it than another
    const Vec3 e = (1.0 / size) * across;
    const double phi = elementary::atan2(dot(normal, axis), size);
    const double phi_rate = -dot(e, follower.w - base.w);
    const Vec3 torque = ((spring.stiffness * phi + spring.damping * phi_rate) * scale) * e;
    push(ws, spring.follower, {0, 0, 0}, torque);
    push(ws, spring.base, {0, 0, 0}, -torque);
  }
}

}  // namespace

Vec3 calc_gravity(const Plan& plan, const Vec3& p) noexcept {
  if (plan.mu == 0) return plan.gravity;
  const Vec3 r = p - plan.mu_centre;
  const double r2 = dot(r, r);
  return plan.gravity - (plan.mu / (r2 * std::sqrt(r2))) * r;
}

void add_forces(const Plan& plan, const State& state, double t, Workspace& ws) noexcept {
  std::fill(ws.extras.rate.begin(), ws.extras.rate.end(), 0.0);
  if (!plan.busy_loads.empty()) add_loads(plan, ws);
  if (!plan.point_springs.empty()) add_point_springs(plan, state, t, ws);
  if (!plan.joint_springs.empty()) add_joint_springs(plan, state, t, ws);
  if (!plan.plane_torsions.empty()) add_plane_torsions(plan, state, t, ws);
  if (plan.rigid) return;
  add_varying_forces(plan, ws);
  add_flexible_forces(plan, ws);
}

}  // namespace unlatch
