// Conversion of the model's vectors and matrices, which are Eigen's, to the kernel's own.
#pragma once

#include <Eigen/Core>

#include "unlatch/math.h"

namespace unlatch::hil {

inline Vec3 to_vec3(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
inline Mat3 to_mat3(const Eigen::Matrix3d& m) { return {to_vec3(m.col(0)), to_vec3(m.col(1)), to_vec3(m.col(2))}; }

}  // namespace unlatch::hil
