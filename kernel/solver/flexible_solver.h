// The solver's part for flexible bodies: a body of 6 + m coordinates is a node between its markers; its modal
// coordinates are eliminated before it meets its parent. Derivation: flexible_solver.cc. Cost O(m² (m + markers)) a
// body.
#pragma once

#include "kernel/plan/evaluation.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

// Backward pass for a group of flexible bodies; nothing for one of markers, whose bodies do it. `factor`: block and
// load, else the load alone. Returns kNone, or the node whose pivot vanished.
int eliminate_flexible(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Group& group,
                       bool factor) noexcept;
// Forward pass.
void substitute_flexible(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Group& group) noexcept;

}  // namespace unlatch
