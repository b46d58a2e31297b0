#include "kernel/cost/work.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "kernel/cost/load_times.h"
#include "kernel/cost/step_counts.h"
#include "kernel/elements/kinds/contact/contact_parts.h"
#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/elements/kinds/kinds.h"
#include "kernel/geometry/compiled_shape.h"
#include "kernel/integration/contact_stages.h"
#include "kernel/joints/kinematics.h"
#include "unlatch/quantities.h"
#include "unlatch/redundancy.h"

namespace unlatch::cost {

namespace {

// Passes by the lanes of their pack: the unit for one lane, and behind it those for two and for more.
Unit by_lanes(Unit one, int pack) { return static_cast<Unit>(static_cast<int>(one) + std::min(pack / 2, 2)); }

// --- Modes of joints, as the solver sees them ------------------------------------------------------------------------

// What an event does to a joint or an element, in the order of the actions.
struct Change {
  std::size_t event;
  Action::Kind kind;
  double value, duration;
  bool operator==(const Change&) const = default;
};
// Whatever has equal ones is in equal states at all times.
struct Course {
  std::vector<double> begin;
  std::vector<Change> changes;
  bool operator==(const Course&) const = default;
};

template <class Is>
std::vector<Change> list_changes(const PlanData& plan, const Is& is) {
  std::vector<Change> changes;
  for (std::size_t e = 0; e < plan.events.size(); ++e)
    for (std::int32_t i = 0; i < plan.events[e].action_count; ++i) {
      const Action& action = plan.actions[at(plan.events[e].first_action + i)];
      if (!is(action)) continue;
      const double value = action.kind == Action::Kind::kSetMode ? action.mode : action.value;
      changes.push_back({e, action.kind, value, action.duration});
    }
  return changes;
}

Course get_course(const PlanData& plan, int joint) {
  Course course;
  course.begin.push_back(plan.joints[at(joint)].mode);
  for (const RowSet rows : get_modes(plan, joint)) course.begin.push_back(rows);
  course.changes = list_changes(
      plan, [&](const Action& action) { return action.kind == Action::Kind::kSetMode && action.subject == joint; });
  return course;
}

// As load_modes() computes it of a group, for one lane.
GroupModes get_lane_modes(const Group& group, RowSet rows) {
  if (!is_by_freedoms(rows, group.compliant)) return {0, static_cast<RowSet>(group.rows & rows), false, true};
  return {static_cast<RowSet>(group.freedoms & ~rows), 0, true, false};
}
GroupModes unite(const GroupModes& a, const GroupModes& b) {
  return {static_cast<RowSet>(a.freedoms | b.freedoms), static_cast<RowSet>(a.rows | b.rows),
          a.by_freedoms || b.by_freedoms, a.by_rows || b.by_rows};
}
bool is_same(const GroupModes& a, const GroupModes& b) {
  return a.freedoms == b.freedoms && a.rows == b.rows && a.by_freedoms == b.by_freedoms && a.by_rows == b.by_rows;
}
void add_once(std::vector<GroupModes>& list, const GroupModes& modes) {
  if (std::none_of(list.begin(), list.end(), [&](const GroupModes& own) { return is_same(own, modes); }))
    list.push_back(modes);
}

// Joints of a group whose modes always change together.
struct JointClass {
  Course course;
  int joint;
};
std::vector<JointClass> list_classes(const PlanData& plan, const Group& group) {
  std::vector<JointClass> classes;
  for (int lane = 0; lane < group.width; ++lane) {
    const int node = plan.lane_nodes[at(group.first + lane)];
    if (node == kNone) continue;
    const int joint = plan.nodes[at(node)].joint;
    Course course = get_course(plan, joint);
    const auto is_same_course = [&](const JointClass& own) { return own.course == course; };
    if (std::none_of(classes.begin(), classes.end(), is_same_course)) classes.push_back({std::move(course), joint});
  }
  return classes;
}

// What the lanes of a group may need at one time.
std::vector<GroupModes> list_group_modes(const PlanData& plan, const Group& group) {
  if (!group.has_joint) return {{0, 0, false, true}};
  std::vector<GroupModes> all = {{0, 0, false, group.count < group.width}};  // empty lanes hold no row
  for (const JointClass& own : list_classes(plan, group)) {
    std::vector<GroupModes> with;
    for (const RowSet rows : get_modes(plan, own.joint))
      for (const GroupModes& others : all) add_once(with, unite(others, get_lane_modes(group, rows)));
    all = std::move(with);
  }
  return all;
}

// The modes for which a group counts: those that cost most, by what the solver takes for each part, roughly.
double estimate(const Group& group, const GroupModes& modes) {
  constexpr double kByFreedoms = 1, kFreedom = 2.4, kByRows = 2.5, kInnerByRows = 8, kRow = 3, kRowPair = 0.6;
  const int freedoms = std::popcount(modes.freedoms), rows = std::popcount(modes.rows);
  return (modes.by_freedoms ? kByFreedoms : 0) + kFreedom * freedoms +
         (modes.by_rows ? kByRows + (group.leaf ? 0 : kInnerByRows) : 0) + kRow * rows +
         kRowPair * (rows * (rows - 1) / 2);
}
GroupModes choose_modes(const PlanData& plan, const Group& group) {
  const std::vector<GroupModes> all = list_group_modes(plan, group);
  return *std::max_element(all.begin(), all.end(), [&](const GroupModes& a, const GroupModes& b) {
    return estimate(group, a) < estimate(group, b);
  });
}

// --- Passes ----------------------------------------------------------------------------------------------------------

void count_bodies(const PlanData& plan, int lanes, Work& work) {
  for (const BodyEight& eight : plan.eights) {
    const int used = static_cast<int>(std::bit_width(eight.used));
    const int pack = std::min(lanes, static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(used, 1)))));
    const int passes = (used + pack - 1) / pack;
    work[by_lanes(Unit::kBodies1, pack)] += passes;
    if (plan.gravity.mu != 0) work[Unit::kCentral] += passes;
    if (!eight.loaded) continue;
    work[Unit::kLoaded] += passes;
    work[Unit::kLoadedEights] += 1;  // whose forces are cleared, all lanes of them
  }
  work[Unit::kBodyCount] = static_cast<double>(plan.bodies.size());
  work[Unit::kJointCount] = static_cast<double>(plan.joints.size());
}

// The nodes of a group in the solver.
void count_node(const PlanData& plan, const Group& group, int pack, Work& work) {
  const double passes = group.width / pack;
  const GroupModes modes = choose_modes(plan, group);
  const int freedoms = std::popcount(modes.freedoms), rows = std::popcount(modes.rows);
  const double by_freedoms = modes.by_freedoms ? passes : 0, by_rows = modes.by_rows ? passes : 0;
  work[by_lanes(group.leaf ? Unit::kLeaves1 : Unit::kInner1, pack)] += passes;
  work[Unit::kByFreedoms] += by_freedoms;
  if (modes.by_freedoms && !modes.by_rows && freedoms == 1) work[Unit::kSingles] += passes;
  work[Unit::kFreedoms] += passes * freedoms;
  work[Unit::kTurns] += passes * std::popcount(static_cast<RowSet>(modes.freedoms & kRotationRows));
  work[Unit::kLaterFreedoms] += passes * std::max(freedoms - 1, 0);
  work[Unit::kByRows] += by_rows;
  work[Unit::kRows] += passes * rows;
  work[Unit::kRowPairs] += passes * rows * (rows - 1) / 2;
  work[Unit::kMasks] += passes * (modes.by_rows && group.has_joint ? static_cast<int>(kRows) : freedoms);
  work[Unit::kPivots] += passes * std::popcount(group.compliant);
  if (group.leaf) return;
  work[Unit::kInnerByFreedoms] += by_freedoms;
  work[Unit::kInnerFreedoms] += passes * freedoms;
  work[Unit::kInnerByRows] += by_rows;
  work[Unit::kInnerRows] += passes * rows;
}

void count_group(const PlanData& plan, const Group& group, int lanes, Work& work) {
  work[Unit::kFilledLanes] += group.width;
  if (group.kind != BodyKind::kRigid && !group.has_joint) return;
  const int pack = std::min<int>(lanes, group.width);
  const double passes = group.width / pack;
  if (group.has_joint) {
    work[by_lanes(Unit::kJoints1, pack)] += passes;
    if (!group.shared_axes) work[Unit::kOwnRotationAxes] += passes;
    if (group.universal) work[Unit::kUniversal] += passes;
    if (group.side != ChildSide::kFollower) work[Unit::kBaseChild] += passes;
    work[Unit::kCarriedAxes] += passes * std::popcount(group.carried);
    work[Unit::kJointFreedoms] += passes * std::popcount(group.freedoms);
  }
  if (group.link == ParentLink::kGather) work[Unit::kGather] += group.width;
  if (group.link == ParentLink::kSiblings) work[Unit::kSiblings] += passes;
  if (group.link == ParentLink::kContiguous) work[Unit::kContiguous] += passes;
  if (group.link == ParentLink::kRoot) work[Unit::kRoots] += passes;
  if (group.siblings_end) work[Unit::kEndSiblings] += 1;
  if (group.kind == BodyKind::kRigid) count_node(plan, group, pack, work);
}

// Nodes of the solver that a wrench meets one at a time: pivots of one.
double count_pivots(const PlanData& plan, std::int32_t group) {
  constexpr int kOfFreeBody = 6;
  const Group& own = plan.groups[at(group)];
  if (own.kind != BodyKind::kRigid) return kOfFreeBody;
  const GroupModes modes = choose_modes(plan, own);
  const int by_rows = modes.by_rows ? kOfFreeBody + std::popcount(modes.rows) : 0;
  return std::max(by_rows, std::popcount(modes.freedoms));
}

double to_double(std::size_t count) { return static_cast<double>(count); }

// Rows of Λ side by side in packs.
void count_dense_loops(const PlanData& plan, int lanes, Work& work) {
  const double rows = plan.loop_rows, packs = std::ceil(rows / lanes);
  double triangle = 0, pivots = 0;  // packs of a lower triangle; of one column
  for (std::int32_t r = 0; r < plan.loop_rows; ++r) triangle += std::ceil((r + 1.0) / lanes);
  for (const LoopNode& node : plan.loop_nodes) pivots += count_pivots(plan, node.group);
  work[Unit::kDenseLoops] = to_double(plan.loops.size());
  work[Unit::kDenseRows] = rows;
  work[Unit::kDenseNodes] = to_double(plan.loop_nodes.size());
  work[Unit::kDensePacks] = packs * to_double(plan.loop_nodes.size());
  work[Unit::kDensePivots] = pivots;
  work[Unit::kDensePivotPacks] = pivots * packs;
  work[Unit::kDenseProducts] = pivots * triangle;
  work[Unit::kDenseSquares] = rows * rows;
  work[Unit::kDenseCubes] = rows * rows * rows;
  // The tree is solved once more.
  for (const Unit of : {Unit::kLeaves1, Unit::kLeaves2, Unit::kLeaves4, Unit::kInner1, Unit::kInner2, Unit::kInner4})
    work[Unit::kDensePasses] += work[of];
  work[Unit::kDenseByFreedoms] = work[Unit::kByFreedoms];
  work[Unit::kDenseFreedoms] = work[Unit::kFreedoms];
  work[Unit::kDenseByRows] = work[Unit::kByRows];
  work[Unit::kDenseByNodeRows] = work[Unit::kRows];
}

double count_most_rows(const PlanData& plan, int joint) {
  int most = 0;
  for (const RowSet rows : get_modes(plan, joint)) most = std::max(most, std::popcount(rows));
  return most;
}

// Loops that are eliminated where they close.
void count_clusters(const Plan& owner, const PlanData& plan, Work& work) {
  work[Unit::kClosures] = to_double(plan.closures.size());
  for (const LoopClosure& own : plan.closures) {
    const double rows = count_most_rows(plan, own.joint);
    work[Unit::kClosureRows] += rows;
    work[Unit::kClosureCubes] += rows * rows * rows;
  }
  work[Unit::kClusterNodes] = to_double(plan.cluster_nodes.size());
  work[Unit::kClusterSlots] = to_double(plan.loop_slots.size());
  work[Unit::kClusterLinks] = to_double(plan.loop_links.size());
  work[Unit::kClusterPairs] = to_double(plan.loop_pairs.size());
  work[Unit::kClusterProducts] = to_double(static_cast<std::size_t>(calc_loop_cost(owner).loops));
  for (const ClusterNode& node : plan.cluster_nodes) {
    const double pivots = count_pivots(plan, node.group), passing = node.slots - node.closing;
    work[Unit::kClusterPivots] += pivots * passing;
    work[Unit::kClusterPivotPairs] += pivots * passing * (passing + 1) / 2;
  }
}

void count_loops(const Plan& owner, const PlanData& plan, int lanes, Work& work) {
  for (const PlanNonTreeJoint& joint : plan.non_tree_joints)
    if (count_most_rows(plan, joint.joint) > 0) work[Unit::kStageLoops] += 1;
  work[Unit::kLoops] = to_double(plan.non_tree_joints.size());
  if (plan.loops.empty()) return;
  if (plan.closures.empty())
    count_dense_loops(plan, lanes, work);
  else
    count_clusters(owner, plan, work);
  const double rows = plan.loop_rows, tree_rows = plan.ring_rows;
  work[Unit::kSplitRows] = rows + tree_rows;
  work[Unit::kSplitProducts] = rows * rows * (rows + tree_rows);
}

void count_varying_bodies(const PlanData& plan, Work& work) {
  for (const PlanFlexible& body : plan.flexible) {
    const double m = body.modes, markers = body.markers;
    work[Unit::kFlexible] += 1;
    work[Unit::kModes] += m;
    work[Unit::kModeSquares] += m * m;
    work[Unit::kModeCubes] += m * m * m;
    work[Unit::kMarkers] += markers;
    work[Unit::kMarkerModes] += markers * m;
    work[Unit::kMarkerModeSquares] += markers * m * m;
  }
  for (const PlanVarying& body : plan.varying) {
    work[Unit::kVarying] += 1;
    work[Unit::kCorners] += 1 + static_cast<double>(std::bit_width(static_cast<unsigned>(body.count)));
    work[Unit::kVaryingKnots] += static_cast<double>(std::bit_width(static_cast<unsigned>(body.count)));
  }
}

// One value of a profile.
void count_profile(const PlanProfile& profile, Work& work) {
  if (profile.kind == Profile::Kind::kExponential) work[Unit::kExponentials] += 1;
  if (profile.kind == Profile::Kind::kHarmonic) work[Unit::kHarmonics] += profile.count;
  if (profile.kind == Profile::Kind::kTable)
    work[Unit::kLoadTables] += 1 + static_cast<double>(std::bit_width(static_cast<unsigned>(profile.count)));
}

// What switches an element.
Course get_element_course(const PlanData& plan, std::int32_t element) {
  return {{plan.element_scales[at(element)]}, list_changes(plan, [&](const Action& action) {
            return (action.kind == Action::Kind::kSwitch || action.kind == Action::Kind::kRamp) &&
                   action.subject == element;
          })};
}

// Loads that are on at one time.
class LoadCount {
 public:
  explicit LoadCount(const PlanData& plan)
      : plan_(plan), spans_(list_on_spans(plan)), predecessors_(list_predecessors(plan)) {
    for (const PlanLoad& load : plan.loads) courses_.push_back(get_element_course(plan, load.element));
  }

  // The most of each unit at any time: the beginning of some span.
  void add_most(Work& work) const {
    Work most;
    for (const PlanLoad& load : plan_.loads)
      for (const OnSpan& span : spans_[at(load.element)]) {
        const Work own = count_at(span.from);
        for (std::size_t i = 0; i < kUnits; ++i) most.counts[i] = std::max(most.counts[i], own.counts[i]);
      }
    for (std::size_t i = 0; i < kUnits; ++i) work.counts[i] += most.counts[i];
  }

 private:
  bool may_be_on(std::int32_t element, double t) const {
    return std::any_of(spans_[at(element)].begin(), spans_[at(element)].end(),
                       [&](const OnSpan& span) { return span.from <= t && t <= span.to; });
  }

  Work count_at(double t) const {
    // Of each profile the load that read it last: the next one reads the kept value if its own time is the same.
    std::vector<std::int32_t> last(plan_.profiles.size(), kNone);
    std::vector<Work> of_elements(plan_.element_scales.size());
    for (std::size_t i = 0; i < plan_.loads.size(); ++i) {
      const PlanLoad& load = plan_.loads[i];
      if (!may_be_on(load.element, t)) continue;
      std::int32_t& before = last[at(load.profile)];
      const bool kept = before != kNone && courses_[at(before)] == courses_[i];
      add_load(load, kept, of_elements[at(load.element)]);
      before = static_cast<std::int32_t>(i);
    }
    Work work;
    for (std::size_t e = 0; e < of_elements.size(); ++e) {
      Work& own = of_elements[e];
      if (predecessors_[e] != kNone) {  // never together: the one that has more
        Work& other = of_elements[at(predecessors_[e])];
        for (std::size_t i = 0; i < kUnits; ++i)
          own.counts[i] = std::max(own.counts[i], std::exchange(other.counts[i], 0));
      }
    }
    for (const Work& own : of_elements)
      for (std::size_t i = 0; i < kUnits; ++i) work.counts[i] += own.counts[i];
    return work;
  }

  void add_load(const PlanLoad& load, bool kept, Work& work) const {
    work[Unit::kOnLoads] += 1;
    if (!load.apart) work[Unit::kAttachedLoads] += 1;
    if (load.apart || load.consumption != 0) work[Unit::kApartLoads] += 1;
    if (load.law != kNone) work[Unit::kLawLoads] += 1;
    if (!kept) count_profile(plan_.profiles[at(load.profile)], work);
  }

  const PlanData& plan_;
  std::vector<std::vector<OnSpan>> spans_;  // of each element
  std::vector<std::int32_t> predecessors_;  // likewise
  std::vector<Course> courses_;             // of each load
};

void count_loads(const PlanData& plan, Work& work) {
  work[Unit::kLoads] += static_cast<double>(plan.loads.size());
  LoadCount(plan).add_most(work);
  // Once more for each search of their points; that of one table takes two bisections, that of four switches one.
  if (plan.time_corners) work[Unit::kCorners] += 0.25 * static_cast<double>(plan.element_scales.size());
  for (const PlanLoad& load : plan.loads)
    if (const PlanProfile& profile = plan.profiles[at(load.profile)];
        load.law == kNone && profile.kind == Profile::Kind::kTable)
      work[Unit::kCorners] += 1 + static_cast<double>(std::bit_width(static_cast<unsigned>(profile.count)));
}

// Of the bodies near a planet, with what gravity and its torque need.
void count_planet(const PlanData& plan, Work& work) {
  if (!plan.environment.exists) return;
  const PlanPlanet& planet = plan.environment.planet;
  double bodies = 0;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const std::int32_t flexible = plan.bodies[b].flexible;
    const bool marker = flexible != kNone && at(plan.flexible[at(flexible)].body) != b;
    work[Unit::kPlanetBodies] += 1;
    if (!marker) bodies += 1;
  }
  const double torques = planet.gradient_torque ? bodies : 0;
  work[Unit::kPlanetWeights] = bodies;
  work[Unit::kPlanetTorques] = torques;
  if (planet.j2 != 0) work[Unit::kPlanetZonals] = bodies + torques;
  if (planet.falling) work[Unit::kPlanetFalls] = 1;
}

using geometry::ShapeKind;

bool is_round(const geometry::ShapeNumbers& shape) {
  return shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule || shape.kind == ShapeKind::kHalfSpace;
}

// Units of pairs of shapes: three in a row, from those of round ones on.
void count_shape_pair(const PlanData& plan, std::size_t a, std::size_t b, Unit round, Work& work) {
  const geometry::ShapeNumbers &x = plan.shape_parts[a], &y = plan.shape_parts[b];
  const int convex = is_round(x) && is_round(y) ? 0 : 1;
  const int kind = x.kind == ShapeKind::kHollow || y.kind == ShapeKind::kHollow ? 2 : convex;
  work[static_cast<Unit>(static_cast<int>(round) + kind)] += 1;
}
void count_surface_pairs(const PlanData& plan, std::int32_t first, std::int32_t second, Unit round, Work& work) {
  const PlanShapes &a = plan.shapes[at(first)], &b = plan.shapes[at(second)];
  for (std::int32_t i = 0; i < a.count; ++i)
    for (std::int32_t k = 0; k < b.count; ++k) count_shape_pair(plan, at(a.first + i), at(b.first + k), round, work);
}

// True of an angle whose gradient is not its axis in some mode (calc_angle_gradient()).
bool has_gradient(const PlanData& plan, std::int32_t coordinate) {
  const PlanCoordinate& c = plan.coordinates[at(coordinate)];
  if (c.row < kRotX) return false;
  const PlanJoint& joint = plan.joints[at(c.joint)];
  return !std::ranges::all_of(get_modes(plan, c.joint),
                              [&](RowSet rows) { return has_plain_angle(joint, rows, c.row); });
}

void count_coordinates(const PlanData& plan, Coordinates set, Work& work) {
  const std::size_t count = set == Coordinates::kAll ? plan.coordinates.size() : at(plan.driven_coordinates);
  for (const PlanCoordinate& c : std::span(plan.coordinates).first(count)) {
    const bool rotates = c.row >= kRotX, universal = plan.joints[at(c.joint)].universal;
    work[!rotates ? Unit::kDisplacements : (universal ? Unit::kUniversalAngles : Unit::kAngles)] += 1;
  }
  work[Unit::kAngleEights] = std::ceil((work[Unit::kAngles] + work[Unit::kUniversalAngles]) / kEight);
  // A gradient costs less than an angle about a cross.
  for (std::int32_t i = 0; at(i) < count; ++i) work[Unit::kUniversalAngles] += has_gradient(plan, i) ? 1 : 0;
}

static_assert(kElementKinds == 8, "a new kind has a unit, which count_elements() counts");

// Rows of the parts that are implicit in the forces of contacts.
void count_contact_rows(const PlanData& plan, Work& work) {
  if (!may_be_implicit(plan)) return;
  const auto rows = static_cast<double>(kRowsPerPair * std::min(plan.contact_pairs.size(), kMostImplicitPairs));
  work[Unit::kContactRows] = rows;
  work[Unit::kContactRowPairs] = rows * rows;
  work[Unit::kContactRowCubes] = rows * rows * rows;
  work[Unit::kContactRowBodies] = rows * static_cast<double>(plan.bodies.size());
}

// Rows of closed rigid contacts, at most.
void count_rigid(const PlanData& plan, Work& work) {
  const double rows = std::min(count_rigid_rows(plan), kMostRigidRows);
  work[Unit::kRigidPairs] = plan.rigid_pairs;
  work[Unit::kRigidRows] = rows;
  work[Unit::kRigidRowPairs] = rows * rows;
  work[Unit::kRigidRowCubes] = rows * rows * rows;
  work[Unit::kRigidRowBodies] = rows > 0 ? static_cast<double>(plan.bodies.size()) : 0;
}

// An element whose torque is along a gradient costs less than two along their axes.
double count_turns(const PlanData& plan, std::int32_t coordinate) { return has_gradient(plan, coordinate) ? 2 : 1; }

void count_elements(const PlanData& plan, Work& work) {
  count_loads(plan, work);
  const auto set = [&](Unit unit, std::size_t count) { work[unit] = static_cast<double>(count); };
  set(Unit::kPointSprings, plan.point_springs.size());
  for (const PlanJointSpring& own : plan.joint_springs)
    work[own.axis < kRotX ? Unit::kSlideSprings : Unit::kTurnSprings] += count_turns(plan, own.coordinate);
  set(Unit::kPlaneTorsions, plan.plane_torsions.size());
  for (const PlanOneSided& own : plan.one_sided) {
    const Unit in_joint = own.axis < kRotX ? Unit::kJointOneSided : Unit::kTurnOneSided;
    work[own.joint == kNone ? Unit::kPointOneSided : in_joint] +=
        own.joint == kNone ? 1 : count_turns(plan, own.coordinate);
  }
  set(Unit::kCords, plan.drums.size());
  for (const PlanFriction& own : plan.frictions) work[Unit::kFrictions] += count_turns(plan, own.coordinate);
  set(Unit::kAerodynamics, plan.aerodynamics.size());
  set(Unit::kAeroTerms, plan.aero_terms.size());
  set(Unit::kCompliant, plan.compliant.size());
  count_planet(plan, work);
  set(Unit::kContacts, plan.contacts.size());
  count_rigid(plan, work);
  count_contact_rows(plan, work);
  for (const PlanOneSided& own : plan.one_sided)
    if (own.count > 0)
      work[Unit::kOneSidedTables] += static_cast<double>(std::bit_width(static_cast<unsigned>(own.count)));
  for_each_travel_corner(plan, [&](const PlanOneSided& own, std::span<const double>) {
    work[Unit::kCorners] += 1 + static_cast<double>(std::bit_width(static_cast<unsigned>(own.count)));
  });
  for (const ContactPair& pair : plan.contact_pairs) {
    const PlanContact& contact = plan.contacts[at(pair.contact)];
    count_shape_pair(plan, at(plan.shapes[at(contact.base)].first + pair.base_shape),
                     at(plan.shapes[at(contact.follower)].first + pair.follower_shape), Unit::kRoundPairs, work);
  }
}

// Units of quantities are in this order, once for each reader.
enum class QuantityUnit {
  kBody,
  kAttitude,
  kJoint,
  kElement,
  kContact,
  kPlain,
  kFlight,
  kAngle,
  kFalling,
  kAir,
  kRound
};
static_assert(static_cast<int>(Unit::kReadRoundDistances) ==
              static_cast<int>(Unit::kReadBodyQuantities) + static_cast<int>(QuantityUnit::kRound));
Unit get_unit(Unit first, QuantityUnit own) {
  return static_cast<Unit>(static_cast<int>(first) + static_cast<int>(own));
}

QuantityUnit get_quantity_unit(Quantity::Kind kind, SubjectOf of) {
  using enum QuantityUnit;
  using Kind = Quantity::Kind;
  switch (of) {
    case SubjectOf::kBody:
      return kind == Kind::kAttitude || kind == Kind::kAxes ? kAttitude : kBody;
    case SubjectOf::kJoint:
      return kJoint;
    case SubjectOf::kElement:
    case SubjectOf::kOneSided:
    case SubjectOf::kCord:
      return kElement;
    case SubjectOf::kContact:
      return kind == Kind::kContactForce || kind == Kind::kContactDepth ? kContact : kPlain;
    default:
      return kPlain;
  }
}

// True of a quantity beside the planet with an arctangent, or with the planet's turn.
bool has_angle(Quantity::Kind kind) {
  using Kind = Quantity::Kind;
  switch (kind) {
    case Kind::kLatitude:
    case Kind::kGeocentricLatitude:
    case Kind::kLongitude:
    case Kind::kAngleOfAttack:
    case Kind::kSideslip:
    case Kind::kFlightPathAngle:
    case Kind::kAzimuth:
    case Kind::kInertialFlightPathAngle:
    case Kind::kInertialAzimuth:
    case Kind::kEulerAngles:
    case Kind::kLaunchPosition:
    case Kind::kLaunchVelocity:
      return true;
    default:
      return false;
  }
}

// `first`: the unit of bodies' quantities of who reads it.
void count_quantity(const PlanData& plan, std::int32_t quantity, Unit first, Work& work) {
  using enum QuantityUnit;
  const PlanQuantity& own = plan.quantities[at(quantity)];
  const QuantityTraits& traits = get_traits(own.kind);
  const auto add = [&](QuantityUnit unit) { work[get_unit(first, unit)] += 1; };
  add(get_quantity_unit(own.kind, traits.of));
  if (traits.of_planet) add(kFlight);
  if (traits.of_planet && has_angle(own.kind)) add(kAngle);
  if (traits.of_planet && plan.environment.planet.falling) add(kFalling);
  if (traits.of_air) add(kAir);
  if (own.kind == Quantity::Kind::kClearance)
    count_surface_pairs(plan, own.subject, own.other, get_unit(first, kRound), work);
}

void count_table(const PlanLaws& laws, const PlanTable& table, Work& work) {
  double values = 1;
  for (std::int32_t i = 0; i < table.axis_count; ++i) {
    const PlanTableAxis& axis = laws.axes[at(table.first_axis + i)];
    values *= axis.support;
    work[Unit::kTableAxes] += 1 + static_cast<double>(std::bit_width(static_cast<unsigned>(axis.count)));
  }
  work[Unit::kTableValues] += values;
}

void count_laws(const PlanData& plan, Work& work) {
  using Kind = LawStep::Kind;
  for (const PlanLawStep& step : plan.laws.steps) {
    work[Unit::kLawSteps] += 1;
    switch (step.kind) {
      case Kind::kTable:
        count_table(plan.laws, plan.laws.tables[at(step.subject)], work);
        break;
      case Kind::kPower:
        work[Unit::kLawSteps] += std::abs(step.subject);
        break;
      case Kind::kSin:
      case Kind::kCos:
      case Kind::kTan:
      case Kind::kAsin:
      case Kind::kAcos:
      case Kind::kAtan:
      case Kind::kAtan2:
      case Kind::kExp:
      case Kind::kLog:
        work[Unit::kLawFunctions] += 1;
        break;
      default:
        break;
    }
  }
  for (const PlanCorner& corner : plan.laws.corners)
    work[Unit::kCorners] += 1 + static_cast<double>(std::bit_width(static_cast<unsigned>(corner.count)));
  if (!plan.air_corners.empty())
    work[Unit::kCorners] += static_cast<double>(plan.aerodynamics.size()) *
                            (1 + static_cast<double>(std::bit_width(plan.air_corners.size())));
  for (const std::int32_t operand : plan.laws.operands) count_quantity(plan, operand, Unit::kLawBodyQuantities, work);
  work[Unit::kBranches] = plan.law_numbers.places;
}

// Conditions that are compared with a quantity by its number: kernel/events/guards.cc, calc_elementary().
bool reads_quantity(Condition::Kind kind) {
  const ConditionCourse course = get_traits(kind).course;
  return !get_traits(kind).by_guards && course != ConditionCourse::kParts;
}

void count_events(const PlanData& plan, Work& work) {
  work[Unit::kEvents] = static_cast<double>(plan.events.size());
  work[Unit::kTimedEvents] = static_cast<double>(plan.timed_events.size() + plan.repeating_events.size());
  work[Unit::kConditions] = static_cast<double>(plan.conditions.size());
  for (const PlanCondition& condition : plan.conditions) {
    if (condition.kind == Condition::Kind::kReach) work[Unit::kReaches] += 1;
    if (reads_quantity(condition.kind)) count_quantity(plan, condition.subject, Unit::kGuardBodyQuantities, work);
  }
  work[Unit::kActions] = static_cast<double>(plan.actions.size());
  work[Unit::kImpulses] = static_cast<double>(plan.impulses.size());
  work[Unit::kGuards] = static_cast<double>(plan.events.size() + plan.contact_pairs.size());
  for (std::int32_t i = 0; i < plan.quantity_count; ++i) count_quantity(plan, i, Unit::kReadBodyQuantities, work);
  for (const PlanSensor& sensor : plan.sensors) count_quantity(plan, sensor.quantity, Unit::kReadBodyQuantities, work);
  work[Unit::kSensors] = plan.sensor_count;
}

}  // namespace

Work count_work(const Plan& owner, int lanes, Coordinates coordinates) {
  const PlanData& plan = get_data(owner);
  Work work;
  work[Unit::kOne] = 1;
  work[Unit::kStateWords] = static_cast<double>(owner.get_state_bytes()) / 8;
  work[Unit::kCarriedPlaces] = static_cast<double>(plan.initial_auxiliary.size());
  count_bodies(plan, lanes, work);
  for (const Group& group : plan.groups) count_group(plan, group, lanes, work);
  work[Unit::kBegins] = static_cast<double>(plan.inner_groups.size());
  count_loops(owner, plan, lanes, work);
  count_varying_bodies(plan, work);
  count_elements(plan, work);
  count_coordinates(plan, coordinates, work);
  count_laws(plan, work);
  count_events(plan, work);
  return work;
}

}  // namespace unlatch::cost
