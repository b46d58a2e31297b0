// Loads: forces and torques that a law of time and a command size. Neither asks where the bodies are, so that stages of
// a step at one instant share them; those fixed in a body are summed in its axes, and go with it into the world.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// A profile's value, s seconds after its element was switched on.
double calc_profile(const PlanData& plan, const PlanProfile& profile, double s) noexcept;

// ev.load_sizes, and in the blocks the wrenches that loads fixed in a body add up to.
void update_loads(const Instant& now, Evaluation& ev) noexcept;

}  // namespace unlatch
