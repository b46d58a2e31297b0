// for_each_list: all lists of a plan in the one order in which images hold them.
#pragma once

#include <cstddef>

#include "kernel/plan/plan_data.h"

namespace unlatch {

// Calls use(list…) with each list: that of one name of all `lists`.
template <class Use, class... Lists>
constexpr void for_each_list(const Use& use, Lists&... lists) {
  PlanTreeLists<FixedList>::for_each(use, lists...);
  PlanLoopLists<FixedList>::for_each(use, lists...);
  PlanBlockLists<FixedList>::for_each(use, lists...);
  PlanBodyLists<FixedList>::for_each(use, lists...);
  PlanElementLists<FixedList>::for_each(use, lists...);
  PlanEventLists<FixedList>::for_each(use, lists...);
}

// A list that only shows how many there are.
template <class T>
struct CountedList {
  using value_type = T;
  char one;
};
constexpr std::size_t count_lists() {
  const PlanLists<CountedList> lists{};
  std::size_t count = 0;
  for_each_list([&](const auto&) { ++count; }, lists);
  return count;
}
inline constexpr std::size_t kPlanLists = count_lists();
static_assert(sizeof(PlanLists<CountedList>) == kPlanLists, "each list of PlanLists is in its for_each()");

// The draft's lists as they are now, until they grow.
inline PlanData get_view(const PlanDraft& draft) {
  PlanData view;
  static_cast<PlanNumbers&>(view) = draft;
  for_each_list([](auto& fixed, const auto& growing) { fixed = growing; }, view, draft);
  return view;
}

}  // namespace unlatch
