// Springs between points as a state has them, for reports. The step computes the same force by the same formula.
#pragma once

#include "unlatch/plan.h"
#include "unlatch/state.h"

namespace unlatch {

// Length and force of a spring between two points.
struct SpringReading {
  double length = 0;  // between its ends, m
  double force = 0;   // along the line on the follower, away from the base: a push is positive; N
  double scale = 0;   // of its switch: 0 while it is off
};

// Of a point spring (its number in the model) at the state's tick.
SpringReading calc_point_spring(const Plan& plan, const State& state, int spring) noexcept;

}  // namespace unlatch
