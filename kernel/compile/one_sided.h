// One-sided forces of a model for its plan.
#pragma once

#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

// Appends it to the plan. `coordinate`: of its joint, kNone between two points.
void compile_one_sided(const Model& model, const OneSided& force, std::int32_t element, std::int32_t coordinate,
                       PlanData& plan);

}  // namespace unlatch
