// Results of `unlatch check` as JSON, written as report.h says.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"
#include "tools/unlatch/check/check_cost.h"
#include "unlatch/redundancy.h"

namespace unlatch::tools {

// The plan of a valid scenario: bodies, joints with their modes, elimination order, elements, sizes. Overwrites the
// simulation's workspace. `redundant`: at the start.
struct PlanJsonParts {
  bool quantities = false;  // lists them too
  CostOptions cost;         // the bound of a step, if it has a target
};
void write_plan_json(const hil::Scenario& scenario, hil::Simulation& simulation,
                     const std::vector<RedundantRows>& redundant, const PlanJsonParts& parts,
                     const std::string& target);
// Every mistake, with its place.
void write_mistakes_json(const hil::ScenarioError& error, const std::string& target);

// Requirements, and which of them no run can evaluate (check_requirements.cc).
void print_requirement_checks(const hil::Scenario& scenario);
nlohmann::ordered_json build_requirement_checks(const hil::Scenario& scenario);

}  // namespace unlatch::tools
