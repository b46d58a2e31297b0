// Groups of nodes that are computed side by side (blocks.h): which nodes share one, and in which order.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "kernel/plan/plan_data.h"

namespace unlatch {

// Two nodes of one kind may share a group.
struct NodeKind {
  bool leaf = false, has_joint = false, shared_axes = true, universal = false, by_rows = false;
  RowSet freedoms = 0, rows = 0, compliant = 0;
  std::uint8_t carried = 0;
  BodyKind body = BodyKind::kRigid;

  std::uint64_t get_key() const {
    return static_cast<std::uint64_t>(leaf) | static_cast<std::uint64_t>(has_joint) << 1 |
           static_cast<std::uint64_t>(shared_axes) << 3 | static_cast<std::uint64_t>(universal) << 4 |
           static_cast<std::uint64_t>(by_rows) << 5 | static_cast<std::uint64_t>(freedoms) << 8 |
           static_cast<std::uint64_t>(rows) << 16 | static_cast<std::uint64_t>(carried) << 24 |
           static_cast<std::uint64_t>(compliant) << 32 | static_cast<std::uint64_t>(body) << 40;
  }
};

constexpr int get_group_width(int count) { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(count))); }

// Nodes of one level and kind; lane i has node `first` + i.
struct NodeGroup {
  NodeKind kind;
  ParentLink link = ParentLink::kRoot;
  ChildSide side = ChildSide::kFollower;
  bool siblings_begin = false, siblings_end = false;  // as in Group
  int first = 0, count = 0;                           // into GroupedNodes::nodes

  int get_width() const { return get_group_width(count); }
};

// Lane of a group.
struct GroupLane {
  int group, lane;
};

struct GroupedNodes {
  std::vector<TreeNode> nodes;    // of the tree, by groups; parents before children
  std::vector<NodeGroup> groups;  // likewise
  std::vector<GroupLane> lanes;   // per node
};

// A draft whose nodes, groups and places do not change any more. Only lay_out_blocks() makes one, so that what keeps a
// node or a place cannot be compiled before.
class LaidOutDraft {
 public:
  PlanDraft& plan;

 private:
  friend LaidOutDraft lay_out_blocks(const Model& model, const GroupedNodes& grouped, PlanDraft& plan);
  explicit LaidOutDraft(PlanDraft& own_plan) : plan(own_plan) {}
};

// Orders the nodes of the tree by groups. `tree`: as compile_topology() returns it; `compliant`: per joint, axes with
// implicit springs. O(n log n) for sorting.
GroupedNodes group_nodes(const Model& model, const std::vector<TreeNode>& tree, const std::vector<RowSet>& compliant);

}  // namespace unlatch
