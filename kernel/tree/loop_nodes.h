// Preparation of joints that close loops: the nodes that their rows' wrenches pass on the way to the root, in
// which order, and where they lie meanwhile.
#pragma once

#include <span>

#include "kernel/tree/groups.h"

namespace unlatch {

// Returns PlanData::loop_nodes. O(n).
std::span<const LoopNode> compile_loop_nodes(const Model& model, const LaidOutDraft& draft);

}  // namespace unlatch
