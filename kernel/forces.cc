#include "kernel/forces.h"

#include <algorithm>
#include <limits>

#include "kernel/compliance.h"
#include "kernel/elementary.h"
#include "kernel/flexible.h"
#include "kernel/kinematics.h"
#include "kernel/lane_access.h"
#include "kernel/step.h"
#include "kernel/varying.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double calc_table(std::span<const Knot> knots, double s) {
  if (s <= knots.front().time) return knots.front().value;
  if (s >= knots.back().time) return knots.back().value;
  std::size_t low = 0, high = knots.size() - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (knots[middle].time <= s ? low : high) = middle;
  }
  const Knot &a = knots[low], &b = knots[high];
  return a.value + (b.value - a.value) * ((s - a.time) / (b.time - a.time));
}

// A force at an arm from the body's origin, or a torque; nothing can push the ground.
void push(Workspace& ws, int body, const Vec3& force, const Vec3& torque) {
  if (body == kGround) return;
  const LaneSlot slot = ws.slots[at(body)];
  add_vec(ws.lanes.data(), slot, kForce, force);
  add_vec(ws.lanes.data(), slot, kForce + 3, torque);
}

// The value of a load's law s seconds after it began. Two stages of a step are at one time, and loads with one law and
// one beginning follow each other: what was computed last, for this load and for the one before, is kept.
double find_profile(const Plan& plan, std::size_t load, double s, Workspace& ws) {
  KeptProfile& kept = ws.profiles[load];
  if (kept.s == s) return kept.value;
  const std::int32_t profile = plan.loads[load].profile;
  const bool shared = load > 0 && plan.loads[load - 1].profile == profile && ws.profiles[load - 1].s == s;
  kept = {s, shared ? ws.profiles[load - 1].value : calc_profile(plan, plan.profiles[at(profile)], s)};
  return kept.value;
}

void add_loads(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) {
  for (std::size_t i = 0; i < plan.loads.size(); ++i) {
    const PlanLoad& load = plan.loads[i];
    const ElementState& element = state.elements[at(load.element)];
    const double scale = calc_scale(element, t);
    if (scale == 0) continue;
    const double command = load.channel == kNone ? 1.0 : inputs.commands[at(load.channel)];
    const double size = find_profile(plan, i, t - element.switched_on, ws) * scale * command;
    if (load.consumption != 0) ws.extras.rate[at(load.varying)] += load.consumption * std::abs(size) * load.length;
    const Mat3 R = read_mat(ws.lanes.data(), ws.slots[at(load.body)], kRotation);
    const Vec3 vector = size * (load.world ? load.direction : R * load.direction);
    if (load.torque)
      push(ws, load.body, {0, 0, 0}, vector);
    else
      push(ws, load.body, vector, cross(R * load.point, vector));
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
    const std::size_t coordinate = at(spring.joint) * kRows + at(spring.axis);
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

double calc_profile(const Plan& plan, const PlanProfile& profile, double s) noexcept {
  switch (profile.kind) {
    case Profile::Kind::kConstant:
      return profile.value;
    case Profile::Kind::kExponential:
      return profile.final + (profile.initial - profile.final) * elementary::exp(-s / profile.tau);
    case Profile::Kind::kTable:
      return calc_table(std::span(plan.knots).subspan(at(profile.first), at(profile.count)), s);
    case Profile::Kind::kHarmonic: {
      double sum = 0;
      for (const Profile::Harmonic& h : std::span(plan.harmonics).subspan(at(profile.first), at(profile.count)))
        sum += h.amplitude * elementary::sin(h.frequency * s + h.phase);
      return sum;
    }
  }
  return 0;
}

double calc_scale(const ElementState& element, double t) noexcept {
  const double elapsed = t - element.start;
  if (!(elapsed < element.duration)) return element.to;
  return element.from + (element.to - element.from) * (elapsed / element.duration);
}

Vec3 calc_gravity(const Plan& plan, const Vec3& p) noexcept {
  if (plan.mu == 0) return plan.gravity;
  const Vec3 r = p - plan.mu_centre;
  const double r2 = dot(r, r);
  return plan.gravity - (plan.mu / (r2 * std::sqrt(r2))) * r;
}

void forget_profiles(Workspace& ws) noexcept {
  for (KeptProfile& kept : ws.profiles) kept.s = std::numeric_limits<double>::quiet_NaN();  // equal to none
}

void update_forces(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  plan.kernels->init_forces(plan, ws);
  std::fill(ws.extras.rate.begin(), ws.extras.rate.end(), 0.0);
  add_loads(plan, inputs, state, t, ws);
  add_point_springs(plan, state, t, ws);
  add_joint_springs(plan, state, t, ws);
  add_plane_torsions(plan, state, t, ws);
  add_varying_forces(plan, ws);
  add_flexible_forces(plan, ws);
}

}  // namespace unlatch
