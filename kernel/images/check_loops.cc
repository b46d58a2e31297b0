// Closed loops, by one dense matrix or eliminated where they close.

#include "kernel/images/plan_check.h"
#include "kernel/tree/loop_storage.h"

namespace unlatch {
namespace {

constexpr int kSpatial = 6;  // numbers of a wrench

std::int64_t count_pairs(std::int64_t links) { return links * (links + 1) / 2; }

}  // namespace

void PlanCheck::check_loops() {
  require(plan_.loops.size() <= plan_.non_tree_joints.size());
  std::int64_t rows = 0;
  for (const std::int32_t joint : plan_.loops) {
    require_index(joint, plan_.joints.size());
    require(good_ && !is_tree_joint(joint));
    if (good_) rows += count_most_rows(joint);
  }
  require(rows == plan_.loop_rows && plan_.loop_columns % kEight == 0 && plan_.loop_columns >= plan_.loop_rows);
  rows = 0;
  for (const std::int32_t joint : plan_.ring_joints) {
    require(is_tree_joint(joint));
    if (good_) rows += count_most_rows(joint);
  }
  require(rows == plan_.ring_rows && plan_.loop_modal_rows <= plan_.loop_load_rows);
  if (plan_.closures.empty()) {
    const std::int64_t all = std::int64_t{plan_.loop_rows} + plan_.ring_rows;
    require_count(all * all);
    require_count(std::int64_t{plan_.loop_rows} * plan_.loop_columns);
    require_count(std::int64_t{plan_.loop_load_rows} * plan_.loop_columns);
  }
  for (const LoopEnd& end : plan_.loop_ends) {
    require_index(end.loop, plan_.loops.size());
    require_flag(end.follower);
  }
  for (const LoopNode& node : plan_.loop_nodes) check_loop_node(node);
  require(plan_.loop_paths.size() == plan_.loops.size());
  for (const LoopPath& path : plan_.loop_paths) {
    require(path.first <= path.base_first && path.base_first <= path.end);
    require_range(path.first, std::int64_t{path.end} - path.first, plan_.path_nodes.size());
    require_index(path.mesh, plan_.meshes.size());
  }
  for (const PathNode& node : plan_.path_nodes) {
    require_index(node.loop_node, plan_.loop_nodes.size());
    require_optional(node.ring_joint, plan_.ring_joints.size());
  }
  for (const LoopMesh& mesh : plan_.meshes) require_range(mesh.first, mesh.count, plan_.mesh_joints.size());
  for (const std::int32_t joint : plan_.mesh_joints) require_index(joint, plan_.joints.size());
}

void PlanCheck::check_loop_node(const LoopNode& node) {
  require_flag(node.opens);
  require_index(node.node, plan_.nodes.size());
  require_index(node.group, plan_.groups.size());
  require_range(node.loads, kSpatial, at(plan_.loop_load_rows));
  if (node.parent_loads != kNone) require_range(node.parent_loads, kSpatial, at(plan_.loop_load_rows));
  require_range(node.first_end, node.ends, plan_.loop_ends.size());
  if (!good_) return;
  const std::int32_t body = plan_.nodes[at(node.node)].body;
  require(is_same(node.place, plan_.places[at(body)]) && node.group == find_group(node.place));
  if (!good_) return;
  const Group& group = plan_.groups[at(node.group)];
  require((node.parent_loads == kNone) == (plan_.nodes[at(node.node)].parent == kNone));
  if (group.kind == BodyKind::kRigid) return require(node.parent_loads == kNone || group.has_joint);
  const std::int32_t flexible = plan_.bodies[at(body)].flexible;
  const PlanFlexible& own = plan_.flexible[at(flexible)];
  require_range(node.modal, own.modes, at(plan_.loop_modal_rows));
  if (group.kind == BodyKind::kFlexible) return require(node.parent_loads == kNone || own.inboard != kNone);
  require_index(node.marker, plan_.markers.size());
  if (good_) require(plan_.markers[at(node.marker)].flexible == flexible);
}

void PlanCheck::check_clusters() {
  require_range(0, plan_.first_at_ground, plan_.closures.size() + 1);
  if (plan_.closures.empty()) return;
  require(plan_.closures.size() == plan_.loops.size());
  require(at(plan_.cluster_blocks) == plan_.closures.size() + plan_.loop_links.size());
  require_count(std::int64_t{plan_.cluster_blocks} * kBlockNumbers);
  require_count(static_cast<std::int64_t>(plan_.loop_slots.size()) * kBlockNumbers);
  for (const std::int32_t block : plan_.loop_pairs) require_index(block, at(plan_.cluster_blocks));
  for (const LoopSlot& slot : plan_.loop_slots) {
    require_index(slot.closure, plan_.closures.size());
    require_optional(slot.parent, plan_.loop_slots.size());
    require_range(slot.numbers, SlotRows::kWrenches * kEight, at(plan_.cluster_numbers));
  }
  for (const LoopLink& link : plan_.loop_links) {
    require_index(link.closure, plan_.closures.size());
    require_index(link.block, at(plan_.cluster_blocks));
    require_optional(link.slot, plan_.loop_slots.size());
  }
  if (!good_) return;
  for (const LoopClosure& closure : plan_.closures) check_closure(closure);
  for (const ClusterNode& node : plan_.cluster_nodes) check_cluster_node(node);
  require(plan_.group_clusters.size() == plan_.groups.size() + 1);
  std::int32_t before = 0;
  for (const std::int32_t first : plan_.group_clusters) {
    require(first >= before);
    require_range(0, first, plan_.cluster_nodes.size());
    before = first;
  }
}

void PlanCheck::check_closure(const LoopClosure& closure) {
  require_index(closure.loop, plan_.loops.size());
  require(good_ && closure.joint == plan_.loops[at(closure.loop)]);
  if (!good_) return;
  require(closure.non_tree == plan_.joints[at(closure.joint)].non_tree);
  for (const std::int32_t slot : {closure.on_follower, closure.on_base, closure.slot})
    require_optional(slot, plan_.loop_slots.size());
  require_optional(closure.node, plan_.cluster_nodes.size());
  require((closure.node == kNone) == (closure.slot == kNone));
  require_index(closure.block, at(plan_.cluster_blocks));
  require_range(closure.first_link, closure.links, plan_.loop_links.size());
  require_range(closure.first_pair, count_pairs(closure.links), plan_.loop_pairs.size());
  if (!good_) return;
  for (std::int32_t i = 0; i < closure.links; ++i)
    require(closure.slot == kNone || plan_.loop_links[at(closure.first_link + i)].slot != kNone);
}

void PlanCheck::check_cluster_node(const ClusterNode& node) {
  require_index(node.node, plan_.nodes.size());
  require_index(node.group, plan_.groups.size());
  require_range(node.first_slot, node.slots, plan_.loop_slots.size());
  require(node.closing >= 0 && node.closing <= node.slots);
  if (!good_) return;
  require_range(node.first_pair, count_pairs(std::int64_t{node.slots} - node.closing), plan_.loop_pairs.size());
  const std::int32_t body = plan_.nodes[at(node.node)].body;
  require(is_same(node.place, plan_.places[at(body)]) && node.group == find_group(node.place));
  if (!good_) return;
  const Group& group = plan_.groups[at(node.group)];
  require(group.kind == BodyKind::kRigid && (node.closing == 0 || !group.leaf));
  for (std::int32_t i = 0; i < node.slots; ++i) {
    const LoopSlot& slot = plan_.loop_slots[at(node.first_slot + i)];
    const LoopClosure& closure = plan_.closures[at(slot.closure)];
    if (i < node.closing)
      require(closure.slot != kNone);
    else
      require_range(slot.numbers, SlotRows(group).count() * kEight, at(plan_.cluster_numbers));
  }
}

}  // namespace unlatch
