// What pushes and pulls at one stage: gravity, loads, springs and dampers, gyroscopic torque.
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// What acts beside the forces that the lanes sum (init_forces() in lane_kernels.h), at time t, s; needs kinematics,
// joint frames, coordinates and loads of this stage.
void add_forces(const Plan& plan, const State& state, double t, Workspace& ws) noexcept;

// Acceleration of free fall at a point of W, m/s².
Vec3 calc_gravity(const Plan& plan, const Vec3& p) noexcept;

}  // namespace unlatch
