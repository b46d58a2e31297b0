// Bodies of a model for its plan: with a law of their mass, flexible ones, markers.
#pragma once

#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

// Fills PlanData::bodies and what bends or burns of them; needs the tree.
void compile_bodies(const Model& model, PlanDraft& plan);

}  // namespace unlatch
