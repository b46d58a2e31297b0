// How fast regularised friction stops a motion, for judging the step: of frictions in joints, and of pushers, stops and
// cords that have friction. Where it sticks, μ N v / √(v² + v_s²) is a damper of stiffness μ N / v_s.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hil/simulation/simulation.h"
#include "unlatch/frequencies.h"

namespace unlatch::hil {

// Rate of decay of an element's motion by its friction, at one instant.
struct FrictionRate {
  int element = 0;   // in the model's shared numbering
  double decay = 0;  // 1/s: force of friction / √(v² + v_s²) · mobility; 0 while it does not act
};

// Some element has friction.
bool has_friction(const Model& model);
// Of all that have friction, at the simulation's state and its workspace. `mobilities`: of calc_mobilities(), in the
// present modes; they change with the poses, which is slow.
std::vector<FrictionRate> calc_friction_rates(const Simulation& simulation,
                                              std::span<const ElementMobility> mobilities);

// Why a step of h does not resolve it; empty: it does.
std::string describe_unresolved(const FrictionRate& rate, double h);

}  // namespace unlatch::hil
