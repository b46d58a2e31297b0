// Energies and powers of the whole system, for audits. Each power is that of a force of forces.h, loads.h,
// contacts.h, one_sided.h, friction.h, varying.h or flexible.h on the motion of the same evaluation; each strain energy
// is the integral of such a force.
#pragma once

#include "kernel/plan/evaluation.h"
#include "unlatch/step.h"

namespace unlatch {

// Needs the evaluation of this state at time t: kinematics, joints, coordinates, sizes of loads. See unlatch/energy.h.
EnergyFlow calc_energy_flow(const PlanData& plan, const State& state, double t, const Evaluation& ev,
                            const Vec3& frame) noexcept;

}  // namespace unlatch
