// Quantities of a model for its plan: those that it names, and those that its conditions and sensors read.
#pragma once

#include "kernel/plan/plan_data.h"
#include "unlatch/quantities.h"

namespace unlatch {

// Appends a quantity to PlanData::quantities; returns its place. link_readers() of compile_plan.cc finds the
// coordinate that it reads.
std::int32_t add_quantity(const Quantity& quantity, PlanDraft& plan);

// A draft whose first quantities are the model's; conditions and sensors add theirs behind them.
struct DraftWithQuantities {
  PlanDraft& plan;
};
DraftWithQuantities compile_quantities(const Model& model, PlanDraft& plan);

}  // namespace unlatch
