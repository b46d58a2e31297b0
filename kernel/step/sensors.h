// Readings of the instruments.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// ev.sensors; needs the evaluation of `state`.
void update_sensors(const PlanData& plan, const State& state, Evaluation& ev) noexcept;

}  // namespace unlatch
