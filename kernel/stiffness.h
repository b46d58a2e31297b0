// How fast each elastic element would swing: what decides whether a step resolves it. Explicit Runge–Kutta is stable
// for h ω < 2.8 and accurate for h ω ≲ 0.2.
#pragma once

#include <vector>

#include "kernel/plan.h"
#include "kernel/workspace.h"

namespace unlatch {

struct ElementFrequency {
  int element;   // in the model's shared numbering
  double omega;  // rad/s: √(stiffness · mobility) along the element, joints and other bodies taken into account
  double decay;  // 1/s: damping · mobility
};

// Of every spring at `state`, whether it is switched on or not. Empty if the state has a singular pivot. O(n) per
// element.
std::vector<ElementFrequency> calc_frequencies(const Plan& plan, const State& state, Workspace& ws);

}  // namespace unlatch
