// Coordinates of a joint at the start. `model`: with its markers placed (place_markers()).
#pragma once

#include <Eigen/Core>

#include "unlatch/model.h"

namespace unlatch::hil {

// Displacement of the follower's point from the base's, along the joint's axes, m.
Eigen::Vector3d calc_start_displacement(const Model& model, const Joint& joint);
// Angle about axis 0, 1, 2 of the rotation frame, rad: for a hinge, its angle.
double calc_start_angle(const Model& model, const Joint& joint, int axis);

}  // namespace unlatch::hil
