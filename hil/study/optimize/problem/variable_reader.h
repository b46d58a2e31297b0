// Variables of an optimisation problem: paths, bounds or catalogue, start.
#pragma once

#include "hil/scenario/yaml/yaml_reader.h"
#include "hil/study/optimize/problem/problem.h"

namespace unlatch::hil {

// Reads variables; those without mistakes are added to the problem.
void read_variables(YamlMap& top, OptimizeProblem& problem, Mistakes& mistakes);

}  // namespace unlatch::hil
