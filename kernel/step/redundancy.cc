#include "unlatch/redundancy.h"

#include <bit>

#include "kernel/joints/kinematics.h"
#include "kernel/solver/loops/loop_rows.h"

namespace unlatch {

std::vector<RedundantRows> list_redundant_rows(const Plan& owner, const State& state, const Workspace& workspace) {
  const PlanData& plan = get_data(owner);
  const Evaluation& ev = get_data(workspace).kept.evaluation;
  std::vector<std::int32_t> redundant(plan.meshes.size(), 0), nearly(plan.meshes.size(), 0);
  for (std::size_t e = 0; e < plan.closures.size(); ++e) {
    const std::size_t mesh = at(plan.loop_paths[at(plan.closures[e].loop)].mesh);
    redundant[mesh] += ev.closures[e].count - ev.closures[e].rank;
    nearly[mesh] += count_nearly_redundant_rows(plan, ev, e);
  }
  for (int r = ev.loop_count - ev.loop_redundant; plan.closures.empty() && r < ev.loop_count; ++r) {
    const LoopRow& row = get_pivot_row(ev, r);
    const std::size_t mesh = at(plan.loop_paths[at(row.loop)].mesh);
    ++redundant[mesh];
    nearly[mesh] += is_nearly_redundant(row.entry, get_loop_matrix(plan, ev)(r, r)) ? 1 : 0;
  }
  std::vector<RedundantRows> all;
  for (std::size_t m = 0; m < plan.meshes.size(); ++m) {
    if (redundant[m] == 0) continue;
    const auto first = plan.mesh_joints.begin() + plan.meshes[m].first;
    RedundantRows& rows = all.emplace_back();
    rows.joints.assign(first, first + plan.meshes[m].count);
    rows.redundant = redundant[m];
    rows.nearly = nearly[m];
    for (const std::int32_t joint : rows.joints) rows.rows += std::popcount(get_active_rows(plan, state, joint));
  }
  return all;
}

}  // namespace unlatch
