// Numbers of elements in a plan: they are handed out in the order in which the lists are compiled, which must be that
// of kernel/model/elements.h.
#pragma once

#include "kernel/plan/plan_data.h"

namespace unlatch {

// The next number; `on`: at the start.
inline std::int32_t add_element(PlanData& plan, bool on) {
  plan.element_scales.push_back(on ? 1 : 0);
  return static_cast<std::int32_t>(plan.element_scales.size()) - 1;
}

}  // namespace unlatch
