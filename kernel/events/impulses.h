// Impulses that acting events bring about, see Impulse in unlatch/model.h.
#pragma once

#include "kernel/plan/evaluation.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

// True if some event that acts (`acting` is 1) has an impulse.
bool has_impulses(const PlanData& plan, std::span<const std::int64_t> acting) noexcept;

// Writes them, N s and N m s, to the bodies' forces in the evaluation, in place of all other forces. Returns the source
// from which apply_impulse() takes them.
Source set_impulses(const PlanData& plan, const Inputs& inputs, std::span<const std::int64_t> acting,
                    Evaluation& ev) noexcept;

// Momenta that they add. `kinetic`: half the work that they would do at the present velocities; since the work is that
// at the mean of the velocities before and after, it is the sum of both halves.
Balance calc_impulses(const PlanData& plan, const Inputs& inputs, std::span<const std::int64_t> acting,
                      const Evaluation& ev) noexcept;

}  // namespace unlatch
