#include "kernel/dynamics/forces.h"

#include <algorithm>
#include <cmath>

#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/varying.h"
#include "kernel/elements/compliance.h"
#include "kernel/elements/contacts.h"
#include "kernel/elements/friction.h"
#include "kernel/elements/loads.h"
#include "kernel/elements/one_sided.h"
#include "kernel/elements/push.h"
#include "kernel/elements/springs.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

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

void add_point_springs(const Instant& now, Evaluation& ev) {
  const PlanData& plan = now.plan;
  for (const PlanPointSpring& spring : plan.point_springs) {
    const double scale = calc_scale(now.state.elements[at(spring.element)], now.t);
    if (scale == 0) continue;
    const PointSpringForce f =
        calc_force(spring, get_body_frame(ev, spring.base), get_body_frame(ev, spring.follower), scale);
    if (f.acts) push_apart(ev, spring.base, spring.follower, f.r_base, f.r_follower, f.size * f.direction);
  }
}

void add_joint_springs(const Instant& now, Evaluation& ev) {
  const PlanData& plan = now.plan;
  for (const PlanJointSpring& spring : plan.joint_springs) {
    const double scale = calc_scale(now.state.elements[at(spring.element)], now.t);
    if (scale == 0) continue;
    const std::size_t coordinate = at(spring.coordinate);
    double x = ev.coordinates[coordinate], rate = ev.speeds[coordinate], lead = 0;
    if (spring.compliant != kNone) lead = calc_lead(ev.compliant[at(spring.compliant)], now.implicit, x, rate);
    const double size = calc_joint_spring(spring, x, rate, scale) + lead;
    push_apart(ev, JointView(plan, ev, spring.joint), spring.axis, size);
  }
}

void add_plane_torsions(const Instant& now, Evaluation& ev) {
  const PlanData& plan = now.plan;
  for (const PlanPlaneTorsion& spring : plan.plane_torsions) {
    const double scale = calc_scale(now.state.elements[at(spring.element)], now.t);
    if (scale == 0) continue;
    const PlaneTorsionForce f =
        calc_force(spring, get_body_frame(ev, spring.base), get_body_frame(ev, spring.follower), scale);
    if (f.acts) turn_apart(ev, spring.base, spring.follower, f.size * f.axis);
  }
}

// Between two bodies.
void add_pair_forces(const Instant& now, Evaluation& ev) {
  add_point_springs(now, ev);
  add_joint_springs(now, ev);
  add_plane_torsions(now, ev);
  add_contacts(now, ev);
  add_one_sided_forces(now, ev);
  add_friction_forces(now.plan, ev);
}

}  // namespace

void add_forces(const Instant& now, Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  std::fill(ev.auxiliary.rate.begin(), ev.auxiliary.rate.end(), 0.0);
  add_loads(plan, ev);
  if (plan.pair_forces) add_pair_forces(now, ev);
  if (plan.rigid) return;
  add_varying_forces(plan, ev);
  add_flexible_forces(plan, now.implicit, ev);
}

}  // namespace unlatch
