#include "unlatch/plan/halved_plan.h"

#include <cstring>
#include <memory>

#include "kernel/plan/plan_data.h"

namespace unlatch {
namespace {

struct HalvedPlan {
  Plan whole;  // owner of the lists
  PlanData data;
};

}  // namespace

Plan halve_step(const Plan& plan) {
  auto halved = std::make_shared<HalvedPlan>(HalvedPlan{plan, get_data(plan)});
  halved->data.options.dt *= 0.5;
  halved->data.hash = ~halved->data.hash;  // another plan: states of one are not taken for those of the other
  halved->data.image = {};
  return Plan(std::shared_ptr<const PlanData>(halved, &halved->data));
}

void copy_to_halved(const State& from, const Plan& halved, const State& to) noexcept {
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
  to.header->plan_hash = halved.get_hash();
  to.header->tick *= 2;
}

}  // namespace unlatch
