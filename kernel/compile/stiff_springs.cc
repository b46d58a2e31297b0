#include "kernel/compile/stiff_springs.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "kernel/math/index.h"
#include "unlatch/frequencies.h"

namespace unlatch {
namespace {

using Wrench =
    Eigen::Matrix<double, 12, 1>;  // on the base, then on the follower: force, torque about the centre of mass
// Matrices and vectors of a joint's rows: at most kRows, in memory of that size.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kRows, kRows>;
using RowVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kRows, 1>;

// The body that has the mass: of a marker its flexible body.
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
  std::array<Wrench, kRows> held, responses;
  int count = 0;
  for (int row = 0; row < kRows; ++row)
    if (has_row(rows, row)) {
      held[at(count)] = column(row);
      responses[at(count)] = inverse_mass.lazyProduct(held[at(count)]);
      ++count;
    }
  const Wrench effort = column(axis), motion = inverse_mass.lazyProduct(effort);
  const double free = effort.dot(motion);
  if (count == 0) return free;
  RowMatrix A(count, count);
  RowVector b(count);
  for (int i = 0; i < count; ++i) {
    b[i] = held[at(i)].dot(motion);
    for (int j = 0; j < count; ++j) A(i, j) = held[at(i)].dot(responses[at(j)]);
  }
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

}  // namespace unlatch
