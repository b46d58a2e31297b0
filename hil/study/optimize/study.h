// Study of a result's neighbourhood: differences, slices through it, and the cost of each active constraint. It runs on
// top of the search's budget: at most as many runs and as many seconds again, and at most kStudyRuns.
#pragma once

#include "hil/study/optimize/search.h"

namespace unlatch::hil {

constexpr std::int64_t kStudyRuns = 1000;

// Fills constraints, sensitivities and slices. Items beyond the runs stay empty.
void study_result(const OptimizeProblem& problem, OptimizeEvaluations& evaluations, const OptimizeMerit& merit,
                  OptimizeResult& result);

}  // namespace unlatch::hil
