// Rings: which joints of the tree each loop leads through, which loops share joints and so make a mesh, and by which
// stiffnesses redundant reactions are shared (kernel/solver/loops/redundant_rows.h).
#pragma once

#include <span>

#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

// `loop_nodes`: as compile_loop_nodes() returns them. O(loops · depth of the tree).
void compile_loop_paths(const Model& model, std::span<const LoopNode> loop_nodes, PlanDraft& plan);

}  // namespace unlatch
