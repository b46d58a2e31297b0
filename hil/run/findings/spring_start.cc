#include "hil/run/findings/spring_start.h"

#include <cmath>

#include "hil/scenario/model/index.h"
#include "hil/scenario/model/pose.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

// A body, or the ground, at its initial pose and at rest.
BodyState get_rest(const Model& model, int body) {
  const Pose pose = get_start_pose(model, body);
  return {{pose.p_WB.x(), pose.p_WB.y(), pose.p_WB.z()},
          {pose.q_WB.w(), pose.q_WB.x(), pose.q_WB.y(), pose.q_WB.z()},
          {0, 0, 0},
          {0, 0, 0}};
}

SpringStart start_joint_spring(const Model& model, const JointSpring& s) {
  const Joint& joint = model.joints[at(s.joint)];
  SpringStart out{s.name, "joint spring", s.on, s.axis >= kRotX};
  // Without axes of the follower the start is the zero of its angles.
  out.length = out.angular && !joint.follower_axes ? 0 : calc_start(model, joint, s.axis);
  const double stretch = out.length - s.rest;
  out.force = calc_joint_spring(s, out.length, 0, 1);
  out.energy = 0.5 * s.stiffness * stretch * stretch;
  out.stroke = s.stiffness > 0 ? std::abs(s.rest + s.effort / s.stiffness - out.length) : 0;
  return out;
}

SpringStart start_torsion(const Model& model, const PlaneTorsion& s) {
  SpringStart out{s.name, "torsion", s.on, true};
  const PlaneTorsionForce start = calc_plane_torsion(s, get_rest(model, s.base), get_rest(model, s.follower), 1);
  out.length = start.angle;
  out.force = start.size;
  out.energy = 0.5 * s.stiffness * out.length * out.length;
  out.stroke = std::abs(out.length);
  return out;
}

}  // namespace

SpringStart start_point_spring(const Model& model, const PointSpring& s) {
  SpringStart out{s.name, s.push_only ? "pusher" : "spring", s.on};
  const PointSpringForce start = calc_point_spring(s, get_rest(model, s.base), get_rest(model, s.follower), 1);
  out.length = start.length;
  const double stretch = out.length - s.free_length;
  if (s.push_only && stretch >= 0) return out;
  out.force = start.size;
  out.energy = 0.5 * s.stiffness * stretch * stretch;
  out.stroke = std::abs(stretch);
  return out;
}

SpringStart start_one_sided(const Model& model, const OneSided& f) {
  const char* const kinds[] = {"pusher", "stop", "cord"};
  SpringStart out{f.name, kinds[static_cast<int>(f.kind)], f.on, f.joint != kNone && f.axis >= kRotX};
  out.length = calc_start(model, f);
  const double sign = f.pulls ? -1 : 1, depth = sign * (calc_limit(model, f) - out.length);
  if (depth < 0) return out;
  out.force = sign * calc_one_sided_force(f, depth, 0);
  out.energy = calc_one_sided_energy(f, depth);
  out.stroke = depth;
  return out;
}

std::vector<SpringStart> list_springs(const Scenario& scenario) {
  const Model model = place_markers(scenario.model);
  std::vector<SpringStart> springs;
  for (const PointSpring& s : model.point_springs) springs.push_back(start_point_spring(model, s));
  for (const JointSpring& s : model.joint_springs) springs.push_back(start_joint_spring(model, s));
  for (const PlaneTorsion& s : model.plane_torsions) springs.push_back(start_torsion(model, s));
  for (const OneSided& f : model.one_sided) springs.push_back(start_one_sided(model, f));
  return springs;
}

}  // namespace unlatch::hil
