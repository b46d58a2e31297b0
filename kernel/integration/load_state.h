// Between the state, one structure per body in the model's order, and the blocks of an evaluation.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// Loads poses, velocities and auxiliary states into the evaluation, and the joints' modes. Empty lanes get a body at
// rest.
void load_state(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

// The same without the modes.
void load_motion(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

// True if all that load_modes() reads is equal: modes, offsets and attitudes at which rows hold.
bool has_same_modes(const State& a, const State& b) noexcept;

// Loads the joints' modes alone: ev.modes, and masks of freedoms and rows, offsets and carried axes of the blocks.
void load_modes(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

// Stores poses, velocities and auxiliary states from the evaluation in `state`.
void store_motion(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

// The same with all else that the state remembers of a sub-step: angles and bearings, turns counted.
void store_substep(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

// True if all numbers that a step computes are finite. Tests their sum, which is not finite if one of them is not.
bool is_finite(const State& state, std::span<const double> sensors) noexcept;

}  // namespace unlatch
