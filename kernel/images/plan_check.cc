#include "kernel/images/plan_check.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "unlatch/model/contact_substeps.h"

namespace unlatch {

void PlanCheck::check_numbers() {
  const PlanOptions& options = plan_.options;
  require(std::isfinite(options.dt) && options.dt > 0);
  require(options.max_splits >= 1);
  require_kind(options.instruction_set, InstructionSet::k512);
  for (const bool* flag :
       {&plan_.rigid, &plan_.plain, &plan_.commanded_loads, &plan_.pair_forces, &plan_.solved_once,
        &plan_.commanded_events, &plan_.law_numbers.strict, &plan_.time_corners, &plan_.place_corners,
        &plan_.sought_corners, &plan_.environment.exists, &plan_.environment.has_air, &plan_.environment.planet.falling,
        &plan_.environment.planet.gradient_torque})
    require_flag(*flag);
  for (const std::int32_t count :
       {plan_.loop_rows, plan_.loop_columns, plan_.loop_load_rows, plan_.loop_modal_rows, plan_.ring_rows,
        plan_.cluster_blocks, plan_.cluster_numbers, plan_.block_numbers, plan_.modal_work, plan_.rotation_count,
        plan_.law_numbers.places, plan_.sensor_count, plan_.signal_count, plan_.guard_depth})
    require_count(count);
  if (!good_) return;
  require(plan_.rigid == (plan_.flexible.empty() && plan_.varying.empty()));
  require(plan_.plain == (plan_.rigid && !plan_.environment.exists));
  require(plan_.solved_once == (plan_.laws.empty() && plan_.frictions.empty() && plan_.rigid_pairs == 0));
  require(plan_.contact_substeps >= -kMaxContactRefinement && plan_.contact_substeps != -1 &&
          plan_.contact_substeps <= kMaxContactSubsteps);
  require(plan_.channel_count >= 0 && at(plan_.channel_count) == plan_.initial_commands.size());
  require_range(0, plan_.quantity_count, plan_.quantities.size());
  require_range(0, plan_.driven_coordinates, plan_.coordinates.size());
  const std::int64_t instants = std::int64_t{options.max_splits} + 2;
  constexpr std::int64_t kAuditNumbers = 128;  // more than an audit has
  require(instants <= std::numeric_limits<std::int32_t>::max());
  const auto guards = static_cast<std::int64_t>(plan_.events.size() + plan_.contact_pairs.size());
  require(guards == 0 || instants <= std::numeric_limits<std::int32_t>::max() / kAuditNumbers / guards);
}

// A joint's modes are those from its first one to the next joint's.
std::int32_t PlanCheck::count_modes(std::int32_t joint) const {
  const bool last = at(joint) + 1 == plan_.joints.size();
  const std::int32_t end =
      last ? static_cast<std::int32_t>(plan_.modes.size()) : plan_.joints[at(joint) + 1].first_mode;
  return end - plan_.joints[at(joint)].first_mode;
}

int PlanCheck::count_most_rows(std::int32_t joint) const {
  int most = 0;
  for (std::int32_t mode = 0; mode < count_modes(joint); ++mode)
    most = std::max(most, std::popcount(plan_.get_rows(joint, mode)));
  return most;
}

void PlanCheck::check_joints() {
  constexpr RowSet kAll = kPointRows | kRotationRows;
  for (const RowSet rows : plan_.modes) require((rows & ~kAll) == 0);
  for (const PlanJoint& joint : plan_.joints) {
    require_body_or_ground(joint.base);
    require_body(joint.follower);
    require_index(joint.first_mode, plan_.modes.size());
    require_flag(joint.universal);
    require((joint.non_tree == kNone) != (joint.child == kNone));
    require_optional(joint.non_tree, plan_.non_tree_joints.size());
    require_optional(joint.child, plan_.bodies.size());
    if (joint.child != kNone) {
      require_index(joint.group, plan_.groups.size());
      require(joint.child == joint.base || joint.child == joint.follower);
    }
  }
  if (!good_) return;
  for (std::size_t j = 0; j < plan_.joints.size(); ++j) {
    const std::int32_t count = count_modes(static_cast<std::int32_t>(j));
    require(count >= 1);
    require(plan_.joints[j].mode >= 0 && plan_.joints[j].mode < count);
  }
  for (std::size_t i = 0; i < plan_.non_tree_joints.size(); ++i) {
    const std::int32_t joint = plan_.non_tree_joints[i].joint;
    require_index(joint, plan_.joints.size());
    if (good_) require(plan_.joints[at(joint)].non_tree == static_cast<std::int32_t>(i));
  }
  for (std::size_t j = 0; j < plan_.joints.size() && good_; ++j)
    if (const std::int32_t own = plan_.joints[j].non_tree; own != kNone)
      require(plan_.non_tree_joints[at(own)].joint == static_cast<std::int32_t>(j));
}

void PlanCheck::check_tree() {
  require(plan_.nodes.size() == plan_.bodies.size());
  for (std::size_t k = 0; k < plan_.nodes.size(); ++k) {
    const TreeNode& node = plan_.nodes[k];
    require_body(node.body);
    require(node.parent >= kNone && node.parent < static_cast<std::int32_t>(k));
    require_flag(node.leaf);
    require_optional(node.joint, plan_.joints.size());
    if (good_ && node.joint != kNone) require(plan_.joints[at(node.joint)].child == node.body);
  }
  for (const PlanBody& body : plan_.bodies) {
    require_optional(body.varying, plan_.varying.size());
    require_optional(body.flexible, plan_.flexible.size());
  }
}

}  // namespace unlatch
