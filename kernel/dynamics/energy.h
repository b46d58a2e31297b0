// Energies and powers of the whole system, for audits. Each power is that of a force of an element (kernel/elements),
// of varying.h or flexible.h on the motion of the same evaluation; each strain energy is the integral of such a force.
//
#pragma once

#include "kernel/plan/evaluation.h"
#include "unlatch/energy.h"

namespace unlatch {

// `ev`: the evaluation of `state` at time t, s. See unlatch/energy.h.
EnergyFlow calc_energy_flow(const PlanData& plan, const State& state, double t, const Evaluation& ev,
                            const Vec3& frame) noexcept;

}  // namespace unlatch
