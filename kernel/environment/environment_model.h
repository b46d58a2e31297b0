// Environment of a model: its mistakes, and its part of a plan.
#pragma once

#include <vector>

#include "kernel/environment/environment.h"
#include "kernel/model/check.h"

namespace unlatch {

void validate_environment(const Model& model, ModelErrors& errors);

struct CompiledEnvironment {
  PlanEnvironment numbers;
  std::vector<AirLayer> layers;
  std::vector<AirKnot> air;
  std::vector<WindKnot> wind;
  std::vector<double> corners;  // altitudes of both, rising, m
};
CompiledEnvironment compile_environment(const Environment& environment);

}  // namespace unlatch
