// Findings about a scenario before it runs, subject by subject: the parts of list_findings() (findings.h). Each appends
// to the list. `placed`: the scenario's model with its markers placed (place_markers()).
#pragma once

#include <vector>

#include "hil/run/findings/finding.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

// body_findings.cc: inertias that no body has; watched pairs that overlap at the start, and other bodies that do,
// among those that no joint, contact or watched pair allows to meet.
void add_inertia_findings(const Model& placed, std::vector<Finding>& findings);
void add_overlap_findings(const Scenario& scenario, std::vector<Finding>& findings);
void add_unwatched_overlap_findings(const Scenario& scenario, std::vector<Finding>& findings);

// joint_findings.cc: angles that begin at half a turn, points that do not meet.
void add_joint_findings(const Model& placed, std::vector<Finding>& findings);

// spring_findings.cc: forces between points that coincide; springs of joints that act on after these are set free.
void add_coincident_point_findings(const Model& placed, std::vector<Finding>& findings);
void add_freed_spring_findings(const Scenario& scenario, std::vector<Finding>& findings);

// event_findings.cc: events that cannot come, or that hold at the start already.
void add_event_findings(const Scenario& scenario, std::vector<Finding>& findings);

// step_findings.cc: what the step does not resolve, contacts that begin closed, loops that cost much.
void add_step_findings(const Scenario& scenario, const Simulation& simulation, std::vector<Finding>& findings);

// law_findings.cc: corners of tables that forces read, intervals of time and laws of time that the step passes over.
void add_law_findings(const Scenario& scenario, const Simulation& simulation, std::vector<Finding>& findings);

}  // namespace unlatch::hil
