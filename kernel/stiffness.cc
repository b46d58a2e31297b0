#include "kernel/stiffness.h"

#include "kernel/kinematics.h"
#include "kernel/lane_access.h"
#include "kernel/lane_state.h"
#include "kernel/loops.h"
#include "kernel/tree_solver.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// What an element with unit effort does: equal and opposite on two bodies.
struct Effort {
  int base, follower;
  Spatial on_base, on_follower;
};

Effort push_apart(const BodyFrame& base, const BodyFrame& follower, int b, int f, const Vec3& r_base,
                  const Vec3& r_follower) {
  const Vec3 line = (follower.p + r_follower) - (base.p + r_base);
  const double length = norm(line);
  const Vec3 e = length > 0 ? (1.0 / length) * line : Vec3{1, 0, 0};
  return {b, f, {-e, -cross(r_base, e)}, {e, cross(r_follower, e)}};
}

Effort turn_apart(int base, int follower, const Vec3& axis) {
  return {base, follower, {{0, 0, 0}, -axis}, {{0, 0, 0}, axis}};
}

// Acceleration along the element that its unit effort brings about: 1 / effective mass.
double calc_mobility(const Plan& plan, const Effort& effort, Workspace& ws) {
  double* lanes = ws.lanes.data();
  for (const LaneSlot slot : plan.body_slots) write_spatial(lanes, slot, kForce, {{0, 0, 0}, {0, 0, 0}});
  if (effort.base != kGround) write_spatial(lanes, ws.slots[at(effort.base)], kForce, effort.on_base);
  write_spatial(lanes, ws.slots[at(effort.follower)], kForce, effort.on_follower);
  solve(plan, ws, {Source::kForces, false, false});
  double sum = dot(effort.on_follower, ws.accelerations[at(effort.follower)]);
  if (effort.base != kGround) sum += dot(effort.on_base, ws.accelerations[at(effort.base)]);
  return sum > 0 ? sum : 0;
}

Effort calc_effort(const Workspace& ws, const PlanPointSpring& s) {
  const BodyFrame base = get_body_frame(ws, s.base), follower = get_body_frame(ws, s.follower);
  return push_apart(base, follower, s.base, s.follower, base.R * s.point_base, follower.R * s.point_follower);
}

Effort calc_effort(const Plan& plan, const State& state, const Workspace& ws, const PlanJointSpring& s) {
  const PlanJoint& joint = plan.joints[at(s.joint)];
  const JointFrame f = get_joint_frame(plan, state, ws, s.joint);
  if (s.axis >= kRotX) return turn_apart(joint.base, joint.follower, column(f.m, s.axis - kRotX));
  const Vec3& n = column(f.n, s.axis);
  return {joint.base, joint.follower, {-n, -cross(f.r_base, n)}, {n, cross(f.r_follower, n)}};
}

Effort calc_effort(const Workspace& ws, const PlanPlaneTorsion& s) {
  const Vec3 across =
      cross(get_body_frame(ws, s.base).R * s.normal_base, get_body_frame(ws, s.follower).R * s.axis_follower);
  const double size = norm(across);
  return turn_apart(s.base, s.follower, size > 0 ? (1.0 / size) * across : Vec3{1, 0, 0});
}

}  // namespace

std::vector<ElementFrequency> calc_frequencies(const Plan& plan, const State& state, Workspace& ws) {
  std::vector<ElementFrequency> out;
  load_state(plan, state, ws);
  update_kinematics(plan, ws);
  update_joints(plan, state, BiasKind::kAcceleration, ws);
  ws.loop_most = kAllRows;
  if (factor_and_solve(plan, state, ws, {Source::kNothing, false, false}) != kNone) return out;
  const auto add = [&](int element, double stiffness, double damping, const Effort& effort) {
    const double mobility = calc_mobility(plan, effort, ws);
    out.push_back({element, std::sqrt(stiffness * mobility), damping * mobility});
  };
  for (const PlanPointSpring& s : plan.point_springs) add(s.element, s.stiffness, s.damping, calc_effort(ws, s));
  for (const PlanJointSpring& s : plan.joint_springs)
    add(s.element, s.stiffness, s.damping, calc_effort(plan, state, ws, s));
  for (const PlanPlaneTorsion& s : plan.plane_torsions) add(s.element, s.stiffness, s.damping, calc_effort(ws, s));
  return out;
}

}  // namespace unlatch
