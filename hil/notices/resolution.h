// Resolution of a step: bounds on h·ω from the theory of Runge–Kutta (kernel/THEORY.md, 9), and how fast each spring
// swings in the modes that its structure can come to.
#pragma once

#include <string>
#include <vector>

#include "hil/simulation/simulation.h"
#include "unlatch/frequencies.h"

namespace unlatch::hil {

// h·ω of a motion, or h times a rate of decay. To kAccurate the classical Runge–Kutta method errs by (h·ω)⁴/120, 1.3e-5
// of each radian that the motion goes on; beyond kStable an oscillation grows without bound.
inline constexpr double kAccurate = 0.2, kStable = 2.8;

// A spring at the initial poses.
struct SpringResolution {
  int element = 0;                              // in the model's shared numbering
  bool implicit = false;                        // integrated implicitly
  double omega = 0, decay = 0;                  // rad/s, 1/s: in the modes at the start
  double largest_omega = 0, largest_decay = 0;  // of all combinations of modes that matter
  std::string where;  // the modes of the largest that differ from those at the start: "latch open, …"; empty
  [[nodiscard]] double get_worst() const { return largest_omega > largest_decay ? largest_omega : largest_decay; }
};

// Of every spring. A row less leaves a spring nothing but more mobility, so only modes count whose rows include those
// of no other mode that events can set; where these leave more than 64 combinations, joints are varied one at a time
// about the one with the fewest rows. O(n) for each spring and combination; allocates.
std::vector<SpringResolution> calc_resolutions(const Simulation& simulation);

// Of one-sided forces and frictions, in the simulation's modes and poses; allocates.
std::vector<ElementMobility> calc_mobilities(const Simulation& simulation);

// Modes of a joint that hold at the start or that some event sets, ascending.
std::vector<int> find_reachable_modes(const Model& model, int joint);

}  // namespace unlatch::hil
