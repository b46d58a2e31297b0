// Findings about a scenario before it runs: facts that may surprise an engineer.
#pragma once

#include <vector>

#include "hil/forecast/finding.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"

namespace unlatch::hil {

// Lists all findings. Leaves `simulation` unchanged; allocates and may take as long as some hundred steps.
std::vector<Finding> find_surprises(const Scenario& scenario, const Simulation& simulation);

}  // namespace unlatch::hil
