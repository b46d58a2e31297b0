#include "kernel/compile/layout.h"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

#include "kernel/model/from_eigen.h"
#include "kernel/plan/plan_data.h"

namespace unlatch {
namespace {

constexpr int kWidest = 8;
// A parent with so many children of one kind gets groups of its own for them.
constexpr int kFewestSiblings = 4;

// Two nodes of one kind may share a group.
struct Kind {
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

BodyKind find_body_kind(const Model& model, const TreeNode& node) {
  if (model.bodies[at(node.body)].flexible) return BodyKind::kFlexible;
  const bool outboard = model.bodies[at(node.body)].marker && node.joint == kNone && node.parent != kNone;
  return outboard ? BodyKind::kMarker : BodyKind::kRigid;
}

Kind find_kind(const Model& model, const PlanData& plan, const TreeNode& node) {
  Kind kind;
  kind.leaf = node.leaf;
  kind.body = find_body_kind(model, node);
  if (node.joint == kNone) {
    kind.by_rows = true;
    return kind;
  }
  kind.compliant = plan.compliant_axes[at(node.joint)];
  const Joint& joint = model.joints[at(node.joint)];
  kind.has_joint = true;
  kind.universal = joint.universal;
  kind.shared_axes = !joint.rotation_axes.has_value() && !joint.universal;
  for (const JointMode& mode : joint.modes) {
    const bool by_freedoms = is_by_freedoms(mode.rows, kind.compliant);
    if (!by_freedoms) kind.by_rows = true;
    if (by_freedoms)
      kind.freedoms = static_cast<RowSet>(kind.freedoms | (~mode.rows & (kPointRows | kRotationRows)));
    else
      kind.rows = static_cast<RowSet>(kind.rows | mode.rows);
    kind.carried = static_cast<std::uint8_t>(kind.carried | get_carried_axes(mode.rows));
  }
  return kind;
}

// A node on its way to its place.
struct Candidate {
  int node;    // as the topology numbered it
  int parent;  // in the new order
  int tree;    // number of its root
  std::uint64_t key;
  int rank;  // among its parent's children of this kind
};

class Layout {
 public:
  Layout(const Model& model, PlanData& plan)
      : model_(model), plan_(plan), old_(std::exchange(plan.nodes, {})), loaded_(model.bodies.size(), false) {
    for (const PlanLoad& load : plan.loads)
      if (!load.world) loaded_[at(load.body)] = true;
  }

  void compile() {
    std::vector<int> level_of(old_.size(), 0), placed(old_.size(), kNone);
    for (std::size_t k = 0; k < old_.size(); ++k) {
      const int parent = old_[k].parent;
      if (parent != kNone) level_of[k] = level_of[at(parent)] + 1;
      tree_of_.push_back(parent == kNone ? trees_++ : tree_of_[at(parent)]);
    }
    // The topology goes level by level, so each level is one stretch of it.
    plan_.nodes.reserve(old_.size());
    for (std::size_t begin = 0; begin < old_.size();) {
      std::size_t end = begin;
      while (end < old_.size() && level_of[end] == level_of[begin]) ++end;
      place_level(begin, end, placed);
      begin = end;
    }
    join_blocks();
    place_parents();
    find_beginnings();
    place_joints();
    place_springs();
  }

 private:
  struct GroupLane {
    int group, lane;
  };

  void place_level(std::size_t begin, std::size_t end, std::vector<int>& placed) {
    std::vector<Candidate> level;
    for (std::size_t k = begin; k < end; ++k) {
      const int parent = old_[k].parent == kNone ? kNone : placed[at(old_[k].parent)];
      level.push_back({static_cast<int>(k), parent, tree_of_[k], find_kind(model_, plan_, old_[k]).get_key(), 0});
    }
    const auto sort = [&](auto order) {
      std::sort(level.begin(), level.end(), [&](const Candidate& a, const Candidate& b) {
        const auto x = order(a), y = order(b);
        return x != y ? x < y : a.node < b.node;
      });
    };
    // Ranks need children of one parent and kind together; the groups need equal kinds and ranks together.
    sort([](const Candidate& c) { return std::pair(c.key, c.parent); });
    for (std::size_t i = 1; i < level.size(); ++i)
      if (level[i].key == level[i - 1].key && level[i].parent == level[i - 1].parent)
        level[i].rank = level[i - 1].rank + 1;
    std::vector<Candidate> siblings = take_siblings(level);
    sort([](const Candidate& c) { return std::tuple(c.key, c.rank, c.parent); });
    for (std::size_t i = 0; i < siblings.size();) i += place_siblings(siblings, i, placed);
    for (std::size_t i = 0; i < level.size();) i = place_kind(level, i, placed);
  }

  // Takes those children out of the level that are many enough, of one parent and kind, for groups of their own. Other
  // trees do not count: a tree is summed in one order, whatever is computed beside it.
  std::vector<Candidate> take_siblings(std::vector<Candidate>& level) const {
    std::vector<Candidate> siblings, others;
    std::vector<std::size_t> of_kind(at(trees_), 0);  // per tree
    for (std::size_t i = 0; i < level.size();) {
      std::size_t kind_end = i;
      for (; kind_end < level.size() && level[kind_end].key == level[i].key; ++kind_end)
        ++of_kind[at(level[kind_end].tree)];
      const std::size_t kind_begin = i;
      while (i < kind_end) {
        std::size_t end = i;
        while (end < kind_end && level[end].parent == level[i].parent) ++end;
        const std::size_t count = end - i;
        const bool many = level[i].parent != kNone && count >= kFewestSiblings &&
                          (count >= kWidest || 2 * count > of_kind[at(level[i].tree)]);
        std::vector<Candidate>& to = many ? siblings : others;
        to.insert(to.end(), level.begin() + static_cast<std::ptrdiff_t>(i),
                  level.begin() + static_cast<std::ptrdiff_t>(end));
        i = end;
      }
      for (std::size_t k = kind_begin; k < kind_end; ++k) of_kind[at(level[k].tree)] = 0;
    }
    level = std::move(others);
    return siblings;
  }

  std::size_t place_siblings(const std::vector<Candidate>& siblings, std::size_t begin, std::vector<int>& placed) {
    std::size_t end = begin;
    while (end < siblings.size() && siblings[end].key == siblings[begin].key &&
           siblings[end].parent == siblings[begin].parent)
      ++end;
    // From the leaves to the root the last group comes first, and is to be full: what is left over goes to the front.
    const std::size_t over = (end - begin) % kWidest, first = over == 0 || end - begin < kWidest ? end - begin : over;
    for (std::size_t i = begin, count = std::min<std::size_t>(first, kWidest); i < end; i += count, count = kWidest) {
      place_group(&siblings[i], count, ParentLink::kSiblings, placed);
      plan_.groups.back().siblings_end = i == begin;
      plan_.groups.back().siblings_begin = i + count == end;
    }
    return end - begin;
  }

  // Nodes of one kind: `count` of them from `first` on become a group.
  struct Chunk {
    std::size_t first, count;
    ParentLink link;
  };

  // The groups of one kind; returns where it ends. From the leaves to the root the last group comes first: so that a
  // parent's children add to it by rising rank, within a group and from group to group, the first ranks go to the back.
  std::size_t place_kind(const std::vector<Candidate>& level, std::size_t begin, std::vector<int>& placed) {
    std::size_t end = begin;
    while (end < level.size() && level[end].key == level[begin].key) ++end;
    std::vector<Chunk> chunks;
    for (std::size_t i = begin; i < end; i += chunks.back().count) chunks.push_back(find_chunk(level, i, end));
    for (std::size_t i = chunks.size(); i-- > 0;)
      place_group(&level[chunks[i].first], chunks[i].count, chunks[i].link, placed);
    return end;
  }

  // The next group of a kind that ends at `end`: neighbours of the parents' lanes if that makes a good part of a group.
  Chunk find_chunk(const std::vector<Candidate>& level, std::size_t begin, std::size_t end) const {
    const std::size_t kin = std::min(end, begin + kWidest), count = kin - begin;
    if (level[begin].parent == kNone) return {begin, count, ParentLink::kRoot};
    const std::size_t neighbours = count_neighbours(level, begin, kin);
    if (neighbours == count || neighbours >= 4) return {begin, neighbours, ParentLink::kContiguous};
    return {begin, count, ParentLink::kGather};
  }

  // Number of nodes from `begin` on whose parents are neighbouring lanes of one group, with room for empty lanes behind
  // them.
  std::size_t count_neighbours(const std::vector<Candidate>& level, std::size_t begin, std::size_t end) const {
    const GroupLane first = lanes_[at(level[begin].parent)];
    const int width = plan_.groups[at(first.group)].width;
    std::size_t count = 1;
    while (begin + count < end) {
      const GroupLane next = lanes_[at(level[begin + count].parent)];
      if (next.group != first.group || next.lane != first.lane + static_cast<int>(count)) break;
      ++count;
    }
    return first.lane == 0 && get_width(count) == width ? count : 0;
  }

  static int get_width(std::size_t count) { return static_cast<int>(std::bit_ceil(count)); }

  void place_group(const Candidate* members, std::size_t count, ParentLink link, std::vector<int>& placed) {
    const Kind kind = find_kind(model_, plan_, old_[at(members[0].node)]);
    Group group{};
    group.first = static_cast<std::int32_t>(plan_.lane_nodes.size());
    group.width = static_cast<std::uint8_t>(get_width(count));
    group.count = static_cast<std::uint8_t>(count);
    group.link = link;
    group.leaf = kind.leaf;
    group.has_joint = kind.has_joint;
    group.side = find_side(members, count);
    group.shared_axes = kind.shared_axes;
    group.universal = kind.universal;
    group.may_be_by_rows = kind.by_rows || count < group.width;
    group.freedoms = kind.freedoms;
    group.rows = kind.rows;
    group.carried = kind.carried;
    group.compliant = kind.compliant;
    group.kind = kind.body;
    const bool loaded =
        std::any_of(members, members + count, [&](const Candidate& c) { return loaded_[at(old_[at(c.node)].body)]; });
    place_bodies(group, loaded);
    lay_out(group);
    for (std::size_t lane = 0; lane < group.width; ++lane) {
      plan_.lane_nodes.push_back(kNone);
      if (lane >= count) continue;
      const Candidate& member = members[lane];
      placed[at(member.node)] = plan_.lane_nodes.back() = static_cast<std::int32_t>(plan_.nodes.size());
      plan_.nodes.push_back(old_[at(member.node)]);
      plan_.nodes.back().parent = member.parent;
      lanes_.push_back({static_cast<int>(plan_.groups.size()), static_cast<int>(lane)});
    }
    // Empty lanes of a contiguous group lie beside the parents that are no parents of theirs, and give them nothing.
    plan_.groups.push_back(group);
  }

  ChildSide find_side(const Candidate* members, std::size_t count) const {
    const auto is_base = [&](const Candidate& c) { return old_[at(c.node)].side < 0; };
    if (std::none_of(members, members + count, is_base)) return ChildSide::kFollower;
    return static_cast<int>(count) == get_width(count) && std::all_of(members, members + count, is_base)
               ? ChildSide::kBase
               : ChildSide::kMixed;
  }

  Place get_place(const GroupLane& at_lane) const {
    return unlatch::get_place(plan_.groups[at(at_lane.group)], at_lane.lane);
  }

  // Each implicit spring's pivot and the acceleration along it.
  void place_springs() {
    for (PlanCompliant& c : plan_.compliant) {
      const JointSpring& spring = model_.joint_springs[at(c.spring)];
      const PlanJoint& joint = plan_.joints[at(spring.joint)];
      const Group& group = plan_.groups[at(joint.group)];
      const Place& place = plan_.places[at(joint.child)];
      c.pivot = find_pivot(group, place, spring.axis);
      c.acceleration = find_beta(group, place, spring.axis);
      c.side = joint.child == joint.follower ? 1 : -1;
    }
  }

  // Neighbouring lanes for the group's bodies, in the latest block of eight of narrow groups or, if none are left
  // there, in a new one. Its SharedBlock lies before the blocks of its first group.
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
    group.body = lane;  // the rest once the bodies' blocks are laid out
    group.shared = eight.shared + lane;
  }

  // The group's blocks of joints and of the solver, with their optional parts.
  void lay_out(Group& group) {
    int numbers = group.has_joint ? kNumbers<SolverBlock> : 0;
    const auto take = [&](std::uint8_t& part, int count) {
      part = static_cast<std::uint8_t>(numbers);
      numbers += count;
    };
    if (group.shared_axes)
      group.at.rotation_axes = static_cast<std::uint8_t>(get_index(&SolverLane::axes));
    else
      take(group.at.rotation_axes, kNumbers<Mat3T>);
    if (group.may_be_by_rows) take(group.at.free, kNumbers<FreeBlock>);
    for (int r = 0; r < kRows; ++r) {
      if (has_row(group.freedoms, r)) take(group.at.freedoms[r], kNumbers<FreedomBlock>);
      if (has_row(group.rows, r)) take(group.at.rows[r], kNumbers<RowBlock>);
      if (has_row(group.compliant, r)) take(group.at.pivots[r], 1);
    }
    group.size = static_cast<std::uint8_t>(numbers);
    const int subtree = group.leaf ? 0 : kNumbers<SubtreeBlock>;
    group.solver = used_ + subtree * group.width;
    used_ += align((subtree + numbers) * group.width);
    group.joint = joined_;
    group.at.crossed = kNumbers<JointBlock>;
    group.at.carried = static_cast<std::int16_t>(group.at.crossed + (group.universal ? 1 : 0));
    group.constants = constants_;
    if (!group.has_joint) return;
    const int carried = kNumbers<CarriedBlock> + kNumbers<Vec3T> * std::popcount(group.carried);
    joined_ += align((group.at.carried + carried) * group.width);
    constants_ +=
        align((kNumbers<JointConstants> + (group.shared_axes ? 0 : kNumbers<RotationConstants>)) * group.width);
  }
  // Blocks begin at cache lines.
  static std::int32_t align(int numbers) { return (numbers + 7) / 8 * 8; }

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

  // Groups that begin the blocks of their parents: the first to come, if they add to all of them at once. Blocks of
  // flexible bodies and of such that lose mass begin with their own.
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

  // Each lane's parent; an empty lane has its neighbour's.
  void place_parents() {
    for (const Group& group : plan_.groups)
      for (int lane = 0; lane < group.width; ++lane) {
        const int node = plan_.lane_nodes[at(group.first + std::min<int>(lane, group.count - 1))];
        const int parent = plan_.nodes[at(node)].parent;
        plan_.lane_parents.push_back(parent == kNone ? Place{} : get_place(lanes_[at(parent)]));
      }
  }

  // Non-tree joints keep their multipliers behind the blocks.
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
    // A group without a joint points to the first of them, which is there also if no group has one.
    plan_.joint_constants.assign(std::max(at(constants_), std::size_t{kEight}), 0.0);
  }

  const Model& model_;
  PlanData& plan_;
  std::vector<TreeNode> old_;
  std::vector<bool> loaded_;  // per body
  std::vector<int> tree_of_;  // per node, as the topology numbered it
  int trees_ = 0;
  std::vector<GroupLane> lanes_;                        // of the nodes in their new order
  std::vector<int> eight_of_;                           // per group
  int open_ = kNone;                                    // eight that narrow groups go to
  std::int32_t used_ = 0, joined_ = 0, constants_ = 0;  // used_: by the solver's blocks
};

}  // namespace

void lay_out_blocks(const Model& model, PlanData& plan) { Layout(model, plan).compile(); }

}  // namespace unlatch
