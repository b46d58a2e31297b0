// The problem as the libraries see it: variables 0 … 1, scaled objectives and constraints.
#pragma once

#include <vector>

#include "hil/synthesis/merit.h"

namespace unlatch::hil {

std::vector<std::size_t> list_continuous(const DesignProblem& problem);

// x: 0 … 1 of the variables in `list`; the others as in `base`. `shifts`: of the constraints, parts of their limits.
// All but `base` and `list` are referred to.
ScaledProblem make_scaled(const DesignProblem& problem, DesignEvaluations& evaluations, const DesignMerit& merit,
                          std::vector<std::size_t> list, DesignPoint base, const std::vector<double>& shifts);

}  // namespace unlatch::hil
