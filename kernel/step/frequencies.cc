#include "unlatch/frequencies.h"

#include <cmath>

#include "kernel/dispatch/kernels.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/elements/one_sided.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/load_state.h"
#include "kernel/joints/kinematics.h"
#include "kernel/solver/loop_rows.h"

namespace unlatch {
namespace {

// The wrenches of an element with unit effort: equal and opposite on two bodies.
struct Effort {
  int base, follower;
  Spatial on_base, on_follower;
};

Effort calc_push(const BodyFrame& base, const BodyFrame& follower, int b, int f, const Vec3& r_base,
                 const Vec3& r_follower) {
  const Vec3 line = (follower.p + r_follower) - (base.p + r_base);
  const double length = norm(line);
  const Vec3 e = length > 0 ? (1.0 / length) * line : Vec3{1, 0, 0};
  return {b, f, {-e, -cross(r_base, e)}, {e, cross(r_follower, e)}};
}

Effort calc_turn(int base, int follower, const Vec3& axis) {
  return {base, follower, {{0, 0, 0}, -axis}, {{0, 0, 0}, axis}};
}

// Acceleration along the element that its unit effort brings about: 1 / effective mass.
double calc_mobility(const PlanData& plan, const Effort& effort, Evaluation& ev) {
  double* blocks = ev.blocks.data();
  for (const Place& place : plan.places) write(blocks, place, &SharedLane::force, {{0, 0, 0}, {0, 0, 0}});
  if (effort.base != kGround) write(blocks, ev.places[at(effort.base)], &SharedLane::force, effort.on_base);
  write(blocks, ev.places[at(effort.follower)], &SharedLane::force, effort.on_follower);
  get_kernels(plan).solve(plan, ev, {.biased = false, .multipliers = false});
  double sum = dot(effort.on_follower, ev.get_acceleration(effort.follower));
  if (effort.base != kGround) sum += dot(effort.on_base, ev.get_acceleration(effort.base));
  return sum > 0 ? sum : 0;
}

Effort calc_effort(const Evaluation& ev, const PlanPointSpring& s) {
  const BodyFrame base = get_body_frame(ev, s.base), follower = get_body_frame(ev, s.follower);
  return calc_push(base, follower, s.base, s.follower, base.R * s.point_base, follower.R * s.point_follower);
}

// Unit effort of a spring or of friction in a joint, along or about its axis; world axes, at the bodies' origins.
template <class InJoint>
Effort calc_joint_effort(const PlanData& plan, const State& state, const Evaluation& ev, const InJoint& s) {
  const PlanJoint& joint = plan.joints[at(s.joint)];
  const JointFrame f = get_joint_frame(plan, state, ev, s.joint);
  if (s.axis >= kRotX) return calc_turn(joint.base, joint.follower, column(f.m, s.axis - kRotX));
  const Vec3& n = column(f.n, s.axis);
  return {joint.base, joint.follower, {-n, -cross(f.r_base, n)}, {n, cross(f.r_follower, n)}};
}

Effort calc_effort(const PlanData& plan, const State& state, const Evaluation& ev, const PlanOneSided& s) {
  const OneSidedMotion m = calc_motion(plan, state, ev, s);
  const Vec3 e = norm(m.direction) > 0 ? m.direction : Vec3{1, 0, 0};
  if (s.joint != kNone && s.axis >= kRotX) return calc_turn(s.base, s.follower, e);
  return {s.base, s.follower, {-e, -cross(m.r_base, e)}, {e, cross(m.r_follower, e)}};
}

Effort calc_effort(const Evaluation& ev, const PlanPlaneTorsion& s) {
  const Vec3 across =
      cross(get_body_frame(ev, s.base).R * s.normal_base, get_body_frame(ev, s.follower).R * s.axis_follower);
  const double size = norm(across);
  return calc_turn(s.base, s.follower, size > 0 ? (1.0 / size) * across : Vec3{1, 0, 0});
}

// An evaluation of `state` that mobilities can be computed with; null if a pivot vanishes.
Evaluation* factor(const PlanData& plan, const State& state, Workspace& workspace) {
  FinalEvaluation& kept = workspace.data().kept;
  kept.valid = false;
  Evaluation& ev = kept.evaluation;
  load_state(plan, state, ev);
  update_kinematics(plan, ev);
  update_joints(plan, state, RowTarget::kVelocity, ev);
  const Sweep nothing{.source = Source::kNothing, .biased = false, .multipliers = false};
  if (get_kernels(plan).factor_and_solve(plan, state, ev, nothing, kAllRows) != kNone) return nullptr;
  clear_modal_forces(plan, ev);
  return &ev;
}

}  // namespace

std::vector<ElementFrequency> calc_frequencies(const Plan& owner, const State& state, Workspace& workspace) {
  const PlanData& plan = owner.data();
  std::vector<ElementFrequency> out;
  Evaluation* const factored = factor(plan, state, workspace);
  if (factored == nullptr) return out;
  Evaluation& ev = *factored;
  const auto add = [&](int element, double stiffness, double damping, const Effort& effort, bool implicit = false) {
    const double mobility = calc_mobility(plan, effort, ev);
    out.push_back({element, std::sqrt(stiffness * mobility), damping * mobility, implicit});
  };
  for (const PlanPointSpring& s : plan.point_springs) add(s.element, s.stiffness, s.damping, calc_effort(ev, s));
  for (const PlanJointSpring& s : plan.joint_springs)
    add(s.element, s.stiffness, s.damping, calc_joint_effort(plan, state, ev, s), s.compliant != kNone);
  for (const PlanPlaneTorsion& s : plan.plane_torsions) add(s.element, s.stiffness, s.damping, calc_effort(ev, s));
  for (const PlanOneSided& s : plan.one_sided)
    add(s.element, calc_largest_stiffness(get_law(plan, s)), s.law.damping, calc_effort(plan, state, ev, s));
  return out;
}

std::vector<ElementMobility> calc_mobilities(const Plan& owner, const State& state, Workspace& workspace) {
  const PlanData& plan = owner.data();
  std::vector<ElementMobility> out;
  Evaluation* const ev = factor(plan, state, workspace);
  if (ev == nullptr) return out;
  for (const PlanOneSided& s : plan.one_sided)
    out.push_back({s.element, calc_mobility(plan, calc_effort(plan, state, *ev, s), *ev)});
  for (const PlanFriction& s : plan.frictions)
    out.push_back({s.element, calc_mobility(plan, calc_joint_effort(plan, state, *ev, s), *ev)});
  return out;
}

}  // namespace unlatch
