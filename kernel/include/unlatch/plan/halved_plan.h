// The same system at half the step: two steps of it beside one of the plan show what the step's length does to the
// motion. Nothing is compiled again: springs and modes that are integrated implicitly stay so.
#pragma once

#include "unlatch/plan.h"
#include "unlatch/state.h"

namespace unlatch {

// The plan at half its step. It shares the data of `plan`, keeps them alive, and has no image. Allocates some
// kilobytes.
Plan halve_step(const Plan& plan);

// Makes `to`, a state of the halved plan, that of `from`, a state of the plan. The blocks have the same layout.
void copy_to_halved(const State& from, const Plan& halved, const State& to) noexcept;

}  // namespace unlatch
