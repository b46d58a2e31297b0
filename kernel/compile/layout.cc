#include "kernel/compile/layout.h"

#include <algorithm>

#include "kernel/model/from_eigen.h"
#include "kernel/plan/plan_data.h"
#include "kernel/tree/group_parts.h"

namespace unlatch {
namespace {

class Layout {
 public:
  Layout(const Model& model, const GroupedNodes& grouped, PlanDraft& plan)
      : model_(model), plan_(plan), lanes_(grouped.lanes), loaded_(model.bodies.size(), false) {
    plan_.nodes = grouped.nodes;
    for (const PlanLoad& load : plan.loads)
      if (!load.apart) loaded_[at(load.body)] = true;
  }

  void compile(const std::vector<NodeGroup>& groups) {
    for (const NodeGroup& group : groups) place_group(group);
    join_blocks();
    place_parents();
    find_beginnings();
    place_joints();
    place_springs();
  }

 private:
  void place_group(const NodeGroup& nodes) {
    Group group{};
    group.first = static_cast<std::int32_t>(plan_.lane_nodes.size());
    group.width = static_cast<std::uint8_t>(nodes.get_width());
    group.count = static_cast<std::uint8_t>(nodes.count);
    group.link = nodes.link;
    group.kind = nodes.kind.body;
    group.side = nodes.side;
    group.siblings_begin = nodes.siblings_begin;
    group.siblings_end = nodes.siblings_end;
    group.leaf = nodes.kind.leaf;
    group.has_joint = nodes.kind.has_joint;
    group.shared_axes = nodes.kind.shared_axes;
    group.universal = nodes.kind.universal;
    group.may_be_by_rows = nodes.kind.by_rows || group.count < group.width;
    group.freedoms = nodes.kind.freedoms;
    group.rows = nodes.kind.rows;
    group.compliant = nodes.kind.compliant;
    group.carried = nodes.kind.carried;
    for (int lane = 0; lane < group.width; ++lane)
      plan_.lane_nodes.push_back(lane < nodes.count ? nodes.first + lane : kNone);
    const auto first = plan_.nodes.begin() + nodes.first;
    place_bodies(group,
                 std::any_of(first, first + nodes.count, [&](const TreeNode& n) { return loaded_[at(n.body)]; }));
    lay_out(group);
    plan_.groups.push_back(group);
  }

  // Neighbouring lanes for the group's bodies: in the latest block of eight that narrow groups share or, if none are
  // left there, in a new one. Its SharedBlock lies before the blocks of its first group.
  void place_bodies(Group& group, bool loaded) {
    const auto find_lane = [&](const BodyEight& eight) {
      for (int lane = 0; lane < kEight; lane += group.width)
        if ((eight.used >> lane & ((1 << group.width) - 1)) == 0) return lane;
      return kNone;
    };
    int lane = group.width < kEight && open_ != kNone ? find_lane(plan_.eights[at(open_)]) : kNone;
    int number = open_;
    if (lane == kNone) {
      lane = 0;
      number = static_cast<int>(plan_.eights.size());
      plan_.eights.push_back({0, used_, number * kNumbers<BodyConstants> * kEight, 0, 0, false});
      used_ += kNumbers<SharedBlock> * kEight;
      if (group.width < kEight) open_ = number;
    }
    BodyEight& eight = plan_.eights[at(number)];
    eight.used = static_cast<std::uint8_t>(eight.used | ((1 << group.width) - 1) << lane);
    eight.filled = static_cast<std::uint8_t>(eight.filled | ((1 << group.count) - 1) << lane);
    eight.loaded = eight.loaded || loaded;
    eight_of_.push_back(number);
    group.body = lane;  // join_blocks() adds the position of its block of eight
    group.shared = eight.shared + lane;
  }

  // The group's blocks of joints and of the solver, with their optional parts.
  void lay_out(Group& group) {
    const JointNumbers numbers = place_parts(group);
    const int subtree = group.leaf ? 0 : kSubtreeBeforeSolver;
    group.solver = used_ + subtree * group.width;
    used_ += align((subtree + group.size) * group.width);
    group.joint = joined_;
    group.constants = constants_;
    if (!group.has_joint) return;
    joined_ += align(numbers.joint * group.width);
    constants_ += align(numbers.constants * group.width);
  }
  // Blocks begin at cache lines.
  static std::int32_t align(int numbers) { return (numbers + kLineNumbers - 1) / kLineNumbers * kLineNumbers; }

  // Bodies come first, then joints, then all that the solver reads.
  void join_blocks() {
    std::int32_t bodies = 0;
    for (BodyEight& eight : plan_.eights) {
      eight.body = bodies;
      bodies += eight.count_body_numbers();
    }
    const std::int32_t solver = bodies + joined_;
    for (BodyEight& eight : plan_.eights) eight.shared += solver;
    for (std::size_t g = 0; g < plan_.groups.size(); ++g) {
      Group& group = plan_.groups[g];
      group.body += plan_.eights[at(eight_of_[g])].body;
      group.shared += solver;
      group.joint += bodies;
      group.solver += solver;
    }
    used_ += solver;
  }

  // Groups that begin the blocks of their parents: the first in the backward pass, if they add to all of them at once.
  // Blocks of flexible bodies and of bodies that lose mass begin with their own inertia.
  void find_beginnings() {
    std::vector<bool> added(plan_.groups.size(), false), begun(plan_.groups.size(), false);
    const auto get_parent_group = [&](const Group& group, int lane) {
      return lanes_[at(plan_.nodes[at(plan_.lane_nodes[at(group.first + lane)])].parent)].group;
    };
    for (std::size_t g = plan_.groups.size(); g-- > 0;) {
      Group& group = plan_.groups[g];
      group.begins = kNone;
      if (group.link == ParentLink::kRoot) continue;
      const int parent = get_parent_group(group, 0);
      const Group& parents = plan_.groups[at(parent)];
      const bool four = group.width == 4 && group.siblings_begin && group.siblings_end && parents.width == 1;
      if ((four || group.link == ParentLink::kContiguous) && !added[at(parent)] && group.kind == BodyKind::kRigid &&
          is_plain(parents)) {
        group.begins = parent;
        begun[at(parent)] = true;
      }
      for (int lane = 0; lane < group.count; ++lane) added[at(get_parent_group(group, lane))] = true;
    }
    for (std::size_t g = 0; g < plan_.groups.size(); ++g)
      if (!plan_.groups[g].leaf && !begun[g]) plan_.inner_groups.push_back(static_cast<std::int32_t>(g));
  }
  bool is_plain(const Group& group) const {
    for (int lane = 0; lane < group.count; ++lane)
      if (plan_.bodies[at(plan_.nodes[at(plan_.lane_nodes[at(group.first + lane)])].body)].varying != kNone)
        return false;
    return group.kind == BodyKind::kRigid;
  }

  Place get_place(const GroupLane& at_lane) const {
    return unlatch::get_place(plan_.groups[at(at_lane.group)], at_lane.lane);
  }

  // Each lane's parent; an empty lane has its neighbour's.
  void place_parents() {
    for (const Group& group : plan_.groups)
      for (int lane = 0; lane < group.width; ++lane) {
        const int node = plan_.lane_nodes[at(group.first + std::min<int>(lane, group.count - 1))];
        const int parent = plan_.nodes[at(node)].parent;
        plan_.lane_parents.push_back(parent == kNone ? Place{} : get_place(lanes_[at(parent)]));
      }
  }

  // Multipliers of non-tree joints are behind the blocks.
  void place_joints() {
    plan_.places.resize(model_.bodies.size());
    plan_.multipliers.assign(model_.joints.size(), {kNone, 1});
    for (std::size_t k = 0; k < plan_.nodes.size(); ++k) {
      const TreeNode& node = plan_.nodes[k];
      const Place place = plan_.places[at(node.body)] = get_place(lanes_[k]);
      plan_.accelerations.resize(model_.bodies.size());
      plan_.accelerations[at(node.body)] = {find_number(place, &SharedLane::acceleration).at, kEight};
      if (node.joint == kNone) continue;
      plan_.multipliers[at(node.joint)] = {find_number(place, &SolverLane::multipliers).at, place.width};
      plan_.joints[at(node.joint)].child = node.body;
      plan_.joints[at(node.joint)].group = lanes_[k].group;
    }
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      PlanJoint& own = plan_.joints[j];
      if (own.child != kNone) continue;
      own.non_tree = static_cast<std::int32_t>(plan_.non_tree_joints.size());
      const Joint& joint = model_.joints[j];
      plan_.non_tree_joints.push_back(
          {static_cast<std::int32_t>(j), to_vec(joint.point_base), to_vec(joint.point_follower), to_mat(joint.axes),
           to_mat(joint.rotation_axes.value_or(joint.axes)), rotation_matrix(own.rotation_follower).y});
      plan_.multipliers[j] = {used_, 1};
      used_ += kRows;
    }
    plan_.block_numbers = used_;
    // A group without a joint points to the first constants, which exist even if no group has a joint.
    plan_.joint_constants.assign(std::max(at(constants_), std::size_t{kEight}), 0.0);
  }

  // Each implicit spring's pivot and the acceleration along it.
  void place_springs() {
    for (PlanCompliant& c : plan_.compliant) {
      const JointSpring& spring = model_.joint_springs[at(c.spring)];
      const PlanJoint& joint = plan_.joints[at(spring.joint)];
      const Group& group = plan_.groups[at(joint.group)];
      const Place& place = plan_.places[at(joint.child)];
      c.pivot = find_pivot(group, place, spring.axis);
      c.acceleration = find_acceleration(group, place, spring.axis);
      c.side = joint.child == joint.follower ? 1 : -1;
    }
  }

  const Model& model_;
  PlanDraft& plan_;
  const std::vector<GroupLane>& lanes_;                 // per node
  std::vector<bool> loaded_;                            // per body
  std::vector<int> eight_of_;                           // per group
  int open_ = kNone;                                    // eight that narrow groups go to
  std::int32_t used_ = 0, joined_ = 0, constants_ = 0;  // used_: by the solver's blocks
};

}  // namespace

LaidOutDraft lay_out_blocks(const Model& model, const GroupedNodes& grouped, PlanDraft& plan) {
  Layout(model, grouped, plan).compile(grouped.groups);
  return LaidOutDraft(plan);
}

}  // namespace unlatch
