// The problem in the form that the libraries need: variables 0 … 1, scaled objectives and constraints.
#pragma once

#include <vector>

#include "hil/study/optimize/merit.h"

namespace unlatch::hil {

std::vector<std::size_t> list_continuous(const OptimizeProblem& problem);

// Value of a variable at a place 0 … 1 between its bounds.
double place(const OptimizeVariable& variable, double x);

// Scales the problem. x: 0 … 1 for the variables in `list`; the others as in `base`. `shifts`: of the constraints,
// relative to their limits. Keeps references to all arguments but `base` and `list`.
ScaledProblem make_scaled(const OptimizeProblem& problem, OptimizeEvaluations& evaluations, const OptimizeMerit& merit,
                          std::vector<std::size_t> list, OptimizePoint base, const std::vector<double>& shifts);

}  // namespace unlatch::hil
