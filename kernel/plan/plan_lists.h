// for_each_list: all lists of a plan in the one order in which images hold them.
#pragma once

#include <cstddef>

#include "kernel/plan/plan_data.h"

namespace unlatch {

// Calls use(list…) with each list: that of one name of all `lists`.
template <class Use, class... Lists>
constexpr void for_each_list(const Use& use, Lists&... lists) {
  use(lists.nodes...);
  use(lists.bodies...);
  use(lists.joints...);
  use(lists.modes...);
  use(lists.non_tree_joints...);
  use(lists.loops...);
  use(lists.loop_nodes...);
  use(lists.loop_ends...);
  use(lists.loop_paths...);
  use(lists.path_nodes...);
  use(lists.ring_joints...);
  use(lists.meshes...);
  use(lists.mesh_joints...);
  use(lists.closures...);
  use(lists.loop_links...);
  use(lists.loop_slots...);
  use(lists.loop_pairs...);
  use(lists.cluster_nodes...);
  use(lists.group_clusters...);
  use(lists.eights...);
  use(lists.groups...);
  use(lists.inner_groups...);
  use(lists.lane_nodes...);
  use(lists.lane_parents...);
  use(lists.places...);
  use(lists.multipliers...);
  use(lists.accelerations...);
  use(lists.body_constants...);
  use(lists.joint_constants...);
  use(lists.solver_constants...);
  use(lists.varying...);
  use(lists.mass_knots...);
  use(lists.flexible...);
  use(lists.markers...);
  use(lists.modal...);
  use(lists.initial_auxiliary...);
  use(lists.coordinates...);
  use(lists.loads...);
  use(lists.external_loads...);
  use(lists.point_springs...);
  use(lists.joint_springs...);
  use(lists.compliant...);
  use(lists.compliant_axes...);
  use(lists.plane_torsions...);
  use(lists.shapes...);
  use(lists.shape_parts...);
  use(lists.hull_points...);
  use(lists.profile_points...);
  use(lists.contacts...);
  use(lists.contact_pairs...);
  use(lists.one_sided...);
  use(lists.drums...);
  use(lists.travels...);
  use(lists.travel_forces...);
  use(lists.frictions...);
  use(lists.aerodynamics...);
  use(lists.aero_terms...);
  use(lists.air_layers...);
  use(lists.air_knots...);
  use(lists.wind_knots...);
  use(lists.profiles...);
  use(lists.knots...);
  use(lists.harmonics...);
  use(lists.laws.list...);
  use(lists.laws.steps...);
  use(lists.laws.tables...);
  use(lists.laws.axes...);
  use(lists.laws.numbers...);
  use(lists.laws.buckets...);
  use(lists.laws.order...);
  use(lists.laws.operands...);
  use(lists.laws.loads...);
  use(lists.element_scales...);
  use(lists.conditions...);
  use(lists.actions...);
  use(lists.impulses...);
  use(lists.events...);
  use(lists.repeating_events...);
  use(lists.timed_events...);
  use(lists.quantities...);
  use(lists.sensors...);
  use(lists.initial_commands...);
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
static_assert(sizeof(PlanLists<CountedList>) == kPlanLists, "for_each_list() has every list of PlanLists");

// The draft's lists as they are now, until they grow.
inline PlanData get_view(const PlanDraft& draft) {
  PlanData view;
  static_cast<PlanNumbers&>(view) = draft;
  for_each_list([](auto& fixed, const auto& growing) { fixed = growing; }, view, draft);
  return view;
}

}  // namespace unlatch
