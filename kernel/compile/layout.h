// The layout of a plan's blocks (blocks.h): where in memory the numbers of each group and body are.
#pragma once

#include "kernel/tree/groups.h"

namespace unlatch {

// Takes over the nodes in their groups' order, and lays out the blocks. O(n).
LaidOutDraft lay_out_blocks(const Model& model, const GroupedNodes& grouped, PlanDraft& plan);

}  // namespace unlatch
