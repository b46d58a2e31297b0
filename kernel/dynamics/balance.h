// Momenta and energy of the whole system, and the audit of what an event changed.
#pragma once

#include "kernel/plan/evaluation.h"
#include "unlatch/energy.h"

namespace unlatch {

// Of `state`, whose kinematics are in `ev`.
Balance calc_balance(const PlanData& plan, const State& state, const Evaluation& ev) noexcept;

// The change that a plastic impulse may make: the momenta that the ground takes, and the energy ½ Λᵀ G v that the
// closing rows lose. `ev` has the impulses in its multipliers, and the joints' frames from just before the impulse.
Balance calc_allowed_change(const PlanData& plan, const State& state, const Evaluation& ev) noexcept;

}  // namespace unlatch
