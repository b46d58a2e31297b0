// The model's quantities, which are Eigen's, as the kernel's own, and vectors the other way.
#pragma once

#include "unlatch/math.h"
#include "unlatch/model.h"

namespace unlatch {

inline Vec3 to_vec(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
inline Eigen::Vector3d to_eigen(const Vec3& a) { return {a.x, a.y, a.z}; }
inline Mat3 to_mat(const Eigen::Matrix3d& m) { return {to_vec(m.col(0)), to_vec(m.col(1)), to_vec(m.col(2))}; }
inline Sym3 to_sym(const Eigen::Matrix3d& m) { return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)}; }
inline Quat to_quat(const Eigen::Quaterniond& q) { return normalized(Quat{q.w(), q.x(), q.y(), q.z()}); }

// R_WB of a body at the beginning; of the ground, no turn.
inline Eigen::Matrix3d get_attitude(const Model& model, int body) {
  return body == kGround ? Eigen::Matrix3d::Identity()
                         : model.bodies[static_cast<std::size_t>(body)].q_WB.normalized().toRotationMatrix();
}

// A point of a body, or of the ground, at the beginning, W.
inline Eigen::Vector3d place(const Model& model, int body, const Eigen::Vector3d& point) {
  if (body == kGround) return point;
  return model.bodies[static_cast<std::size_t>(body)].p_WB + get_attitude(model, body) * point;
}

// Axes of a joint's rotation rows, column by column, in each body's axes.
struct RotationFrame {
  Eigen::Matrix3d base, follower;
};
inline RotationFrame get_rotation_frame(const Model& model, const Joint& joint) {
  const Eigen::Matrix3d base = joint.rotation_axes.value_or(joint.axes);
  return {base, joint.follower_axes.value_or(get_attitude(model, joint.follower).transpose() *
                                             get_attitude(model, joint.base) * base)};
}

}  // namespace unlatch
