#include "kernel/plan/lanes.h"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

#include "kernel/model/from_eigen.h"
#include "kernel/plan/lane_access.h"
#include "kernel/plan/lane_constants.h"
#include "unlatch/plan.h"

namespace unlatch {
namespace {

constexpr int kWidest = 8;
// A parent with so many children of one kind gets groups of its own for them.
constexpr int kFanChildren = 4;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// What must be equal for two nodes to share a group.
struct Kind {
  bool leaf = false, has_joint = false, shared_axes = true, universal = false, loose = false;
  RowSet freedoms = 0, rows = 0, compliant = 0;
  std::uint8_t carried = 0;
  LaneSpecial special = LaneSpecial::kOrdinary;

  std::uint64_t get_key() const {
    return static_cast<std::uint64_t>(leaf) | static_cast<std::uint64_t>(has_joint) << 1 |
           static_cast<std::uint64_t>(shared_axes) << 3 | static_cast<std::uint64_t>(universal) << 4 |
           static_cast<std::uint64_t>(loose) << 5 | static_cast<std::uint64_t>(freedoms) << 8 |
           static_cast<std::uint64_t>(rows) << 16 | static_cast<std::uint64_t>(carried) << 24 |
           static_cast<std::uint64_t>(compliant) << 32 | static_cast<std::uint64_t>(special) << 40;
  }
};

LaneSpecial find_special(const Model& model, const PlanNode& node) {
  if (model.bodies[at(node.body)].flexible) return LaneSpecial::kFlexible;
  const bool beyond = model.bodies[at(node.body)].marker && node.joint == kNone && node.parent != kNone;
  return beyond ? LaneSpecial::kMarker : LaneSpecial::kOrdinary;
}

Kind find_kind(const Model& model, const Plan& plan, const PlanNode& node) {
  Kind kind;
  kind.leaf = node.leaf;
  kind.special = find_special(model, node);
  if (node.joint == kNone) {
    kind.loose = true;
    return kind;
  }
  kind.compliant = plan.compliant_axes[at(node.joint)];
  const Joint& joint = model.joints[at(node.joint)];
  kind.has_joint = true;
  kind.universal = joint.universal;
  kind.shared_axes = !joint.rotation_axes.has_value() && !joint.universal;
  for (const JointMode& mode : joint.modes) {
    const int count = std::popcount(mode.rows);
    const bool held = count >= 3 || kind.compliant != 0;
    if (!held) kind.loose = true;
    if (held)
      kind.freedoms = static_cast<RowSet>(kind.freedoms | (~mode.rows & (kPointRows | kRotationRows)));
    else
      kind.rows = static_cast<RowSet>(kind.rows | mode.rows);
    const RowSet rotation = mode.rows & kRotationRows;
    for (int a = 0; a < 3; ++a)
      if (rotation == kRotationRows || rotation == (kRotationRows & ~row_bit(kRotX + a)))
        kind.carried = static_cast<std::uint8_t>(kind.carried | 1u << a);
  }
  return kind;
}

// A node on its way to its place.
struct Candidate {
  int node;    // as the topology numbered it
  int parent;  // in the new order
  std::uint64_t key;
  int rank;  // among its parent's children of this kind
};

class Layout {
 public:
  Layout(const Model& model, Plan& plan)
      : model_(model), plan_(plan), old_(std::exchange(plan.nodes, {})), loaded_(model.bodies.size(), false) {
    for (const PlanLoad& load : plan.loads)
      if (!load.world) loaded_[at(load.body)] = true;
  }

  void compile() {
    std::vector<int> level_of(old_.size(), 0), placed(old_.size(), kNone);
    int levels = 0;
    for (std::size_t k = 0; k < old_.size(); ++k) {
      if (old_[k].parent != kNone) level_of[k] = level_of[at(old_[k].parent)] + 1;
      levels = std::max(levels, level_of[k] + 1);
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
    place_loads();
  }

 private:
  struct Place {
    int group, lane;
  };

  void place_level(std::size_t begin, std::size_t end, std::vector<int>& placed) {
    std::vector<Candidate> level;
    for (std::size_t k = begin; k < end; ++k) {
      const int parent = old_[k].parent == kNone ? kNone : placed[at(old_[k].parent)];
      level.push_back({static_cast<int>(k), parent, find_kind(model_, plan_, old_[k]).get_key(), 0});
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
    std::vector<Candidate> fans = take_fans(level);
    sort([](const Candidate& c) { return std::tuple(c.key, c.rank, c.parent); });
    for (std::size_t i = 0; i < fans.size();) i += place_fan(fans, i, placed);
    for (std::size_t i = 0; i < level.size();) i += place_chunk(level, i, placed);
  }

  // Takes those children out of the level that are many enough, of one parent and kind, for groups of their own.
  static std::vector<Candidate> take_fans(std::vector<Candidate>& level) {
    std::vector<Candidate> fans, others;
    for (std::size_t i = 0; i < level.size();) {
      std::size_t kin = i;
      while (kin < level.size() && level[kin].key == level[i].key) ++kin;
      const std::size_t kind_begin = i;
      while (i < kin) {
        std::size_t siblings = i;
        while (siblings < kin && level[siblings].parent == level[i].parent) ++siblings;
        const std::size_t count = siblings - i;
        const bool fan =
            level[i].parent != kNone && count >= kFanChildren && (count >= kWidest || 2 * count > kin - kind_begin);
        (fan ? fans : others)
            .insert((fan ? fans : others).end(), level.begin() + static_cast<std::ptrdiff_t>(i),
                    level.begin() + static_cast<std::ptrdiff_t>(siblings));
        i = siblings;
      }
    }
    level = std::move(others);
    return fans;
  }

  std::size_t place_fan(const std::vector<Candidate>& fans, std::size_t begin, std::vector<int>& placed) {
    std::size_t end = begin;
    while (end < fans.size() && fans[end].key == fans[begin].key && fans[end].parent == fans[begin].parent) ++end;
    // From the leaves to the root the last group comes first, and is to be full: what is left over goes to the front.
    const std::size_t over = (end - begin) % kWidest, first = over == 0 || end - begin < kWidest ? end - begin : over;
    for (std::size_t i = begin, count = std::min<std::size_t>(first, kWidest); i < end; i += count, count = kWidest) {
      place_group(&fans[i], count, LaneLink::kFan, placed);
      plan_.groups.back().fan_ends = i == begin;
      plan_.groups.back().fan_begins = i + count == end;
    }
    return end - begin;
  }

  // The next group from nodes of one kind: neighbours of the parents' lanes if that makes a good part of a group.
  std::size_t place_chunk(const std::vector<Candidate>& level, std::size_t begin, std::vector<int>& placed) {
    std::size_t kin = begin;
    while (kin < level.size() && level[kin].key == level[begin].key && kin - begin < kWidest) ++kin;
    std::size_t count = kin - begin;
    if (level[begin].parent == kNone) return place_group(&level[begin], count, LaneLink::kRoot, placed);
    const std::size_t neighbours = count_neighbours(level, begin, kin);
    if (neighbours == count || neighbours >= 4)
      return place_group(&level[begin], neighbours, LaneLink::kContiguous, placed);
    return place_group(&level[begin], count, LaneLink::kGather, placed);
  }

  // How many from `begin` on have parents in neighbouring lanes of one group, with room for the empty lanes behind
  // them.
  std::size_t count_neighbours(const std::vector<Candidate>& level, std::size_t begin, std::size_t end) const {
    const Place first = places_[at(level[begin].parent)];
    const int width = plan_.groups[at(first.group)].width;
    std::size_t count = 1;
    while (begin + count < end) {
      const Place next = places_[at(level[begin + count].parent)];
      if (next.group != first.group || next.lane != first.lane + static_cast<int>(count)) break;
      ++count;
    }
    return first.lane == 0 && get_width(count) == width ? count : 0;
  }

  static int get_width(std::size_t count) { return static_cast<int>(std::bit_ceil(count)); }

  std::size_t place_group(const Candidate* members, std::size_t count, LaneLink link, std::vector<int>& placed) {
    const Kind kind = find_kind(model_, plan_, old_[at(members[0].node)]);
    LaneGroup group{};
    group.first = static_cast<std::int32_t>(plan_.lane_nodes.size());
    group.width = static_cast<std::uint8_t>(get_width(count));
    group.count = static_cast<std::uint8_t>(count);
    group.link = link;
    group.begins = kNone;
    group.leaf = kind.leaf;
    group.has_joint = kind.has_joint;
    group.sides = find_sides(members, count);
    group.shared_axes = kind.shared_axes;
    group.universal = kind.universal;
    group.may_be_loose = kind.loose || count < group.width;
    group.freedoms = kind.freedoms;
    group.rows = kind.rows;
    group.carried = kind.carried;
    group.compliant = kind.compliant;
    group.special = kind.special;
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
      places_.push_back({static_cast<int>(plan_.groups.size()), static_cast<int>(lane)});
    }
    // Empty lanes of a contiguous group lie beside the parents that are no parents of theirs, and give them nothing.
    plan_.groups.push_back(group);
    return count;
  }

  LaneSides find_sides(const Candidate* members, std::size_t count) const {
    const auto is_base = [&](const Candidate& c) { return old_[at(c.node)].side < 0; };
    if (std::none_of(members, members + count, is_base)) return LaneSides::kFollowers;
    return static_cast<int>(count) == get_width(count) && std::all_of(members, members + count, is_base)
               ? LaneSides::kBases
               : LaneSides::kMixed;
  }

  // Where each implicit spring's pivot and the acceleration along it are.
  void place_springs() {
    std::vector<int> node_of(model_.joints.size(), kNone);
    for (std::size_t k = 0; k < plan_.nodes.size(); ++k)
      if (plan_.nodes[k].joint != kNone) node_of[at(plan_.nodes[k].joint)] = static_cast<int>(k);
    for (PlanCompliant& c : plan_.compliant) {
      const JointSpring& spring = model_.joint_springs[at(c.spring)];
      const int node = node_of[at(spring.joint)];
      const LaneSlot slot = get_slot(places_[at(node)]);
      const LaneGroup& group = plan_.groups[at(places_[at(node)].group)];
      c.pivot = find(slot, group.pivots[spring.axis]);
      c.acceleration = find(slot, group.freedom_parts[spring.axis] + kBeta);
      c.side = plan_.nodes[at(node)].side;
    }
  }

  // Where each load that is fixed in a body is summed.
  void place_loads() {
    std::vector<int> node_of(model_.bodies.size(), kNone);
    for (std::size_t k = 0; k < plan_.nodes.size(); ++k) node_of[at(plan_.nodes[k].body)] = static_cast<int>(k);
    std::vector<bool> placed(model_.bodies.size(), false);
    for (PlanLoad& load : plan_.loads) {
      if (load.world) continue;
      load.applied = find(get_slot(places_[at(node_of[at(load.body)])]), kApplied);
      load.first = !placed[at(load.body)];
      placed[at(load.body)] = true;
    }
  }

  // Neighbouring lanes for the group's bodies, in the latest octet of narrow groups or, if none are left there, in a
  // new one. What the octet shares with the solver lies before the blocks of its first group.
  void place_bodies(LaneGroup& group, bool loaded) {
    const auto find_lane = [&](const LaneOctet& octet) {
      for (int lane = 0; lane < kOctet; lane += group.width)
        if ((octet.lanes >> lane & ((1 << group.width) - 1)) == 0) return lane;
      return kNone;
    };
    int lane = group.width < kOctet && open_ != kNone ? find_lane(plan_.octets[at(open_)]) : kNone;
    int place = open_;
    if (lane == kNone) {
      lane = 0;
      place = static_cast<int>(plan_.octets.size());
      plan_.octets.push_back({0, used_, place * kBodyConstants * kOctet, 0, 0, false});
      used_ += kSharedEnd * kOctet;
      if (group.width < kOctet) open_ = place;
    }
    LaneOctet& octet = plan_.octets[at(place)];
    octet.lanes = static_cast<std::uint8_t>(octet.lanes | ((1 << group.width) - 1) << lane);
    octet.bodies = static_cast<std::uint8_t>(octet.bodies | ((1 << group.count) - 1) << lane);
    octet.loaded = octet.loaded || loaded;
    octet_of_.push_back(place);
    group.body = lane;  // the rest once the octets' blocks are laid out
    group.shared = octet.shared + lane;
  }

  // Where the optional parts of the group's block begin, in rows, and where the block lies.
  void lay_out(LaneGroup& group) {
    int rows = group.has_joint ? kJointEnd : 0;
    const auto take = [&](std::uint8_t& part, int count) {
      part = static_cast<std::uint8_t>(rows);
      rows += count;
    };
    if (group.shared_axes)
      group.rotation_axes = kAxes;
    else
      take(group.rotation_axes, 9);
    if (group.may_be_loose) take(group.free, kFreeFields);
    for (int r = 0; r < kRows; ++r) {
      if (has_row(group.freedoms, r)) take(group.freedom_parts[r], kFreedomEnd);
      if (has_row(group.rows, r)) take(group.row_parts[r], kRowEnd);
      if (has_row(group.compliant, r)) take(group.pivots[r], 1);
    }
    group.size = static_cast<std::uint8_t>(rows);
    const int before = group.leaf ? 0 : kBlockFields;
    group.data = used_ + before * group.width;
    used_ += align((before + rows) * group.width);
    group.joint = joined_;
    group.crossed = kJointMotionEnd;
    group.carried_axes = group.crossed + (group.universal ? 1 : 0);
    group.constants = constants_;
    if (!group.has_joint) return;
    joined_ += align((group.carried_axes + kOffsetFields + 3 * std::popcount(group.carried)) * group.width);
    constants_ += align((group.shared_axes ? kSharedConstants : kAllConstants) * group.width);
  }
  // Blocks begin at cache lines.
  static std::int32_t align(int numbers) { return (numbers + 7) / 8 * 8; }

  LaneSlot get_slot(const Place& place) const { return unlatch::get_slot(plan_.groups[at(place.group)], place.lane); }

  // Bodies come first, then joints, then all that the solver reads.
  void join_blocks() {
    std::int32_t bodies = 0;
    for (LaneOctet& octet : plan_.octets) {
      octet.body = bodies;
      bodies += (octet.loaded ? kLoadedEnd : kBodyEnd) * kOctet;
    }
    const std::int32_t solver = bodies + joined_;
    for (LaneOctet& octet : plan_.octets) octet.shared += solver;
    for (std::size_t g = 0; g < plan_.groups.size(); ++g) {
      LaneGroup& group = plan_.groups[g];
      group.body += plan_.octets[at(octet_of_[g])].body;
      group.shared += solver;
      group.joint += bodies;
      group.data += solver;
    }
    used_ += solver;
  }

  // Where each lane's parent is; an empty lane has its neighbour's.
  void place_parents() {
    for (const LaneGroup& group : plan_.groups)
      for (int lane = 0; lane < group.width; ++lane) {
        const int node = plan_.lane_nodes[at(group.first + std::min<int>(lane, group.count - 1))];
        const int parent = plan_.nodes[at(node)].parent;
        plan_.lane_parents.push_back(parent == kNone ? LaneSlot{} : get_slot(places_[at(parent)]));
      }
  }

  // Which groups are the first to add to all blocks of their parents' group, on the way to the root. Blocks of flexible
  // bodies and of such that lose mass are begun with what is their own.
  void find_beginnings() {
    std::vector<bool> added(plan_.groups.size(), false), begun(plan_.groups.size(), false);
    for (std::size_t g = plan_.groups.size(); g-- > 0;) {
      LaneGroup& group = plan_.groups[g];
      if (group.link == LaneLink::kRoot || (group.link == LaneLink::kFan && !group.fan_ends)) continue;
      const int parent = places_[at(plan_.nodes[at(plan_.lane_nodes[at(group.first)])].parent)].group;
      const LaneGroup& parents = plan_.groups[at(parent)];
      const bool all = group.link == LaneLink::kContiguous || (group.link == LaneLink::kFan && parents.width == 1);
      if (all && !added[at(parent)] && group.special == LaneSpecial::kOrdinary && is_plain(parents)) {
        group.begins = parent;
        begun[at(parent)] = true;
      }
      for (int lane = 0; lane < group.count; ++lane)
        added[at(places_[at(plan_.nodes[at(plan_.lane_nodes[at(group.first + lane)])].parent)].group)] = true;
    }
    for (std::size_t g = 0; g < plan_.groups.size(); ++g)
      if (!plan_.groups[g].leaf && !begun[g]) plan_.own_beginnings.push_back(static_cast<std::int32_t>(g));
  }
  bool is_plain(const LaneGroup& group) const {
    if (group.special != LaneSpecial::kOrdinary) return false;
    for (int lane = 0; lane < group.count; ++lane)
      if (plan_.bodies[at(plan_.nodes[at(plan_.lane_nodes[at(group.first + lane)])].body)].varying != kNone)
        return false;
    return true;
  }

  void place_joints() {
    plan_.body_slots.resize(model_.bodies.size());
    plan_.multipliers.assign(model_.joints.size(), {kNone, 1});
    for (std::size_t k = 0; k < plan_.nodes.size(); ++k) {
      const PlanNode& node = plan_.nodes[k];
      const LaneSlot slot = plan_.body_slots[at(node.body)] = get_slot(places_[k]);
      if (node.joint == kNone) continue;
      plan_.multipliers[at(node.joint)] = {find(slot, kMultipliers), slot.stride};
      plan_.joints[at(node.joint)].child = node.body;
      plan_.joints[at(node.joint)].rotation_row = plan_.groups[at(places_[k].group)].rotation_axes;
    }
    // Joints that are not in the tree keep their multipliers behind the lanes.
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      if (plan_.joints[j].child != kNone) continue;
      plan_.joints[j].loose = static_cast<std::int32_t>(plan_.loose_joints.size());
      const Joint& joint = model_.joints[j];
      plan_.loose_joints.push_back({static_cast<std::int32_t>(j), to_vec(joint.point_base),
                                    to_vec(joint.point_follower), to_mat(joint.axes),
                                    to_mat(joint.rotation_axes.value_or(joint.axes))});
      plan_.multipliers[j] = {used_, 1};
      used_ += kRows;
    }
    plan_.lane_numbers = used_;
    plan_.joint_constants.assign(at(constants_), 0.0);
  }

  const Model& model_;
  Plan& plan_;
  std::vector<PlanNode> old_;
  std::vector<bool> loaded_;                            // per body
  std::vector<Place> places_;                           // of the nodes in their new order
  std::vector<int> octet_of_;                           // per group
  int open_ = kNone;                                    // octet that narrow groups go to
  std::int32_t used_ = 0, joined_ = 0, constants_ = 0;  // used_: by the solver's blocks
};

}  // namespace

void compile_lanes(const Model& model, Plan& plan) {
  Layout(model, plan).compile();
  fill_constants(model, plan);
}

}  // namespace unlatch
