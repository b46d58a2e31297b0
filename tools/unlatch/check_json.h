// Results of `unlatch check` as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"

namespace unlatch::tools {

// The plan of a valid scenario: bodies, joints with their modes, elimination order, elements, sizes. Overwrites the
// simulation's workspace.
nlohmann::ordered_json build_plan_json(const hil::Scenario& scenario, hil::Simulation& simulation);
// Every mistake, with its place.
nlohmann::ordered_json build_mistakes_json(const hil::ScenarioError& error);

}  // namespace unlatch::tools
