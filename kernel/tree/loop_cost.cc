#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

#include "kernel/plan/plan_data.h"
#include "unlatch/redundancy.h"

namespace unlatch {
namespace {

// Multiplications, half of the operations that kernel/solver/tree_sweeps.h counts, of a body and its joint.
constexpr std::int64_t kOfTreeBody = 275;

// The most rows that a joint can hold.
std::int64_t count_rows(const PlanData& plan, std::int32_t joint) {
  const std::int32_t first = plan.joints[at(joint)].first_mode;
  const std::size_t end =
      at(joint) + 1 < plan.joints.size() ? at(plan.joints[at(joint) + 1].first_mode) : plan.modes.size();
  int most = 0;
  for (std::size_t m = at(first); m < end; ++m) most = std::max(most, std::popcount(plan.modes[m]));
  return most;
}

// Each where it closes. In the terms of kernel/solver/loops/loop_clusters.h.
std::int64_t count_local(const PlanData& plan) {
  constexpr std::int64_t kSix = 6, kMove = 6;
  std::int64_t count = 0;
  std::vector<std::int64_t> rows;
  for (const LoopClosure& c : plan.closures) rows.push_back(count_rows(plan, c.joint));
  for (const ClusterNode& node : plan.cluster_nodes) {
    const auto freedoms = std::max<std::int64_t>(1, std::popcount(plan.groups[at(node.group)].freedoms));
    std::int64_t open = 0;
    for (int i = node.closing; i < node.slots; ++i) open += rows[at(plan.loop_slots[at(node.first_slot + i)].closure)];
    count += open * (freedoms * 3 * kSix + kMove);  // β, F − U β / d, what the loads meet; moved to the parent
    count += freedoms * open * (open + 1) / 2;      // Λ
  }
  for (std::size_t e = 0; e < plan.closures.size(); ++e) {
    const LoopClosure& c = plan.closures[e];
    std::int64_t left = 0;
    for (int i = 0; i < c.links; ++i) left += rows[at(plan.loop_links[at(c.first_link + i)].closure)];
    const std::int64_t own = rows[e];
    count += own * own * own / 3 + own * own * (left + kSix);  // the loop's own rows, and of the others beside them
    count += own * (left * (left + 1) / 2 + kSix * left);      // what they give to the loops that pass on
    count += own * kSix * (kSix + 1) / 2;                      // and to the body
  }
  return count;
}

// One dense matrix. In the terms of kernel/solver/loops/loop_rows.h; then the tree once more.
std::int64_t count_dense(const PlanData& plan) {
  const std::int64_t k = plan.loop_rows, nodes = static_cast<std::int64_t>(plan.loop_nodes.size());
  return k == 0 ? 0 : k * nodes * 18 + k * (k + 1) / 2 * nodes + k * k * k / 6 + kOfTreeBody * nodes / 2;
}

std::int32_t count_clusters(const PlanData& plan) {
  if (plan.closures.empty()) return plan.loops.empty() ? 0 : 1;
  std::vector<std::int32_t> group(plan.closures.size());
  std::iota(group.begin(), group.end(), 0);
  const auto find = [&](std::int32_t e) {
    while (group[at(e)] != e) e = group[at(e)] = group[at(group[at(e)])];
    return e;
  };
  auto clusters = static_cast<std::int32_t>(group.size());
  for (std::size_t e = 0; e < group.size(); ++e)
    for (int i = 0; i < plan.closures[e].links; ++i) {
      const std::int32_t a = find(static_cast<std::int32_t>(e)),
                         b = find(plan.loop_links[at(plan.closures[e].first_link + i)].closure);
      if (a == b) continue;
      group[at(a)] = b;
      --clusters;
    }
  return clusters;
}

}  // namespace

LoopCost calc_loop_cost(const Plan& owner) {
  const PlanData& plan = get_data(owner);
  return {count_clusters(plan), kOfTreeBody * static_cast<std::int64_t>(plan.nodes.size()),
          plan.closures.empty() ? count_dense(plan) : count_local(plan)};
}

}  // namespace unlatch
