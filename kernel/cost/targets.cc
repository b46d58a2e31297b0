#include "kernel/cost/measured.h"

namespace unlatch {

std::vector<const CostTarget*> list_cost_targets() {
  std::vector<const CostTarget*> all;
  for (const cost::Measured* measured : cost::list_measured()) all.push_back(&measured->target);
  return all;
}

const CostTarget* find_cost_target(const std::string& name) {
  for (const CostTarget* target : list_cost_targets())
    if (name == target->name) return target;
  return nullptr;
}

}  // namespace unlatch
