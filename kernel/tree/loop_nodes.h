// Preparation of joints that close loops: the nodes that their rows' wrenches pass on the way to the root, in
// which order, and where they lie meanwhile.
#pragma once

#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

// Needs the blocks. O(n) besides.
void compile_loops(const Model& model, PlanDraft& plan);

}  // namespace unlatch
