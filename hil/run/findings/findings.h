// Findings about a scenario before it runs: facts that an engineer would want to know.
#pragma once

#include <vector>

#include "hil/run/findings/finding.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

// Lists all findings. Leaves `simulation` unchanged; allocates and may take as long as some hundred steps.
std::vector<Finding> list_findings(const Scenario& scenario, const Simulation& simulation);

}  // namespace unlatch::hil
