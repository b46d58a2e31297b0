// Constants of the blocks: BodyConstants, JointConstants, RotationConstants and SolverConstants (blocks.h).
#pragma once

#include "kernel/plan/plan_data.h"

namespace unlatch {

// Needs the layout of the groups.
void fill_constants(const Model& model, PlanDraft& plan);

}  // namespace unlatch
