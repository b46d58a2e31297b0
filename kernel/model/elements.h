// Elements: the lists of a model that share one numbering, in its order. A new kind of element goes to the end: it
// moves no number of the others.
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

#include "unlatch/model.h"

namespace unlatch {

inline auto list_elements(const Model& model) {
  return std::tie(model.loads, model.point_springs, model.joint_springs, model.plane_torsions, model.contacts,
                  model.one_sided, model.frictions);
}

inline constexpr std::size_t kElementKinds = std::tuple_size_v<decltype(list_elements(std::declval<const Model&>()))>;

// Calls use(list) for each list in the order of the numbering.
template <class Use>
void for_each_element_list(const Model& model, const Use& use) {
  std::apply([&](const auto&... lists) { (use(lists), ...); }, list_elements(model));
}

}  // namespace unlatch
