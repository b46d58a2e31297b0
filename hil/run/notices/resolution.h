// Resolution of a step: bounds on h·ω from the theory of Runge–Kutta methods (kernel/THEORY.md, 9), and the natural
// frequency of each spring in the modes that its structure can reach.
#pragma once

#include <string>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/frequencies.h"

namespace unlatch::hil {

// Bounds on h·ω of a motion, or h times a rate of decay. Up to kAccurate the error of the classical Runge–Kutta method
// is (h·ω)⁴/120, 1.3e-5 of each radian of the motion; beyond kStable an oscillation grows without bound.
inline constexpr double kAccurate = 0.2, kStable = 2.8;
// Bound beyond which a smooth motion, of a body, spring or mode, counts as unresolved, and what depends on it is no
// result: an error of 2e-4 of each radian.
inline constexpr double kUnresolvedSize = 0.4;
// Steps that a notice proposes are printed with three digits: this factor keeps rounding up from taking them too far.
inline constexpr double kRoundedDown = 0.995;

// A spring at the initial poses.
struct SpringResolution {
  int element = 0;                              // in the model's shared numbering
  bool implicit = false;                        // integrated implicitly
  double omega = 0, decay = 0;                  // rad/s, 1/s: in the modes at the start
  double largest_omega = 0, largest_decay = 0;  // over all relevant combinations of modes
  std::string where;  // modes of the largest value that differ from those at the start: "latch open, …"; or empty
  [[nodiscard]] double get_worst() const { return largest_omega > largest_decay ? largest_omega : largest_decay; }
};

// Resolutions of all springs. Fewer rows can only increase a spring's mobility, so only modes count whose rows include
// those of no other mode that events can set. If these leave more than 64 combinations, joints are varied one at a time
// about the combination with the fewest rows. O(n) for each spring and combination; allocates.
std::vector<SpringResolution> calc_resolutions(const Simulation& simulation);

// Mobilities at one-sided forces and frictions, in the simulation's modes and poses; allocates.
std::vector<ElementMobility> calc_mobilities(const Simulation& simulation);

// Modes of a joint that are active at the start or that some event sets, ascending.
std::vector<int> find_reachable_modes(const Model& model, int joint);

}  // namespace unlatch::hil
