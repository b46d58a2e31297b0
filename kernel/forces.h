// What pushes and pulls at one stage: gravity, loads, springs and dampers, gyroscopic torque.
#pragma once

#include "kernel/plan.h"
#include "kernel/workspace.h"

namespace unlatch {

struct Inputs;

// An element's switch scale at time t.
double calc_scale(const ElementState& element, double t) noexcept;

// A profile's value, s seconds after its element was switched on.
double calc_profile(const Plan& plan, const PlanProfile& profile, double s) noexcept;

// ws.forces at time t, s; needs ws.kinematics, ws.frames and ws.coordinates.
void update_forces(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept;

// What the latest stages computed of loads counts no more: a new state, perhaps in a new workspace.
void forget_profiles(Workspace& ws) noexcept;

// Acceleration of free fall at a point of W, m/s².
Vec3 calc_gravity(const Plan& plan, const Vec3& p) noexcept;

}  // namespace unlatch
