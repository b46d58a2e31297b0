// Shapes of bodies, for clearances and pictures: convex pieces in the axes of their body, metres.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace unlatch::hil {

struct Shape {
  enum class Kind {
    kSphere,    // from = centre, radius
    kCapsule,   // all points within `radius` of the segment from–to; radius 0: the segment itself
    kCylinder,  // axis from–to, radius
    kCone,      // base of `radius` around from, apex at to
    kBox,       // from = centre, size = edge lengths, q_BS = attitude of the box in the body
    kHull,      // convex hull of `points`
  };
  Kind kind = Kind::kSphere;
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  double radius = 0;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_BS = Eigen::Quaterniond::Identity();
  std::vector<Eigen::Vector3d> points{};
};

}  // namespace unlatch::hil
