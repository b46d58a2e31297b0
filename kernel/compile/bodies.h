// Bodies of a model for its plan: with a law of their mass, flexible ones, markers.
#pragma once

#include <span>

#include "kernel/plan/plan_data.h"
#include "unlatch/model.h"

namespace unlatch {

// A draft with all bodies and the auxiliary states of theirs, behind which elements put their own.
struct DraftWithBodies {
  PlanDraft& plan;
};

// Fills PlanData::bodies and what bends or burns of them. `nodes`: the tree's; those of bodies that bend or burn cease
// to be leaves.
DraftWithBodies compile_bodies(const Model& model, std::span<TreeNode> nodes, PlanDraft& plan);

}  // namespace unlatch
