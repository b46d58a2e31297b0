#include "kernel/joints/kinematics.h"

#include <cmath>

namespace unlatch {

BodyFrame get_body_frame(const Evaluation& ev, int body) noexcept {
  if (body == kGround) return get_ground<double>();
  const LaneOf<BodyLane> lane = get_lane<BodyLane>(ev.blocks.data(), ev.places[at(body)]);
  const MotionT<double> motion = lane.read(&BodyLane::motion);
  return {lane.read(&BodyLane::R), motion.p, motion.v, lane.read(&BodyLane::w_W)};
}

BodyKinematics read_kinematics(const Evaluation& ev, int body) noexcept {
  const LaneOf<BodyLane> lane = get_lane<BodyLane>(ev.blocks.data(), ev.places[at(body)]);
  return {lane.read(&BodyLane::R), lane.read(&BodyLane::w_W),
          read(ev.blocks.data(), ev.places[at(body)], &SharedLane::inertia)};
}

JointFrame get_joint_frame(const PlanData& plan, const State& state, const Evaluation& ev, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  if (j.non_tree != kNone) return ev.non_tree_frames[at(j.non_tree)];
  const JointView view(plan, ev, joint);
  const Spatial slip = view.get_slip();
  return {view.get_arm(false),
          view.get_arm(true),
          read(ev.blocks.data(), ev.places[at(j.child)], &SolverLane::axes),
          view.get_rotation_axes(),
          is_crossed(j, get_active_rows(plan, state, joint)),
          view.get_displacement(),
          slip.lin,
          slip.ang};
}

Mat3 calc_follower_axes(const PlanData& plan, const Evaluation& ev, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  return get_body_frame(ev, j.follower).R * rotation_matrix(j.rotation_follower);
}

double calc_reaction_size(const Evaluation& ev, int joint, int first) noexcept {
  double square = 0;
  for (int r = first; r < first + 3; ++r) {
    const double lambda = ev.multipliers.get(at(joint), at(r));
    square += lambda * lambda;
  }
  return std::sqrt(square);
}

Quat calc_relative_attitude(const PlanData& plan, const Evaluation& ev, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  const auto get_attitude = [&](int body) { return read(ev.blocks.data(), ev.places[at(body)], &BodyLane::motion).q; };
  const Quat base = j.base == kGround ? j.rotation_base : get_attitude(j.base) * j.rotation_base;
  return conjugate(base) * (get_attitude(j.follower) * j.rotation_follower);
}

}  // namespace unlatch
