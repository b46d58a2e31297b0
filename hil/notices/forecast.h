// Findings about a scenario before it runs: its springs at the start, and facts that may surprise an engineer.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"

namespace unlatch::hil {

// A spring, pusher or torsion spring at the start.
struct SpringStart {
  std::string name, kind;  // "spring", "pusher", "joint spring", "torsion"
  bool on = false;
  bool angular = false;  // length, stroke in rad and force in N m
  double length = 0;     // m or rad: between the points, or the joint's coordinate
  double force = 0;      // N or N m on the follower along the length, without dampers
  double energy = 0;     // J stored
  double stroke = 0;     // m or rad to the place without force
};
std::vector<SpringStart> list_springs(const Scenario& scenario);

// A fact to check; the run follows the scenario all the same. `where`: a key of Scenario::marks, or empty.
struct Finding {
  std::string name;  // branch, start, never, overlap, points, modes, direction, free_spring, inertia,
                     // contact, friction, step, outputs, trivial
  std::string where, text;
};
// Lists all findings. Leaves `simulation` unchanged; allocates and may take as long as some hundred steps.
std::vector<Finding> find_surprises(const Scenario& scenario, const Simulation& simulation);

}  // namespace unlatch::hil
