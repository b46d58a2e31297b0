// The variables of a problem of synthesis: paths, bounds or catalogue, start.
#pragma once

#include <string>

#include "hil/language/yaml_reader.h"
#include "hil/synthesis/problem.h"

namespace unlatch::hil {

// Those without mistakes go to the problem.
void read_variables(YamlMap& top, DesignProblem& problem, Mistakes& mistakes);

// The SI unit of a dimension as the language writes it: "N", "kg m2 / s3".
std::string write_unit(const Dimension& dimension);

}  // namespace unlatch::hil
