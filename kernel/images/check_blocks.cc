// The division into blocks, and bodies that bend or burn.
#include <algorithm>
#include <cstring>

#include "kernel/dynamics/flexible.h"
#include "kernel/images/plan_check.h"
#include "kernel/tree/group_parts.h"

namespace unlatch {

void PlanCheck::check_eights() {
  std::int64_t end = 0;
  for (const BodyEight& eight : plan_.eights) {
    require_flag(eight.loaded);
    if (!good_) return;
    require(eight.body >= end && eight.body % kEight == 0 && eight.shared % kEight == 0);
    end = std::int64_t{eight.body} + eight.count_body_numbers();
    require_range(eight.body, eight.count_body_numbers(), at(plan_.block_numbers));
    require_range(eight.shared, kNumbers<SharedBlock> * kEight, at(plan_.block_numbers));
    require(eight.constants % kEight == 0);
    require_range(eight.constants, kNumbers<BodyConstants> * kEight, plan_.body_constants.size());
  }
}

void PlanCheck::check_groups() {
  require(plan_.lane_parents.size() == plan_.lane_nodes.size());
  require(plan_.solver_constants.size() / kNumbers<SolverConstants> >= plan_.lane_nodes.size());
  require(plan_.places.size() == plan_.bodies.size());
  require(plan_.accelerations.size() == plan_.bodies.size());
  require(plan_.multipliers.size() == plan_.joints.size());
  require(plan_.compliant_axes.size() == plan_.joints.size());
  std::size_t lanes = 0;
  for (std::size_t g = 0; g < plan_.groups.size() && good_; ++g) {
    check_group(g);
    lanes += plan_.groups[g].count;
  }
  // Each lane has a place of its own: so many of them are all bodies.
  require(lanes == plan_.bodies.size());
  for (std::size_t g = 0; g < plan_.groups.size() && good_; ++g) check_parents(g);
  for (const std::int32_t g : plan_.inner_groups) {
    require_index(g, plan_.groups.size());
    if (good_) require(!plan_.groups[at(g)].leaf);
  }
}

void PlanCheck::check_group(std::size_t g) {
  const Group& group = plan_.groups[g];
  require(group.width == 1 || group.width == 2 || group.width == 4 || group.width == 8);
  require(group.count >= 1 && group.count <= group.width);
  require_kind(group.link, ParentLink::kGather);
  require_kind(group.kind, BodyKind::kMarker);
  require_kind(group.side, ChildSide::kMixed);
  require_range(group.first, group.width, plan_.lane_nodes.size());
  require(group.has_joint || group.may_be_by_rows);
  if (!good_) return;
  constexpr RowSet kAll = kPointRows | kRotationRows;
  require(((group.freedoms | group.rows | group.compliant) & ~kAll) == 0 && group.carried < 8);
  require((group.compliant & ~group.freedoms) == 0);
  Group placed = group;
  placed.at = {};
  const JointNumbers numbers = place_parts(placed);
  require(std::memcmp(&placed.at, &group.at, sizeof(group.at)) == 0 && placed.size == group.size);
  const int before = (group.leaf ? 0 : kSubtreeBeforeSolver) * group.width;
  require(group.solver % group.width == 0 && group.joint % group.width == 0);
  require_range(std::int64_t{group.solver} - before, before + group.size * group.width, at(plan_.block_numbers));
  require_range(group.joint, numbers.joint * group.width, at(plan_.block_numbers));
  require_range(group.constants, numbers.constants * group.width, plan_.joint_constants.size());
  if (g > 0) require(group.solver - before >= plan_.groups[g - 1].solver + plan_.groups[g - 1].width);
  // Its bodies are lanes of one block of eight.
  const auto eight = std::upper_bound(plan_.eights.begin(), plan_.eights.end(), group.body,
                                      [](std::int32_t body, const BodyEight& other) { return body < other.body; });
  require(eight != plan_.eights.begin());
  if (!good_) return;
  const BodyEight& of = *std::prev(eight);
  const std::int64_t lane = std::int64_t{group.body} - of.body;
  require(lane + group.width <= kEight && lane % group.width == 0 && group.shared == of.shared + lane);
  if (!good_) return;
  const unsigned lanes = (1u << group.width) - 1, used = of.used, filled = of.filled;
  require((used >> lane & lanes) == lanes && (filled >> lane & lanes) == (1u << group.count) - 1);
  for (int i = 0; i < group.width && good_; ++i) check_lane(g, i);
}

void PlanCheck::check_lane(std::size_t g, int lane) {
  const Group& group = plan_.groups[g];
  const std::int32_t node = plan_.lane_nodes[at(group.first + lane)];
  require(lane < group.count ? is_index(node, plan_.nodes.size()) : node == kNone);
  require(lane < group.count || group.may_be_by_rows);
  if (!good_ || node == kNone) return;
  const TreeNode& own = plan_.nodes[at(node)];
  const Place place = get_place(group, lane);
  require(is_same(plan_.places[at(own.body)], place));
  require(group.has_joint == (own.joint != kNone) && (group.link == ParentLink::kRoot) == (own.parent == kNone));
  require(plan_.accelerations[at(own.body)].first == find_number(place, &SharedLane::acceleration).at &&
          plan_.accelerations[at(own.body)].stride == kEight);
  const std::int32_t flexible = plan_.bodies[at(own.body)].flexible;
  require(group.kind == BodyKind::kRigid || flexible != kNone);
  if (good_ && group.kind != BodyKind::kRigid)
    require((plan_.flexible[at(flexible)].body == own.body) == (group.kind == BodyKind::kFlexible));
  require(group.kind != BodyKind::kFlexible || !group.leaf);
  if (own.joint == kNone) return;
  require(group.kind == BodyKind::kRigid && plan_.joints[at(own.joint)].group == static_cast<std::int32_t>(g));
  require(group.universal == plan_.joints[at(own.joint)].universal);
  const NumberColumn& multipliers = plan_.multipliers[at(own.joint)];
  require(multipliers.first == find_number(place, &SolverLane::multipliers).at && multipliers.stride == group.width);
  check_modes(group, own.joint);
}

// The group has the parts that the joint's modes read.
void PlanCheck::check_modes(const Group& group, std::int32_t joint) {
  constexpr RowSet kAll = kPointRows | kRotationRows;
  require(plan_.compliant_axes[at(joint)] == group.compliant);
  for (std::int32_t mode = 0; mode < count_modes(joint); ++mode) {
    const RowSet rows = plan_.get_rows(joint, mode);
    const bool by_freedoms = is_by_freedoms(rows, group.compliant);
    if (by_freedoms)
      require((~rows & kAll & ~group.freedoms) == 0);
    else
      require(group.may_be_by_rows && (rows & ~group.rows) == 0);
    require((get_carried_axes(rows) & ~group.carried) == 0);
  }
}

std::int32_t PlanCheck::find_group(const Place& place) const {
  const auto after = std::upper_bound(plan_.groups.begin(), plan_.groups.end(), place.solver,
                                      [](std::int32_t solver, const Group& group) { return solver < group.solver; });
  return static_cast<std::int32_t>(after - plan_.groups.begin()) - 1;
}

// Where each lane's parent is, and what the group may do with several at once. The groups themselves are good.
void PlanCheck::check_parents(std::size_t g) {
  const Group& group = plan_.groups[g];
  require_optional(group.begins, g);
  const bool root = group.link == ParentLink::kRoot;
  if (root) require(group.begins == kNone);
  for (int lane = 0; lane < group.width && good_; ++lane) {
    const Place& place = plan_.lane_parents[at(group.first + lane)];
    const TreeNode& node = plan_.nodes[at(plan_.lane_nodes[at(group.first + std::min<int>(lane, group.count - 1))])];
    if (root) {
      require(is_same(place, Place{}));
      continue;
    }
    const std::int32_t parent = plan_.nodes[at(node.parent)].body;
    require(is_same(place, plan_.places[at(parent)]) && !is_leaf(parent));
  }
  if (!good_ || root) return;
  const Place& first = plan_.lane_parents[at(group.first)];
  const std::int32_t of = find_group(first);
  const Group& parents = plan_.groups[at(of)];
  if (group.link == ParentLink::kContiguous)
    require(parents.width == group.width && is_same(first, get_place(parents, 0)));
  if (group.begins == kNone) return;
  const bool four = group.width == 4 && group.siblings_begin && group.siblings_end && parents.width == 1;
  require(group.begins == of && parents.kind == BodyKind::kRigid &&
          (group.link == ParentLink::kContiguous || (group.link == ParentLink::kSiblings && four)));
}

// Joints that are no edges of the tree have their multipliers behind the blocks; those of the tree are in a group.
void PlanCheck::check_places() {
  std::size_t edges = 0;
  for (const TreeNode& node : plan_.nodes) edges += node.joint == kNone ? 0 : 1;
  for (std::size_t j = 0; j < plan_.joints.size(); ++j) {
    if (plan_.joints[j].non_tree == kNone) {
      require(edges-- > 0);
      continue;
    }
    require(plan_.multipliers[j].stride == 1);
    require_range(plan_.multipliers[j].first, kRows, at(plan_.block_numbers));
  }
  require(edges == 0);
}

void PlanCheck::check_bodies() {
  constexpr std::int32_t kMostModes = 4096;  // of one body: numbers of its work are counted in 32 bits
  const std::size_t auxiliary = plan_.initial_auxiliary.size();
  require(plan_.varying.size() <= auxiliary);
  for (std::size_t i = 0; i < plan_.varying.size(); ++i) {
    const PlanVarying& own = plan_.varying[i];
    require_flag(own.by_burnt);
    require_flag(own.jet_damping);
    require_body(own.body);
    require_range(own.first, own.count, plan_.mass_knots.size());
    require(own.count >= 1);
    if (good_) require(plan_.bodies[at(own.body)].varying == static_cast<std::int32_t>(i) && !is_leaf(own.body));
  }
  for (std::size_t i = 0; i < plan_.flexible.size() && good_; ++i) {
    const PlanFlexible& own = plan_.flexible[i];
    require_flag(own.implicit);
    require_body(own.body);
    require(own.modes >= 1 && own.modes <= kMostModes);
    require_range(own.first_marker, own.markers, plan_.markers.size());
    require(own.inboard == kNone || (own.inboard >= own.first_marker && own.inboard < own.first_marker + own.markers));
    if (!good_) return;
    require(plan_.bodies[at(own.body)].flexible == static_cast<std::int32_t>(i));
    require_range(own.auxiliary, 2 * own.modes, auxiliary);
    require_range(own.numbers, get_shape_size(own.modes), plan_.modal.size());
    const std::int64_t work = get_work_size(own.modes) + std::int64_t{own.markers} * get_marker_size(own.modes);
    require_range(own.work, work, at(plan_.modal_work));
    for (std::int32_t m = own.first_marker; m < own.first_marker + own.markers && good_; ++m) {
      const PlanMarker& marker = plan_.markers[at(m)];
      require_flag(marker.bare);
      require_body(marker.body);
      require(marker.flexible == static_cast<std::int32_t>(i));
      require_range(marker.numbers, get_marker_shape_size(own.modes), plan_.modal.size());
      if (!good_) return;
      require(plan_.bodies[at(marker.body)].flexible == static_cast<std::int32_t>(i) && marker.body != own.body);
      require(marker.bare == is_leaf(marker.body));
    }
    const std::int32_t group = find_group(plan_.places[at(own.body)]);
    require(plan_.groups[at(group)].kind == BodyKind::kFlexible);
    if (own.inboard != kNone) require(!is_leaf(plan_.markers[at(own.inboard)].body));
  }
}

}  // namespace unlatch
