#include "kernel/step/stiffness.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kernel/dynamics/kinematics.h"
#include "kernel/plan/lane_access.h"
#include "kernel/solver/loops.h"
#include "kernel/solver/tree_solver.h"
#include "kernel/step/lane_state.h"

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

// --- One spring between its joint's two bodies ----------------------------------------------------------------------

using Wrench =
    Eigen::Matrix<double, 12, 1>;  // on the base, then on the follower: force, torque about the centre of mass
using Rows = Eigen::Matrix<double, 12, Eigen::Dynamic>;

// The body that carries the mass: a marker's flexible one.
const Body& get_carrier(const Model& model, const Body& body) {
  return body.marker ? model.bodies[at(body.marker->body)] : body;
}

Eigen::Vector3d calc_arm(const Model& model, const Body& body, const Eigen::Vector3d& point) {
  const Body& carrier = get_carrier(model, body);
  const Eigen::Vector3d centre = body.law ? body.law->knots.front().centre : Eigen::Vector3d::Zero();
  const Eigen::Vector3d place = body.marker ? Eigen::Vector3d(body.marker->position + point) : point;
  return carrier.q_WB.normalized() * (place - centre);
}

void add_inverse_mass(const Model& model, const Body& body, Eigen::Index first, Eigen::Matrix<double, 12, 12>& out) {
  const Body& carrier = get_carrier(model, body);
  const Eigen::Matrix3d R = carrier.q_WB.normalized().toRotationMatrix();
  out.block<3, 3>(first, first) = Eigen::Matrix3d::Identity() / carrier.mass;
  out.block<3, 3>(first + 3, first + 3) = (R * carrier.inertia * R.transpose()).inverse();
}

// Acceleration along the spring's axis per unit effort, with the joint in one of its modes.
double calc_pair_mobility(const Model& model, const Joint& joint, int axis, RowSet rows) {
  const Body& follower = model.bodies[at(joint.follower)];
  const Body* base = joint.base == kGround ? nullptr : &model.bodies[at(joint.base)];
  Eigen::Matrix<double, 12, 12> inverse_mass = Eigen::Matrix<double, 12, 12>::Zero();
  add_inverse_mass(model, follower, 6, inverse_mass);
  const Eigen::Vector3d arm = calc_arm(model, follower, joint.point_follower);
  Eigen::Vector3d base_arm = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  if (base != nullptr) {
    add_inverse_mass(model, *base, 0, inverse_mass);
    R = get_carrier(model, *base).q_WB.normalized().toRotationMatrix();
    base_arm = calc_arm(model, *base, joint.point_base);
  }
  const auto column = [&](int row) {
    Wrench w = Wrench::Zero();
    if (row < kRotX) {
      const Eigen::Vector3d n = R * joint.axes.col(row);
      w << -n, -base_arm.cross(n), n, arm.cross(n);
    } else {
      const Eigen::Vector3d n = R * joint.rotation_axes.value_or(joint.axes).col(row - kRotX);
      w << Eigen::Vector3d::Zero(), -n, Eigen::Vector3d::Zero(), n;
    }
    return w;
  };
  Rows held(12, 0);
  for (int row = 0; row < kRows; ++row)
    if (has_row(rows, row)) {
      held.conservativeResize(12, held.cols() + 1);
      held.rightCols<1>() = column(row);
    }
  const Wrench effort = column(axis), motion = inverse_mass * effort;
  const double free = effort.dot(motion);
  if (held.cols() == 0) return free;
  const Eigen::MatrixXd A = held.transpose() * inverse_mass * held;
  const Eigen::VectorXd b = held.transpose() * motion;
  return std::max(0.0, free - b.dot(A.ldlt().solve(b)));
}

bool is_stiff_spring(const Model& model, const JointSpring& spring, double h) {
  const Joint& joint = model.joints[at(spring.joint)];
  double mobility = 0;
  for (const JointMode& mode : joint.modes)
    if (!has_row(mode.rows, spring.axis))
      mobility = std::max(mobility, calc_pair_mobility(model, joint, spring.axis, mode.rows));
  return h * std::sqrt(spring.stiffness * mobility) > kResolved || h * spring.damping * mobility > kResolved;
}

}  // namespace

std::vector<bool> find_stiff_springs(const Model& model, double h) {
  std::vector<bool> stiff;
  for (const JointSpring& spring : model.joint_springs)
    stiff.push_back(spring.implicit ? *spring.implicit : is_stiff_spring(model, spring, h));
  return stiff;
}

std::vector<ElementFrequency> calc_frequencies(const Plan& plan, const State& state, Workspace& ws) {
  std::vector<ElementFrequency> out;
  load_state(plan, state, ws);
  update_kinematics(plan, ws);
  update_joints(plan, state, BiasKind::kVelocity, ws);
  ws.loop_most = kAllRows;
  if (factor_and_solve(plan, state, ws, {Source::kNothing, false, false}) != kNone) return out;
  const auto add = [&](int element, double stiffness, double damping, const Effort& effort, bool implicit = false) {
    const double mobility = calc_mobility(plan, effort, ws);
    out.push_back({element, std::sqrt(stiffness * mobility), damping * mobility, implicit});
  };
  for (const PlanPointSpring& s : plan.point_springs) add(s.element, s.stiffness, s.damping, calc_effort(ws, s));
  for (const PlanJointSpring& s : plan.joint_springs)
    add(s.element, s.stiffness, s.damping, calc_effort(plan, state, ws, s), s.compliant != kNone);
  for (const PlanPlaneTorsion& s : plan.plane_torsions) add(s.element, s.stiffness, s.damping, calc_effort(ws, s));
  return out;
}

}  // namespace unlatch
