#include "kernel/plan/lane_constants.h"

#include <algorithm>
#include <iterator>

#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Bodies with mass laws and flexible ones have no mass and inertia of their own. Nor has an empty lane a mass, but an
// inertia that is not singular.
void fill_bodies(const Model& model, Plan& plan) {
  plan.body_constants.assign(kBodyConstants * kOctet * plan.octets.size(), 0.0);
  for (const LaneOctet& octet : plan.octets)
    std::fill_n(plan.body_constants.data() + octet.constants + kBodyInertia * kOctet, 3 * kOctet, 1.0);
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const std::int32_t place = plan.body_slots[b].body;
    const LaneOctet& octet = *std::prev(std::ranges::upper_bound(plan.octets, place, {}, &LaneOctet::body));
    const double mass = plan.bodies[b].mass;
    const Sym3 J = mass == 0 ? Sym3{0, 0, 0, 0, 0, 0} : to_sym(model.bodies[b].inertia);
    double* to = plan.body_constants.data() + octet.constants + (place - octet.body);
    for (const double number : {J.xx, J.yy, J.zz, J.xy, J.xz, J.yz, mass}) {
      *to = number;
      to += kOctet;
    }
  }
}

// Writes the constants of one lane of a group's joints.
class JointConstants {
 public:
  JointConstants(Plan& plan, const LaneGroup& group, int lane)
      : to_(plan.joint_constants.data() + group.constants + lane), stride_(group.width) {}

  void set(JointConstant row, const Vec3& a) const {
    double* to = to_ + row * stride_;
    to[0] = a.x;
    to[stride_] = a.y;
    to[2 * stride_] = a.z;
  }
  void set(JointConstant row, const Mat3& m) const {
    set(row, m.x);
    set(row + 3, m.y);
    set(row + 6, m.z);
  }

 private:
  double* to_;
  int stride_;
};

// An empty lane's joint has a frame that is not singular.
void fill_joint(const Model& model, int joint, const LaneGroup& group, const JointConstants& out) {
  const Joint* j = joint == kNone ? nullptr : &model.joints[at(joint)];
  out.set(kPointBase, j == nullptr ? Vec3{0, 0, 0} : to_vec(j->point_base));
  out.set(kPointFollower, j == nullptr ? Vec3{0, 0, 0} : to_vec(j->point_follower));
  out.set(kBaseAxes, j == nullptr ? kIdentity3 : to_mat(j->axes));
  if (group.shared_axes) return;
  const RotationFrame frame = j == nullptr ? RotationFrame{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()}
                                           : get_rotation_frame(model, *j);
  out.set(kRotationAxes, to_mat(frame.base));
  out.set(kFollowerY, to_vec(frame.follower.col(1)));
}

// Of a group's joints and of the solver. An empty lane has a body that nothing holds.
void fill_group(const Model& model, const LaneGroup& group, Plan& plan) {
  for (int lane = 0; lane < group.width; ++lane) {
    double* solver = plan.solver_constants.data() + kSolverConstants * group.first + lane;
    const int node = plan.lane_nodes[at(group.first + lane)];
    const PlanNode* n = node == kNone ? nullptr : &plan.nodes[at(node)];
    solver[kMass * group.width] = n == nullptr ? 1 : plan.bodies[at(n->body)].mass;
    solver[kSide * group.width] = n == nullptr ? 0 : n->side;
    if (group.has_joint) fill_joint(model, n == nullptr ? kNone : n->joint, group, {plan, group, lane});
  }
}

}  // namespace

void fill_constants(const Model& model, Plan& plan) {
  fill_bodies(model, plan);
  plan.solver_constants.assign(kSolverConstants * plan.lane_nodes.size(), 0.0);
  for (const LaneGroup& group : plan.groups) fill_group(model, group, plan);
}

}  // namespace unlatch
