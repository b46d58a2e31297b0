// Springs of a scenario as they begin.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"

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
// All springs of a scenario: point springs, springs of joints, torsions, one-sided forces.
std::vector<SpringStart> list_springs(const Scenario& scenario);

// One of them. `model`: with its markers placed (place_markers()).
SpringStart start_point_spring(const Model& model, const PointSpring& spring);
SpringStart start_one_sided(const Model& model, const OneSided& force);

}  // namespace unlatch::hil
