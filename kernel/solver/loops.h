// Joints that close loops over the tree: k auxiliary rows, half a solve of the tree for all of them side by side
// (lane_loops.h), and a dense k×k matrix
//   Λ μ = c − W a₀,   Λ = W H⁻¹ Wᵀ,   a = a₀ + H⁻¹ Wᵀ μ,
// where row r of W is the pair of unit wrenches that the row puts on its two bodies and a₀ the tree's own solution. The
// tree's pattern is untouched; the cost is O(k n + k² p), p the pivots on the way from the loops to the root, and k³/6;
// a second solve has the rows' wrenches among its loads, so that the multipliers of the tree's joints come out with it.
// Rows that follow from the others (a planar four-bar in space, a Bricard linkage) show as vanishing pivots of Λ, which
// takes the most independent first; they are left out, get no multiplier, and are counted.
#pragma once

#include <limits>

#include "kernel/dispatch/lane_kernels.h"
#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// Of Workspace::loop_most: no limit.
inline constexpr std::int32_t kAllRows = std::numeric_limits<std::int32_t>::max();

// The factor of Λ for the active rows of plan.loops. Needs the tree's factor and the joints' frames.
// At most ws.loop_most rows count as independent: the stages of a step lie a little off the rows, so that redundant
// ones contradict each other there; how many are not redundant, the state tells from which the step starts.
void factor_loops(const Plan& plan, const State& state, Workspace& ws) noexcept;

// Accelerations and multipliers of tree and loops, with the latest factors, once the sweep's loads have gone to the
// root.
void substitute_with_loops(const Plan& plan, Workspace& ws, const Sweep& sweep) noexcept;

}  // namespace unlatch
