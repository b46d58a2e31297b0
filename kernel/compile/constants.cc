#include "kernel/compile/constants.h"

#include <algorithm>
#include <iterator>

#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

// Bodies with mass laws and flexible ones have no mass and inertia of their own. Nor has an empty lane a mass, but an
// inertia that is not singular.
void fill_bodies(const Model& model, PlanDraft& plan) {
  using Constants = BodyConstants<double>;
  plan.body_constants.assign(kNumbers<BodyConstants> * kEight * plan.eights.size(), 0.0);
  const auto get_constants = [&](const BodyEight& eight, int lane) {
    return LaneOf<Constants>{plan.body_constants.data() + eight.constants + lane, kEight};
  };
  for (const BodyEight& eight : plan.eights)
    for (int lane = 0; lane < kEight; ++lane) get_constants(eight, lane).write(&Constants::inertia, {1, 1, 1, 0, 0, 0});
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const std::int32_t place = plan.places[b].body;
    const BodyEight& eight = *std::prev(std::ranges::upper_bound(plan.eights, place, {}, &BodyEight::body));
    const double mass = plan.bodies[b].mass;
    const Sym3 J = mass == 0 ? Sym3{0, 0, 0, 0, 0, 0} : to_sym(model.bodies[b].inertia);
    get_constants(eight, place - eight.body).write({J, mass});
  }
}

// An empty lane's joint has a frame that is not singular.
void fill_joint(const Model& model, int joint, const Group& group, int lane, PlanDraft& plan) {
  const Joint* j = joint == kNone ? nullptr : &model.joints[at(joint)];
  double* first = plan.joint_constants.data() + group.constants + lane;
  const Vec3 none{0, 0, 0};
  LaneOf<JointConstants<double>>{first, group.width}.write({j == nullptr ? none : to_vec(j->point_base),
                                                            j == nullptr ? none : to_vec(j->point_follower),
                                                            j == nullptr ? kIdentity3 : to_mat(j->axes)});
  if (group.shared_axes) return;
  const RotationFrame frame = j == nullptr ? RotationFrame{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()}
                                           : get_rotation_frame(model, *j);
  LaneOf<RotationConstants<double>>{first + kNumbers<JointConstants> * group.width, group.width}.write(
      {to_mat(frame.base), to_vec(frame.follower.col(1))});
}

// Constants of a group's joints and of the solver. An empty lane has a body that nothing holds.
void fill_group(const Model& model, const Group& group, PlanDraft& plan) {
  for (int lane = 0; lane < group.width; ++lane) {
    const int node = plan.lane_nodes[at(group.first + lane)];
    const TreeNode* n = node == kNone ? nullptr : &plan.nodes[at(node)];
    double* solver = plan.solver_constants.data() + kNumbers<SolverConstants> * group.first + lane;
    LaneOf<SolverConstants<double>>{solver, group.width}.write(
        {n == nullptr ? 1 : plan.bodies[at(n->body)].mass, n == nullptr ? 0.0 : n->side});
    if (group.has_joint) fill_joint(model, n == nullptr ? kNone : n->joint, group, lane, plan);
  }
}

}  // namespace

void fill_constants(const Model& model, PlanDraft& plan) {
  fill_bodies(model, plan);
  plan.solver_constants.assign(kNumbers<SolverConstants> * plan.lane_nodes.size(), 0.0);
  for (const Group& group : plan.groups) fill_group(model, group, plan);
}

}  // namespace unlatch
