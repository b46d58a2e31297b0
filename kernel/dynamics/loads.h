// Loads: forces and torques that a law of time and a command size. Neither asks where the bodies are, so that stages of
// a step at one instant share them; those fixed in a body are summed in its axes, and go with it into the world.
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

struct Inputs;

// An element's switch scale at time t.
inline double calc_scale(const ElementState& element, double t) noexcept {
  const double elapsed = t - element.start;
  if (!(elapsed < element.duration)) return element.to;
  return element.from + (element.to - element.from) * (elapsed / element.duration);
}

// A profile's value, s seconds after its element was switched on.
double calc_profile(const Plan& plan, const PlanProfile& profile, double s) noexcept;

// ws.load_sizes at time t, s, and in the lanes the wrenches that loads fixed in a body add up to.
void update_loads(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept;

// The sizes count no more: other elements are on, or commands are others. What laws of time gave still holds.
void forget_sizes(Workspace& ws) noexcept;
// Nothing of loads counts any more: the workspace is another.
void forget_loads(const Plan& plan, Workspace& ws) noexcept;

}  // namespace unlatch
