// Energies and powers of a state, for the audit of a run: between two instants without events,
//
//   change of (kinetic + strain + dissipated) = ∫ Σ powers dt,
//
// whatever the method that moved the bodies. Kinetic energy, momentum, and powers that are not conservative; springs
// and modes count by what they store. O(n), off the step: an observer calls these, the step does not.
#pragma once

#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/step.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Velocity of an observer in whose frame the energy of `state` is that of separation and rotation alone: that of the
// centre of mass; 0 while a joint or an element that is on holds a body to the ground, for the ground does no work
// only at rest. World axes, m/s.
Vec3 calc_audit_frame(const Plan& plan, const State& state, const Workspace& workspace) noexcept;

// Energies and powers of the state that the latest step() or update_outputs() left in the workspace, seen by an
// observer with the constant velocity `frame`, world axes, m/s.
EnergyFlow calc_energy_flow(const Plan& plan, const State& state, const Workspace& workspace,
                            const Vec3& frame) noexcept;
// The same, seen by another observer: `change` is added to the velocity of the first.
EnergyFlow change_frame(const EnergyFlow& flow, const Vec3& change) noexcept;

// Largest position residual of the rows that hold, m or rad, of that state. The projections keep it near rounding.
double calc_drift(const Plan& plan, const State& state, const Workspace& workspace) noexcept;

}  // namespace unlatch
