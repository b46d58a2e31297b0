#include "kernel/solver/tree_solver.h"

#include <cmath>

#include "kernel/plan/lane_access.h"
#include "kernel/solver/loops.h"

namespace unlatch {

int factor_and_solve(const Plan& plan, const State& state, Workspace& ws, const Sweep& sweep) noexcept {
  const LaneKernels& kernels = *plan.kernels;
  if (const int node = kernels.factor_and_reduce(plan, ws, sweep); node != kNone) return node;
  if (plan.loops.empty()) {
    kernels.substitute(plan, ws, sweep);
  } else {
    factor_loops(plan, state, ws);
    substitute_with_loops(plan, ws, sweep);
  }
  return kNone;
}

void solve(const Plan& plan, Workspace& ws, const Sweep& sweep) noexcept {
  plan.kernels->reduce(plan, ws, sweep);
  if (plan.loops.empty())
    plan.kernels->substitute(plan, ws, sweep);
  else
    substitute_with_loops(plan, ws, sweep);
}

bool has_finite_block(const Plan& plan, const Workspace& ws, int node) noexcept {
  const PlanNode& n = plan.nodes[static_cast<std::size_t>(node)];
  const LaneSlot slot = plan.body_slots[static_cast<std::size_t>(n.body)];
  const auto sum_rows = [&](auto first, int count) {
    double sum = 0;
    for (int row = 0; row < count; ++row) sum += ws.lanes[static_cast<std::size_t>(find(slot, first + row))];
    return sum;
  };
  double sum = sum_rows(kInertia, 6);
  if (!n.leaf) sum += sum_rows(kBlock, 21);
  if (n.joint != kNone) sum += sum_rows(kArmChild, 6);
  return std::isfinite(sum);
}

}  // namespace unlatch
