// Surfaces of a plan: groups of shapes, and the mobility of the bodies that carry them.
#pragma once

#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

void compile_surfaces(const Model& model, PlanDraft& plan);

}  // namespace unlatch
