// Decay rate of a motion under regularised friction, for judging the step: frictions in joints, and pushers, stops and
// cords that have friction. While it sticks, μ N v / √(v² + v_s²) is a damper of coefficient μ N / v_s.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/frequencies.h"

namespace unlatch::hil {

// Rate of decay of an element's motion by its friction, at one instant.
struct FrictionRate {
  int element = 0;   // in the model's shared numbering
  double decay = 0;  // 1/s: force of friction / √(v² + v_s²) · mobility; 0 while it does not act
};

// Returns true if some element has friction.
bool has_friction(const Model& model);
// Rates of all elements that have friction, at the simulation's state and its workspace. `mobilities`: from
// calc_mobilities(), in the present modes; they change with the poses, which is slow.
std::vector<FrictionRate> calc_friction_rates(const Simulation& simulation,
                                              std::span<const ElementMobility> mobilities);

// Reason why a step of h does not resolve the friction; empty if it does.
std::string describe_unresolved(const FrictionRate& rate, double h);

}  // namespace unlatch::hil
