// What the plan prepares for joints that close loops: which nodes their rows' wrenches pass on the way to the root, in
// which order, and where they lie meanwhile.
#pragma once

#include "unlatch/model.h"
#include "unlatch/plan.h"

namespace unlatch {

// Rows of Workspace::loop_loads behind the loads.
inline constexpr std::size_t kLoopScratch = 7;

// Needs the lanes. O(n) besides.
void compile_loops(const Model& model, Plan& plan);

}  // namespace unlatch
