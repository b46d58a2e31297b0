#include "kernel/tree/groups.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace unlatch {
namespace {

constexpr int kWidest = 8;
// From this number of children of one kind on, a parent's children may have groups of their own.
constexpr int kFewestSiblings = 4;

BodyKind find_body_kind(const Model& model, const TreeNode& node) {
  if (model.bodies[at(node.body)].flexible) return BodyKind::kFlexible;
  const bool outboard = model.bodies[at(node.body)].marker && node.joint == kNone && node.parent != kNone;
  return outboard ? BodyKind::kMarker : BodyKind::kRigid;
}

NodeKind find_kind(const Model& model, const std::vector<RowSet>& compliant, const TreeNode& node) {
  NodeKind kind;
  kind.leaf = node.leaf;
  kind.body = find_body_kind(model, node);
  if (node.joint == kNone) {
    kind.by_rows = true;
    return kind;
  }
  kind.compliant = compliant[at(node.joint)];
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

// A node that has no place in the new order yet.
struct Candidate {
  int node;    // its number in the topology
  int parent;  // in the new order
  int tree;    // number of its root
  std::uint64_t key;
  int rank;  // among its parent's children of this kind
};

class Grouping {
 public:
  Grouping(const Model& model, const std::vector<TreeNode>& tree, const std::vector<RowSet>& compliant)
      : model_(model), old_(tree), compliant_(compliant), placed_(tree.size(), kNone) {}

  GroupedNodes compile() {
    std::vector<int> level_of(old_.size(), 0);
    for (std::size_t k = 0; k < old_.size(); ++k) {
      const int parent = old_[k].parent;
      if (parent != kNone) level_of[k] = level_of[at(parent)] + 1;
      tree_of_.push_back(parent == kNone ? trees_++ : tree_of_[at(parent)]);
    }
    // The topology is ordered by levels, so that the nodes of each level follow one another.
    out_.nodes.reserve(old_.size());
    for (std::size_t begin = 0; begin < old_.size();) {
      std::size_t end = begin;
      while (end < old_.size() && level_of[end] == level_of[begin]) ++end;
      place_level(begin, end);
      begin = end;
    }
    return std::move(out_);
  }

 private:
  void place_level(std::size_t begin, std::size_t end) {
    std::vector<Candidate> level;
    for (std::size_t k = begin; k < end; ++k) {
      const int parent = old_[k].parent == kNone ? kNone : placed_[at(old_[k].parent)];
      level.push_back({static_cast<int>(k), parent, tree_of_[k], find_kind(model_, compliant_, old_[k]).get_key(), 0});
    }
    const auto sort = [&](auto order) {
      std::sort(level.begin(), level.end(), [&](const Candidate& a, const Candidate& b) {
        const auto x = order(a), y = order(b);
        return x != y ? x < y : a.node < b.node;
      });
    };
    // For the ranks, children of one parent and kind are sorted together; for the groups, equal kinds and ranks.
    sort([](const Candidate& c) { return std::pair(c.key, c.parent); });
    for (std::size_t i = 1; i < level.size(); ++i)
      if (level[i].key == level[i - 1].key && level[i].parent == level[i - 1].parent)
        level[i].rank = level[i - 1].rank + 1;
    std::vector<Candidate> siblings = take_siblings(level);
    sort([](const Candidate& c) { return std::tuple(c.key, c.rank, c.parent); });
    for (std::size_t i = 0; i < siblings.size();) i += place_siblings(siblings, i);
    for (std::size_t i = 0; i < level.size();) i = place_kind(level, i);
  }

  // Removes from the level the children of one parent and kind that are numerous enough for groups of their own. The
  // decision depends on their own tree alone: a tree is summed in one order, whatever is computed beside it.
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

  // The groups of one parent's children of one kind; returns their number.
  std::size_t place_siblings(const std::vector<Candidate>& siblings, std::size_t begin) {
    std::size_t end = begin;
    while (end < siblings.size() && siblings[end].key == siblings[begin].key &&
           siblings[end].parent == siblings[begin].parent)
      ++end;
    // The backward pass begins with the last group, which must be full: the first group gets the remainder.
    const std::size_t over = (end - begin) % kWidest, first = over == 0 || end - begin < kWidest ? end - begin : over;
    for (std::size_t i = begin, count = std::min<std::size_t>(first, kWidest); i < end; i += count, count = kWidest) {
      NodeGroup& group = place_group(&siblings[i], count, ParentLink::kSiblings);
      group.siblings_end = i == begin;
      group.siblings_begin = i + count == end;
    }
    return end - begin;
  }

  // Nodes of one kind that become a group: `count` of them from `first` on.
  struct Chunk {
    std::size_t first, count;
    ParentLink link;
  };

  // Places the groups of one kind; returns where it ends. The backward pass begins with the last group, but a parent's
  // children are to be added by rising rank, from group to group too: so the chunks are placed in reverse order.
  std::size_t place_kind(const std::vector<Candidate>& level, std::size_t begin) {
    std::size_t end = begin;
    while (end < level.size() && level[end].key == level[begin].key) ++end;
    std::vector<Chunk> chunks;
    for (std::size_t i = begin; i < end; i += chunks.back().count) chunks.push_back(find_chunk(level, i, end));
    for (std::size_t i = chunks.size(); i-- > 0;) place_group(&level[chunks[i].first], chunks[i].count, chunks[i].link);
    return end;
  }

  // The next group of a kind that ends at `end`: lane for lane beside the parents if these are most of a group.
  Chunk find_chunk(const std::vector<Candidate>& level, std::size_t begin, std::size_t end) const {
    const std::size_t kin = std::min(end, begin + kWidest), count = kin - begin;
    if (level[begin].parent == kNone) return {begin, count, ParentLink::kRoot};
    const std::size_t neighbours = count_neighbours(level, begin, kin);
    if (neighbours == count || neighbours >= 4) return {begin, neighbours, ParentLink::kContiguous};
    return {begin, count, ParentLink::kGather};
  }

  // Number of nodes from `begin` on whose parents are the first lanes of one group, in the same order; 0 unless their
  // group is as wide as the parents'. Its empty lanes, beside parents of no lane, add zero to these.
  std::size_t count_neighbours(const std::vector<Candidate>& level, std::size_t begin, std::size_t end) const {
    const GroupLane first = out_.lanes[at(level[begin].parent)];
    const int width = out_.groups[at(first.group)].get_width();
    std::size_t count = 1;
    while (begin + count < end) {
      const GroupLane next = out_.lanes[at(level[begin + count].parent)];
      if (next.group != first.group || next.lane != first.lane + static_cast<int>(count)) break;
      ++count;
    }
    return first.lane == 0 && get_group_width(static_cast<int>(count)) == width ? count : 0;
  }

  NodeGroup& place_group(const Candidate* members, std::size_t count, ParentLink link) {
    NodeGroup group;
    group.kind = find_kind(model_, compliant_, old_[at(members[0].node)]);
    group.link = link;
    group.side = find_side(members, count);
    group.first = static_cast<int>(out_.nodes.size());
    group.count = static_cast<int>(count);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Candidate& member = members[lane];
      placed_[at(member.node)] = static_cast<int>(out_.nodes.size());
      out_.nodes.push_back(old_[at(member.node)]);
      out_.nodes.back().parent = member.parent;
      out_.lanes.push_back({static_cast<int>(out_.groups.size()), static_cast<int>(lane)});
    }
    return out_.groups.emplace_back(group);
  }

  ChildSide find_side(const Candidate* members, std::size_t count) const {
    const auto is_base = [&](const Candidate& c) { return old_[at(c.node)].side < 0; };
    if (std::none_of(members, members + count, is_base)) return ChildSide::kFollower;
    return static_cast<int>(count) == get_group_width(static_cast<int>(count)) &&
                   std::all_of(members, members + count, is_base)
               ? ChildSide::kBase
               : ChildSide::kMixed;
  }

  const Model& model_;
  const std::vector<TreeNode>& old_;
  const std::vector<RowSet>& compliant_;
  std::vector<int> placed_;   // per node of the topology: its new number
  std::vector<int> tree_of_;  // likewise: number of its root
  int trees_ = 0;
  GroupedNodes out_;
};

}  // namespace

GroupedNodes group_nodes(const Model& model, const std::vector<TreeNode>& tree, const std::vector<RowSet>& compliant) {
  return Grouping(model, tree, compliant).compile();
}

}  // namespace unlatch
