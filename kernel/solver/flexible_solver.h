// The solver's part for flexible bodies: a body of 6 + m coordinates is a node between its markers; its modal
// coordinates are eliminated before it is added to its parent. Derivation: flexible_solver.cc. Cost O(m² (m + markers))
// a body.
#pragma once

#include "kernel/plan/evaluation.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

// Backward pass for a group of flexible bodies, their markers included; nothing for a group of markers. `factor`: block
// and load, else the load alone. Returns kNone, or the node whose pivot vanished.
int eliminate_flexible(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Group& group,
                       bool factor) noexcept;
// Forward pass.
void substitute_flexible(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Group& group) noexcept;

}  // namespace unlatch
