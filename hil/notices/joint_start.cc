#include "hil/notices/joint_start.h"

#include <cmath>

#include "hil/motion/pose.h"

namespace unlatch::hil {

Eigen::Vector3d calc_start_displacement(const Model& model, const Joint& joint) {
  const Pose base = get_start_pose(model, joint.base), follower = get_start_pose(model, joint.follower);
  const Eigen::Vector3d gap = place(follower, joint.point_follower) - place(base, joint.point_base);
  return joint.axes.transpose() * (base.q_WB.conjugate() * gap);
}

double calc_start_angle(const Model& model, const Joint& joint, int axis) {
  if (!joint.follower_axes) return 0;
  const Eigen::Matrix3d base =
      get_start_pose(model, joint.base).q_WB.toRotationMatrix() * joint.rotation_axes.value_or(joint.axes);
  const Eigen::Matrix3d follower = get_start_pose(model, joint.follower).q_WB.toRotationMatrix() * *joint.follower_axes;
  const Eigen::Matrix3d R = base.transpose() * follower;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  return std::atan2(R(v, u) - R(u, v), R(u, u) + R(v, v));
}

}  // namespace unlatch::hil
