// Between the state, one structure per body in the model's order, and the blocks of an evaluation.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// Poses, velocities and auxiliary states into the evaluation, rest into empty lanes, and the joints' modes.
void load_state(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

// The same without the modes.
void load_motion(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

// Equality of all that load_modes() reads: modes, offsets and attitudes at which rows hold.
bool has_same_modes(const State& a, const State& b) noexcept;

// The joints' modes alone: masks of freedoms and rows, offsets, carried axes; ev.modes.
void load_modes(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

// Poses, velocities and auxiliary states out of the evaluation into `state`.
void store_motion(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

// The same, and all else that the state remembers of a sub-step that has ended: angles and bearings, turns counted.
void store_substep(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

// All numbers that a step makes are finite: one that is not survives being summed.
bool is_finite(const State& state, std::span<const double> sensors) noexcept;

}  // namespace unlatch
