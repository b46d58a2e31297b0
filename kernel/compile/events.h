// Events of a model for its plan: guards in postfix order, actions.
#pragma once

#include "kernel/compile/quantities.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

void compile_events(const Model& model, const DraftWithQuantities& draft);

// True if some guard reads the step's inputs.
bool has_commanded_guards(const PlanDraft& plan);

}  // namespace unlatch
