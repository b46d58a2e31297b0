#include "hil/run/motion/joint_frame.h"

#include "hil/scenario/base/from_eigen.h"
#include "hil/scenario/base/pose.h"

namespace unlatch::hil {

JointGeometry::JointGeometry(const Model& model, int joint) {
  const Joint& own = model.joints[static_cast<std::size_t>(joint)];
  base_ = own.base;
  follower_ = own.follower;
  p_base_ = to_vec3(own.point_base);
  p_follower_ = to_vec3(own.point_follower);
  axes_ = to_mat3(own.axes);
  const Eigen::Matrix3d rotation = own.rotation_axes.value_or(own.axes);
  rotation_axes_ = to_mat3(rotation);
  if (own.follower_axes) {
    follower_axes_ = to_mat3(*own.follower_axes);
    return;
  }
  const auto attitude = [&](int body) { return get_start_pose(model, body).q_WB.toRotationMatrix(); };
  follower_axes_ = to_mat3(attitude(follower_).transpose() * attitude(base_) * rotation);
}

Vec3 JointGeometry::calc_axis(const BodyState& base, int row) const {
  return rotation_matrix(base.q) * (row < kRotX ? column(axes_, row) : column(rotation_axes_, row - kRotX));
}

double JointGeometry::calc_coordinate(const BodyState& base, const BodyState& follower, int row) const {
  const Mat3 R_base = rotation_matrix(base.q), R_follower = rotation_matrix(follower.q);
  if (row >= kRotX) return calc_twist(R_base * rotation_axes_, R_follower * follower_axes_, row - kRotX);
  const Vec3 apart = (follower.p + R_follower * p_follower_) - (base.p + R_base * p_base_);
  return dot(R_base * column(axes_, row), apart);
}

double JointGeometry::calc_speed(const BodyState& base, const BodyState& follower, int row) const {
  const Mat3 R_base = rotation_matrix(base.q), R_follower = rotation_matrix(follower.q);
  const Vec3 w_base = R_base * base.w, w_follower = R_follower * follower.w, axis = calc_axis(base, row);
  if (row >= kRotX) return dot(axis, w_follower - w_base);
  const Vec3 r_follower = R_follower * p_follower_, r_base = (follower.p + r_follower) - base.p;
  return dot(axis, (follower.v + cross(w_follower, r_follower)) - (base.v + cross(w_base, r_base)));
}

}  // namespace unlatch::hil
