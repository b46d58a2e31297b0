// How fast each elastic element would swing: what decides whether a step resolves it. Explicit Runge–Kutta is stable
// for h ω < 2.8 and accurate for h ω ≲ 0.2.
#pragma once

#include <vector>

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// A spring or a mode that swings faster than this, in h ω, is more than a step can resolve: it is integrated implicitly
// (compliance.h) where it can be. Explicit Runge–Kutta keeps 1 % of amplitude and phase per step there, and is stable
// to 2.8, which is what is left for springs that swing together faster than each alone.
inline constexpr double kResolved = 1;

// Joint springs to be integrated implicitly: as the user has said, else those for which h ω, or h times the rate of
// their decay, is more than kResolved in some mode of their joint. ω is that of the joint's two bodies alone, held by
// its rows, at their initial poses: more than it is with other bodies on them. O(1) per spring.
std::vector<bool> find_stiff_springs(const Model& model, double h);

struct ElementFrequency {
  int element;   // in the model's shared numbering
  double omega;  // rad/s: √(stiffness · mobility) along the element, joints and other bodies taken into account
  double decay;  // 1/s: damping · mobility
  bool implicit;
};

// Of every spring at `state`, whether it is switched on or not. Empty if the state has a singular pivot. O(n) per
// element.
std::vector<ElementFrequency> calc_frequencies(const Plan& plan, const State& state, Workspace& ws);

}  // namespace unlatch
