// Surprises in a scenario, subject by subject: the parts of find_surprises() (forecast.h). Each appends what it finds.
// `placed`: the scenario's model with its markers placed (place_markers()).
#pragma once

#include <vector>

#include "hil/forecast/finding.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"

namespace unlatch::hil {

// body_surprises.cc: inertias that no body has; watched pairs that overlap at the start, and other bodies that do,
// among those that no joint, contact or watched pair allows to meet.
void find_plates(const Model& placed, std::vector<Finding>& findings);
void find_overlaps(const Scenario& scenario, std::vector<Finding>& findings);
void find_intruders(const Scenario& scenario, std::vector<Finding>& findings);

// joint_surprises.cc: angles that begin at half a turn, points that do not meet.
void find_joint_surprises(const Model& placed, std::vector<Finding>& findings);

// spring_surprises.cc: forces between points that coincide; springs of joints that act on after these are set free.
void find_directionless(const Model& placed, std::vector<Finding>& findings);
void find_free_springs(const Scenario& scenario, std::vector<Finding>& findings);

// event_surprises.cc: events that cannot come, or that hold at the start already.
void find_event_surprises(const Scenario& scenario, std::vector<Finding>& findings);

// step_surprises.cc: what the step does not resolve, and contacts that begin closed.
void find_step_surprises(const Scenario& scenario, const Simulation& simulation, std::vector<Finding>& findings);

}  // namespace unlatch::hil
