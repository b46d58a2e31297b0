// Findings about the scenario of a problem before it is searched: as it stands, and at corners of the bounds.
#pragma once

#include <vector>

#include "hil/study/campaign/campaign_findings.h"
#include "hil/study/optimize/problem/problem.h"

namespace unlatch::hil {

// Findings of the scenario as it stands, then those that kFindingCorners corners of the bounds add: the start with all
// variables at their lower ends (of a catalogue the first entry), all at their upper ends, and mixed ones.
std::vector<CampaignFinding> list_problem_findings(const OptimizeProblem& problem);

}  // namespace unlatch::hil
