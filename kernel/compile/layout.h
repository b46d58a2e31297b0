// The layout of a plan's blocks (blocks.h): which bodies lie side by side, and where.
#pragma once

#include "kernel/plan/plan_data.h"

namespace unlatch {

// Orders the nodes of the tree by groups, parents before children, and lays out the blocks. O(n log n) for sorting.
void lay_out_blocks(const Model& model, PlanData& plan);

}  // namespace unlatch
