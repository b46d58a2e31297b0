// Frequencies of elastic elements, which decide whether a step resolves them. Explicit Runge–Kutta is stable for
// h ω < 2.8 and accurate for h ω ≲ 0.2.
#pragma once

#include <vector>

#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

// A spring or a mode that swings faster than this, in h ω, is more than a step can resolve: it is integrated implicitly
// where it can be. Explicit Runge–Kutta keeps 1 % of amplitude and phase per step there, and is stable to 2.8, which is
// left for springs that swing together faster than each alone.
inline constexpr double kResolved = 1;

// Frequency of an elastic element, for the choice of the step.
struct ElementFrequency {
  int element;    // in the model's shared numbering
  double omega;   // rad/s: √(stiffness · mobility) along the element, joints and other bodies taken into account
  double decay;   // 1/s: damping · mobility
  bool implicit;  // integrated implicitly
};

// Frequencies of every spring and one-sided force at `state`, whether it is switched on or not. Empty if the state has
// a singular pivot. O(n) per element. The workspace loses its outputs.
std::vector<ElementFrequency> calc_frequencies(const Plan& plan, const State& state, Workspace& workspace);

// Mobility of an element, for what resists its motion by a law of its own.
struct ElementMobility {
  int element;   // in the model's shared numbering
  double value;  // 1/kg or 1/(kg m²): acceleration along the element that its unit effort brings about
};

// Mobilities of every one-sided force and friction in a joint at `state`, whether it is switched on or not; joints and
// other bodies are taken into account. Empty if the state has a singular pivot. O(n) per element. The workspace loses
// its outputs.
std::vector<ElementMobility> calc_mobilities(const Plan& plan, const State& state, Workspace& workspace);

}  // namespace unlatch
