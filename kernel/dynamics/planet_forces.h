// Weights of rigid bodies near a planet, and the torques of its gradient on all bodies. Weights of bodies that bend or
// burn are with their other forces (flexible.h, varying.h).
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// Adds them to the bodies' forces. `origin`: calc_origin_place() of the time.
void add_planet_forces(const PlanData& plan, const Vec3& origin, Evaluation& ev) noexcept;

// Power of the gradient's torques, W.
double calc_gradient_power(const PlanData& plan, const Vec3& origin, const Evaluation& ev) noexcept;

}  // namespace unlatch
