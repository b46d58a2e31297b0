// Momenta and energy of the whole system, and the audit of what an event changed.
#pragma once

#include "kernel/plan/evaluation.h"
#include "unlatch/step.h"

namespace unlatch {

// Needs the kinematics of this state.
Balance calc_balance(const PlanData& plan, const State& state, const Evaluation& ev) noexcept;

// The change that a plastic impulse may bring: the momenta that the ground takes, and the energy ½ Λᵀ G v that the
// closing rows lose. Needs the impulses in ev.multipliers, and the joints' frames from just before it.
Balance calc_allowed_change(const PlanData& plan, const State& state, const Evaluation& ev) noexcept;

}  // namespace unlatch
