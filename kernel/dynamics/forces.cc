#include "kernel/dynamics/forces.h"

#include <algorithm>
#include <cmath>

#include "kernel/dynamics/compliance.h"
#include "kernel/dynamics/contacts.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/loads.h"
#include "kernel/dynamics/varying.h"
#include "kernel/joints/kinematics.h"
#include "unlatch/elementary.h"
#include "unlatch/springs.h"

namespace unlatch {
namespace {

// A force at an arm from the body's origin, or a torque; nothing can push the ground.
void push(Evaluation& ev, int body, const Vec3& force, const Vec3& torque) {
  if (body != kGround) add(ev.blocks.data(), ev.places[at(body)], &SharedLane::force, {force, torque});
}

// Consumption of propellant, and loads that keep their direction in the world; init_forces() has the others.
void add_loads(const PlanData& plan, Evaluation& ev) {
  for (const std::int32_t i : plan.external_loads) {
    const PlanLoad& load = plan.loads[at(i)];
    const double size = ev.load_sizes[at(i)];
    if (load.consumption != 0) ev.auxiliary.rate[at(load.varying)] += load.consumption * std::abs(size) * load.length;
    if (!load.world || size == 0) continue;
    const Mat3 R = read(ev.blocks.data(), ev.places[at(load.body)], &BodyLane::R);
    const Vec3 force = size * load.wrench.lin;
    push(ev, load.body, force, cross(R * load.point, force) + size * load.wrench.ang);
  }
}

// A point spring between two bodies: arms of its ends from the bodies' origins, length, direction and size of its force
// on the follower. World axes.
struct PointSpringForce {
  Vec3 r_base, r_follower, direction;
  double length, size;
  bool acts;
};

PointSpringForce calc_force(const PlanPointSpring& spring, const BodyFrame& base, const BodyFrame& follower,
                            double scale) {
  PointSpringForce f{base.R * spring.point_base, follower.R * spring.point_follower, {0, 0, 0}, 0, 0, false};
  const Vec3 line = (follower.p + f.r_follower) - (base.p + f.r_base);
  f.length = norm(line);
  if (f.length == 0 || (spring.push_only && f.length >= spring.free_length)) return f;
  f.direction = (1.0 / f.length) * line;
  const double rate =
      dot(f.direction, (follower.v + cross(follower.w, f.r_follower)) - (base.v + cross(base.w, f.r_base)));
  f.size = -(spring.stiffness * (f.length - spring.free_length) + spring.damping * rate) * scale;
  if (spring.push_only && f.size < 0) f.size = 0;
  f.acts = true;
  return f;
}

void add_point_springs(const Instant& now, Evaluation& ev) {
  const PlanData& plan = now.plan;
  for (const PlanPointSpring& spring : plan.point_springs) {
    const double scale = calc_scale(now.state.elements[at(spring.element)], now.t);
    if (scale == 0) continue;
    const PointSpringForce f =
        calc_force(spring, get_body_frame(ev, spring.base), get_body_frame(ev, spring.follower), scale);
    if (!f.acts) continue;
    const Vec3 force = f.size * f.direction;
    push(ev, spring.follower, force, cross(f.r_follower, force));
    push(ev, spring.base, -force, -cross(f.r_base, force));
  }
}

// From a state alone: its angular velocities are in body axes.
BodyFrame get_body_frame(const State& state, std::int32_t body) {
  if (body == kGround) return get_ground<double>();
  const BodyState& own = state.bodies[at(body)];
  const Mat3 R = rotation_matrix(own.q);
  return {R, own.p, own.v, R * own.w};
}

void add_joint_springs(const Instant& now, Evaluation& ev) {
  const PlanData& plan = now.plan;
  for (const PlanJointSpring& spring : plan.joint_springs) {
    const double scale = calc_scale(now.state.elements[at(spring.element)], now.t);
    if (scale == 0) continue;
    const std::size_t coordinate = at(spring.coordinate);
    double x = ev.coordinates[coordinate], rate = ev.speeds[coordinate], lead = 0;
    if (spring.compliant != kNone) lead = calc_lead(ev.compliant[at(spring.compliant)], now.implicit, x, rate);
    const double size = (spring.effort - spring.stiffness * (x - spring.rest) - spring.damping * rate) * scale + lead;
    const JointView joint(plan, ev, spring.joint);
    const std::int32_t base = joint.get_plan().base, follower = joint.get_plan().follower;
    const Vec3 vector = size * joint.get_axis(spring.axis);
    if (spring.axis < kRotX) {
      push(ev, follower, vector, cross(joint.get_arm(true), vector));
      push(ev, base, -vector, -cross(joint.get_arm(false), vector));
    } else {
      push(ev, follower, {0, 0, 0}, vector);
      push(ev, base, {0, 0, 0}, -vector);
    }
  }
}

// (4.17) with φ = atan2(n_i·n_j, |n_i × n_j|), positive where n_j stands out of the plane along n_i. A turn of the
// follower about e = n_i × n_j / |n_i × n_j| carries n_j away from n_i, dφ/dt = −e·w_rel, so the restoring moment is
// +kφ along e.
void add_plane_torsions(const Instant& now, Evaluation& ev) {
  const PlanData& plan = now.plan;
  for (const PlanPlaneTorsion& spring : plan.plane_torsions) {
    const double scale = calc_scale(now.state.elements[at(spring.element)], now.t);
    if (scale == 0) continue;
    const BodyFrame base = get_body_frame(ev, spring.base);
    const BodyFrame follower = get_body_frame(ev, spring.follower);
    const Vec3 normal = base.R * spring.normal_base, axis = follower.R * spring.axis_follower;
    const Vec3 across = cross(normal, axis);
    const double size = norm(across);
    if (size == 0) continue;  // the axis stands on the plane: no direction is nearer to it than another
    const Vec3 e = (1.0 / size) * across;
    const double phi = elementary::atan2(dot(normal, axis), size);
    const double phi_rate = -dot(e, follower.w - base.w);
    const Vec3 torque = ((spring.stiffness * phi + spring.damping * phi_rate) * scale) * e;
    push(ev, spring.follower, {0, 0, 0}, torque);
    push(ev, spring.base, {0, 0, 0}, -torque);
  }
}

}  // namespace

SpringReading calc_point_spring(const Plan& plan, const State& state, int spring) noexcept {
  const PlanPointSpring& own = plan.data().point_springs[at(spring)];
  const double t = static_cast<double>(state.header->tick) * plan.get_options().dt;
  const double scale = calc_scale(state.elements[at(own.element)], t);
  const PointSpringForce f =
      calc_force(own, get_body_frame(state, own.base), get_body_frame(state, own.follower), scale);
  return {f.length, scale == 0 ? 0 : f.size, scale};
}

void add_forces(const Instant& now, Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  std::fill(ev.auxiliary.rate.begin(), ev.auxiliary.rate.end(), 0.0);
  add_loads(plan, ev);
  add_point_springs(now, ev);
  add_joint_springs(now, ev);
  add_plane_torsions(now, ev);
  if (!plan.contacts.empty()) add_contacts(now, ev);
  if (plan.rigid) return;
  add_varying_forces(plan, ev);
  add_flexible_forces(plan, now.implicit, ev);
}

}  // namespace unlatch
