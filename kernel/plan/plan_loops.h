// Closed loops of a plan: what the two ways of eliminating them read, and how redundant reactions are split.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernel/plan/lanes.h"
#include "kernel/plan/list_kinds.h"

namespace unlatch {

// A node that the wrenches of loops pass on their way to the root, see loop_nodes.h and
// kernel/solver/loops/loop_columns.h.
struct LoopNode {
  std::int32_t node, group;
  Place place;                   // of its body
  std::int32_t loads;            // row of Evaluation::loop_loads where those at its body begin
  std::int32_t parent_loads;     // and those at its parent's; the same if it is the first to come there; kNone: a root
  std::int32_t first_end, ends;  // of loops at its body: into PlanData::loop_ends
  std::int32_t modal;            // row where the modal loads of its flexible body begin
  std::int32_t marker;           // into PlanData::markers, of a marker
  bool opens;                    // nothing comes to it from outboard
};
// Rows of Evaluation::loop_replies.
inline constexpr std::size_t kLoopReplies = 7;

// One side of a joint that closes a loop.
struct LoopEnd {
  std::int32_t loop;  // into PlanData::loops
  bool follower;
};

// The nodes that a loop's wrenches pass from its two bodies to where the ways meet, that one excluded, see
// loop_paths.h: into PlanData::path_nodes.
struct LoopPath {
  std::int32_t first, base_first, end;  // from the follower; from the base; behind both
  std::int32_t mesh;                    // into PlanData::meshes
};
struct PathNode {
  std::int32_t loop_node;   // into PlanData::loop_nodes
  std::int32_t ring_joint;  // into PlanData::ring_joints; kNone: a flexible body or one of its markers
};
// Joints of loops that share joints: their reactions depend on each other.
struct LoopMesh {
  std::int32_t first, count;  // into PlanData::mesh_joints
};

// Loops that are eliminated where they close, see kernel/tree/loop_clusters.h and kernel/solver/loops/loop_clusters.h.
// In order of elimination. A block has the rows of one loop and, in kEight lanes each, those of another.
struct LoopClosure {
  std::int32_t loop;                  // into PlanData::loops
  std::int32_t joint, non_tree;       // that closes it; its place in PlanData::non_tree_joints
  std::int32_t on_follower, on_base;  // slots at these bodies; kNone: the ground
  std::int32_t node;                  // into PlanData::cluster_nodes, where it closes; kNone: at the ground
  std::int32_t slot;                  // there, into PlanData::loop_slots
  std::int32_t block;                 // its own, into the blocks of Evaluation::cluster_matrix
  std::int32_t first_link, links;     // later loops that it is coupled with: into PlanData::loop_links
  std::int32_t first_pair;            // into PlanData::loop_pairs: blocks of pairs of these, i ≤ j, by rows
};
struct LoopLink {
  std::int32_t closure, block;
  std::int32_t slot;  // of that loop where this one closes; kNone: at the ground
};
// One loop at one node: its rows' wrenches there.
struct LoopSlot {
  std::int32_t closure;
  std::int32_t parent;   // the slot at the parent; kNone beyond a root
  std::int32_t begins;   // 1: the first to reach that slot, where nothing is yet; else 0
  std::int32_t numbers;  // into Evaluation::cluster_columns
};
struct ClusterNode {
  std::int32_t node, group;
  Place place;
  std::int32_t first_slot, closing, slots;  // of these, the first close here, the others pass on
  std::int32_t first_pair;                  // into PlanData::loop_pairs: of those that pass on
};
// Rows of a block of Λ, and numbers of it.
inline constexpr int kBlockNumbers = kRows * kEight;

// In PlanLists.
template <template <class> class List>
struct PlanLoopLists {
  List<std::int32_t> loops;   // joints that close a loop over the tree
  List<LoopNode> loop_nodes;  // children before parents
  List<LoopEnd> loop_ends;
  List<LoopPath> loop_paths;  // per loop
  List<PathNode> path_nodes;
  List<std::int32_t> ring_joints;  // joints of the tree that lie in loops
  List<LoopMesh> meshes;
  List<std::int32_t> mesh_joints;  // of each mesh, in the order of the model

  // loops that are eliminated where they close; empty if all are by one dense matrix
  List<LoopClosure> closures;
  List<LoopLink> loop_links;
  List<LoopSlot> loop_slots;
  List<std::int32_t> loop_pairs;
  List<ClusterNode> cluster_nodes;    // parents before children
  List<std::int32_t> group_clusters;  // per group: its first cluster node; and the end

  // Calls use(list…) with each list: that of one name of all `lists`. A new list goes here as well.
  template <class Use, class... Lists>
  static constexpr void for_each(const Use& use, Lists&... lists) {
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
  }
};

}  // namespace unlatch
