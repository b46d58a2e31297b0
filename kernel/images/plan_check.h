// PlanCheck: every number of a plan that says where something is, how many there are or of which kind they are points
// inside of what the plan has. So a step never leaves its memory, whatever the image holds; whether its masses and
// lengths make sense is not looked at. The lists themselves lie inside of the image already (open_image()).
//
// Linear in the size of the plan, but for searches in its groups; no memory of its own.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>

#include "kernel/plan/plan_data.h"

namespace unlatch {

class PlanCheck {
 public:
  explicit PlanCheck(const PlanData& plan) : plan_(plan) {}

  bool is_good() {
    // Each part relies on those before it.
    for (void (PlanCheck::*part)() :
         {&PlanCheck::check_numbers, &PlanCheck::check_joints, &PlanCheck::check_tree, &PlanCheck::check_eights,
          &PlanCheck::check_groups, &PlanCheck::check_places, &PlanCheck::check_bodies, &PlanCheck::check_loops,
          &PlanCheck::check_clusters, &PlanCheck::check_coordinates, &PlanCheck::check_loads, &PlanCheck::check_springs,
          &PlanCheck::check_shapes, &PlanCheck::check_one_sided, &PlanCheck::check_air, &PlanCheck::check_tables,
          &PlanCheck::check_laws, &PlanCheck::check_quantities, &PlanCheck::check_events}) {
      (this->*part)();
      if (!good_) return false;
    }
    return true;
  }

 private:
  // --- plan_check.cc: numbers, joints, the tree
  void check_numbers();
  void check_joints();
  void check_tree();
  // --- check_blocks.cc: how the blocks lie, bodies that bend or burn
  void check_eights();
  void check_groups();
  void check_places();
  void check_bodies();
  void check_group(std::size_t g);
  void check_lane(std::size_t g, int lane);
  void check_parents(std::size_t g);
  void check_modes(const Group& group, std::int32_t joint);
  // --- check_loops.cc
  void check_loops();
  void check_clusters();
  void check_loop_node(const LoopNode& node);
  void check_closure(const LoopClosure& closure);
  void check_cluster_node(const ClusterNode& node);
  // --- check_elements.cc
  void check_coordinates();
  void check_loads();
  void check_springs();
  void check_shapes();
  void check_rigid_contacts();
  void check_one_sided();
  void check_air();
  // --- check_laws.cc
  void check_tables();
  void check_laws();
  void check_law(const PlanLaw& law);
  // --- check_events.cc
  void check_quantities();
  void check_events();
  void check_subject(const PlanQuantity& own);
  void check_condition(const PlanCondition& c);
  void check_action(const Action& action);
  void check_guard(const PlanEvent& event);

  // --- What all of them ask
  void require(bool holds) { good_ = good_ && holds; }
  void require_index(std::int64_t i, std::size_t count) { require(is_index(i, count)); }
  void require_optional(std::int64_t i, std::size_t count) { require(i == kNone || is_index(i, count)); }
  void require_body(std::int32_t body) { require_index(body, plan_.bodies.size()); }
  void require_body_or_ground(std::int32_t body) { require_optional(body, plan_.bodies.size()); }
  void require_element(std::int32_t element) { require_index(element, plan_.element_scales.size()); }
  void require_channel(std::int32_t channel) { require_optional(channel, plan_.initial_commands.size()); }
  // `count` items from `first` on are in a list of `size`.
  void require_range(std::int64_t first, std::int64_t count, std::size_t size) {
    require(first >= 0 && count >= 0 && first + count <= static_cast<std::int64_t>(size));
  }
  // A bool whose byte is neither 0 nor 1 has no value.
  void require_flag(const bool& flag) {
    std::uint8_t byte;
    std::memcpy(&byte, &flag, 1);
    require(byte <= 1);
  }
  template <class Enum>
  void require_kind(const Enum& kind, Enum last) {
    require(get_number(kind) >= 0 && get_number(kind) <= get_number(last));
  }
  // So many numbers fit into memory beside others: no size of the workspace overflows.
  void require_count(std::int64_t count) {
    constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max() / sizeof(double) / 64;
    require(count >= 0 && static_cast<std::uint64_t>(count) <= kMost &&
            count <= std::numeric_limits<std::int32_t>::max());
  }

  static bool is_same(const Place& a, const Place& b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }
  static bool is_index(std::int64_t i, std::size_t count) { return i >= 0 && i < static_cast<std::int64_t>(count); }
  template <class Enum>
  static std::int64_t get_number(const Enum& kind) {
    std::underlying_type_t<Enum> number;
    std::memcpy(&number, &kind, sizeof(number));
    return static_cast<std::int64_t>(number);
  }
  std::int32_t count_modes(std::int32_t joint) const;
  int count_most_rows(std::int32_t joint) const;
  // The group that a lane of the solver's blocks belongs to; kNone if there is none.
  std::int32_t find_group(const Place& place) const;
  bool is_leaf(std::int32_t body) const { return plan_.groups[at(find_group(plan_.places[at(body)]))].leaf; }
  bool is_tree_joint(std::int32_t joint) const {
    return is_index(joint, plan_.joints.size()) && plan_.joints[at(joint)].non_tree == kNone;
  }

  const PlanData& plan_;
  bool good_ = true;
};

}  // namespace unlatch
