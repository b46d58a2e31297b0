// Impulses that acting events bring about, see Impulse in unlatch/model.h.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// Some event that acts (`acting` is 1) has one.
bool has_impulses(const PlanData& plan, std::span<const std::int64_t> acting) noexcept;

// They become the bodies' forces in the evaluation, N s and N m s, and nothing else does.
void set_impulses(const PlanData& plan, const Inputs& inputs, std::span<const std::int64_t> acting,
                  Evaluation& ev) noexcept;

// Momenta that they bring in; `kinetic`: half the work that they would do at the present velocities. The mean of the
// velocities before and after does the work, so it is the sum of both halves.
Balance calc_impulses(const PlanData& plan, const Inputs& inputs, std::span<const std::int64_t> acting,
                      const Evaluation& ev) noexcept;

}  // namespace unlatch
