// Mechanisms of bars and hinges, given by points and axes in world coordinates.
#pragma once

#include <string>
#include <vector>

#include "unlatch/model.h"

namespace unlatch::test {

// Builds a rod of 1 m and 1 kg from one point to another.
Body build_rod(const std::string& name, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

// Builds a hinge at a point and about an axis, both in world coordinates.
Joint build_hinge(const Model& model, int base, int follower, const Eigen::Vector3d& point,
                  const Eigen::Vector3d& axis);

// Builds a closed chain of rods through `points`, hinged at each about `axes`, the last rod being the ground.
Model build_linkage(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& axes,
                    const Eigen::Vector3d& gravity);

}  // namespace unlatch::test
