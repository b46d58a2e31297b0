// Poses of bodies.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "hil/scenario/base/index.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct Pose {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
};

// Point p of the body, W.
inline Eigen::Vector3d place(const Pose& pose, const Eigen::Vector3d& p) { return pose.p_WB + pose.q_WB * p; }

// Pose of a body of the model, or of the ground, at the start.
inline Pose get_start_pose(const Model& model, int body) {
  if (body == kGround) return {};
  const Body& b = model.bodies[at(body)];
  return {b.p_WB, Eigen::Quaterniond(b.q_WB.normalized())};
}

}  // namespace unlatch::hil
