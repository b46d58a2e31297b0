// The tree of a plan: its bodies and joints, and the blocks in which their numbers lie (blocks.h).
#pragma once

#include <cstdint>

#include "kernel/plan/lanes.h"
#include "kernel/plan/list_kinds.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

struct PlanBody {
  double mass;  // kg; 0 of a body with a mass law, a flexible body or a marker, whose mass is added separately
  BodyState initial;
  std::int32_t varying = kNone;   // into PlanData::varying
  std::int32_t flexible = kNone;  // into PlanData::flexible: of a flexible body, and of its markers
};

// Points and axes of a joint of the tree are in its group's JointConstants.
struct PlanJoint {
  Quat rotation_base, rotation_follower;  // rotation frame in each body's axes
  std::int32_t base, follower;            // bodies; base may be kGround
  std::int32_t first_mode;                // into PlanData::modes
  std::int32_t mode;                      // at first
  bool universal;
  std::int32_t child = kNone;     // of a joint of the tree: the body that it holds to its parent
  std::int32_t group = kNone;     // likewise: its group
  std::int32_t non_tree = kNone;  // of any other joint: its place in PlanData::non_tree_joints
  // Square roots of the stiffnesses that redundant reactions are shared by, see kernel/solver/loops/redundant_rows.h.
  double share = 1, turning_share = 1;  // of a point–plane row; of a rotation row, m
};

// A joint that is no edge of the tree: it closes a loop, or never holds.
struct PlanNonTreeJoint {
  std::int32_t joint;
  Vec3 point_base, point_follower;
  Mat3 axes, rotation_axes;  // joint frame and rotation frame, base axes
  Vec3 follower_y;           // y of the rotation frame, follower axes
};

// In PlanLists.
template <template <class> class List>
struct PlanTreeLists {
  List<TreeNode> nodes;
  List<PlanBody> bodies;
  List<PlanJoint> joints;
  List<RowSet> modes;
  List<PlanNonTreeJoint> non_tree_joints;

  RowSet get_rows(int joint, std::int64_t mode) const {
    return modes[static_cast<std::size_t>(joints[static_cast<std::size_t>(joint)].first_mode + mode)];
  }

  // Calls use(list…) with each list: that of one name of all `lists`. A new list goes here as well.
  template <class Use, class... Lists>
  static constexpr void for_each(const Use& use, Lists&... lists) {
    use(lists.nodes...);
    use(lists.bodies...);
    use(lists.joints...);
    use(lists.modes...);
    use(lists.non_tree_joints...);
  }
};

// Blocks, see blocks.h; in PlanLists.
template <template <class> class List>
struct PlanBlockLists {
  List<BodyEight> eights;
  List<Group> groups;                // parents before children
  List<std::int32_t> inner_groups;   // whose SubtreeBlocks no child begins, see Group::begins
  List<std::int32_t> lane_nodes;     // per lane: its node, or kNone
  List<Place> lane_parents;          // per lane: where its parent is
  List<Place> places;                // per body
  List<NumberColumn> multipliers;    // per joint: the six of them
  List<NumberColumn> accelerations;  // per body: the six of it
  List<double> body_constants;       // BodyConstants of each block of eight
  List<double> joint_constants;      // JointConstants, and RotationConstants if needed, of each group
  List<double> solver_constants;     // SolverConstants of each group

  // Calls use(list…) with each list: that of one name of all `lists`. A new list goes here as well.
  template <class Use, class... Lists>
  static constexpr void for_each(const Use& use, Lists&... lists) {
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
  }
};

}  // namespace unlatch
