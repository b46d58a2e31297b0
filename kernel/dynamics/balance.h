// Momenta and energy of the whole system, and the audit of what an event changed.
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"
#include "unlatch/step.h"

namespace unlatch {

// Needs ws.kinematics of this state.
Balance calc_balance(const Plan& plan, const State& state, const Workspace& ws) noexcept;

// What a plastic impulse may change: the momenta that the ground takes, and the energy ½ Λᵀ G v that the closing rows
// lose. Needs the impulses in ws.multipliers, and ws.frames from just before it.
Balance calc_impulse_entitlement(const Plan& plan, const State& state, const Workspace& ws) noexcept;

}  // namespace unlatch
