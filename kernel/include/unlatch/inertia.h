// Principal moments and axes of inertia.
#pragma once

#include <Eigen/Core>

namespace unlatch {

// Principal moments of a symmetric inertia, kg m², rising. Numbers that are not finite come out as NaN.
[[nodiscard]] Eigen::Vector3d calc_principal_moments(const Eigen::Matrix3d& inertia);

// Moments as above, and the axes of each as a column, in the frame of the inertia; they are right-handed and have
// length 1.
struct PrincipalAxes {
  Eigen::Vector3d moments;
  Eigen::Matrix3d axes;
};
// Principal moments and axes of a symmetric inertia, kg m².
[[nodiscard]] PrincipalAxes calc_principal_axes(const Eigen::Matrix3d& inertia);

}  // namespace unlatch
