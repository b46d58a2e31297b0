#include "kernel/compile/constants.h"

#include <algorithm>
#include <iterator>

#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

// Bodies with mass laws and flexible bodies have neither mass nor inertia here. An empty lane has no mass, but an
// inertia that is not singular.
void fill_bodies(const Model& model, PlanDraft& plan) {
  plan.body_constants.assign(kNumbers<BodyConstants> * kEight * plan.eights.size(), 0.0);
  const auto get_constants = [&](const BodyEight& eight, int lane) {
    return unlatch::get_constants(eight, plan.body_constants.data(), lane);
  };
  for (const BodyEight& eight : plan.eights)
    for (int lane = 0; lane < kEight; ++lane)
      get_constants(eight, lane).write(&BodyConstants<double>::inertia, {1, 1, 1, 0, 0, 0});
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const std::int32_t place = plan.places[b].body;
    const BodyEight& eight = *std::prev(std::ranges::upper_bound(plan.eights, place, {}, &BodyEight::body));
    const double mass = plan.bodies[b].mass;
    const Sym3 J = mass == 0 ? Sym3{0, 0, 0, 0, 0, 0} : to_sym(model.bodies[b].inertia);
    get_constants(eight, place - eight.body).write({J, mass});
  }
}

// An empty lane's joint has a frame that is not singular.
void fill_joint(const Model& model, int joint, const Group& group, const LaneConstants& constants) {
  const Joint* j = joint == kNone ? nullptr : &model.joints[at(joint)];
  const Vec3 none{0, 0, 0};
  constants.joint().write({j == nullptr ? none : to_vec(j->point_base), j == nullptr ? none : to_vec(j->point_follower),
                           j == nullptr ? kIdentity3 : to_mat(j->axes)});
  if (group.shared_axes) return;
  const RotationFrame frame = j == nullptr ? RotationFrame{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()}
                                           : get_rotation_frame(model, *j);
  constants.rotation().write({to_mat(frame.base), to_vec(frame.follower.col(1))});
}

// Constants of a group's joints and of the solver. The body of an empty lane is held by nothing.
void fill_group(const Model& model, const Group& group, PlanDraft& plan) {
  for (int lane = 0; lane < group.width; ++lane) {
    const int node = plan.lane_nodes[at(group.first + lane)];
    const TreeNode* n = node == kNone ? nullptr : &plan.nodes[at(node)];
    const LaneConstants constants(group, plan.solver_constants.data(), plan.joint_constants.data(), lane,
                                  {group.width});
    constants.solver().write({n == nullptr ? 1 : plan.bodies[at(n->body)].mass, n == nullptr ? 0.0 : n->side});
    if (group.has_joint) fill_joint(model, n == nullptr ? kNone : n->joint, group, constants);
  }
}

}  // namespace

void fill_constants(const Model& model, const LaidOutDraft& draft) {
  PlanDraft& plan = draft.plan;
  fill_bodies(model, plan);
  plan.solver_constants.assign(kNumbers<SolverConstants> * plan.lane_nodes.size(), 0.0);
  for (const Group& group : plan.groups) fill_group(model, group, plan);
}

}  // namespace unlatch
