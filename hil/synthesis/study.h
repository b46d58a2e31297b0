// The surroundings of a result: differences, slices through it, and for each active constraint what it
// costs. Runs on top of the search's budget: at most as many and as many seconds again, and at most kStudyRuns.
#pragma once

#include "hil/synthesis/search.h"

namespace unlatch::hil {

constexpr std::int64_t kStudyRuns = 1000;

// Fills constraints, sensitivities and slices. What the runs do not suffice for stays empty.
void study_result(const DesignProblem& problem, DesignEvaluations& evaluations, const DesignMerit& merit,
                  DesignResult& result);

}  // namespace unlatch::hil
