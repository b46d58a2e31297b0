#include "kernel/cost/work.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "kernel/elements/kinds/contact/contact_parts.h"
#include "kernel/elements/kinds/kinds.h"
#include "kernel/geometry/compiled_shape.h"
#include "kernel/integration/contact_stages.h"
#include "unlatch/quantities.h"
#include "unlatch/redundancy.h"

namespace unlatch::cost {

const std::array<const char*, kUnits> kUnitNames = {
    "one",
    "bodies 1",
    "bodies 2",
    "bodies 4",
    "joints 1",
    "joints 2",
    "joints 4",
    "leaves 1",
    "leaves 2",
    "leaves 4",
    "inner 1",
    "inner 2",
    "inner 4",
    "central",
    "loaded",
    "own rotation axes",
    "universal",
    "base child",
    "gather",
    "siblings",
    "carried axes",
    "joint freedoms",
    "freedoms",
    "freedom pairs",
    "by rows",
    "rows",
    "row pairs",
    "pivots",
    "end siblings",
    "inner freedoms",
    "inner by rows",
    "inner rows",
    "body count",
    "joint count",
    "state words",
    "carried places",
    "filled lanes",
    "loops",
    "loop rows",
    "loop nodes",
    "loop products",
    "loop slots",
    "loop links",
    "loop solutions",
    "split rows",
    "split products",
    "flexible",
    "modes",
    "mode squares",
    "mode cubes",
    "markers",
    "marker modes",
    "marker mode squares",
    "varying",
    "varying knots",
    "loads",
    "exponentials",
    "harmonics",
    "load tables",
    "apart loads",
    "law loads",
    "point springs",
    "joint springs",
    "plane torsions",
    "one sided",
    "one sided tables",
    "cords",
    "frictions",
    "aerodynamics",
    "aero terms",
    "compliant",
    "displacements",
    "angles",
    "universal angles",
    "angle eights",
    "planet bodies",
    "contacts",
    "round pairs",
    "convex pairs",
    "hollow pairs",
    "contact rows",
    "contact row pairs",
    "contact row cubes",
    "contact row bodies",
    "pairs of rigid contacts",
    "law steps",
    "law functions",
    "table axes",
    "table values",
    "corners",
    "branches",
    "events",
    "timed events",
    "conditions",
    "reaches",
    "distances",
    "actions",
    "impulses",
    "guards",
    "body quantities",
    "attitude quantities",
    "joint quantities",
    "element quantities",
    "contact quantities",
    "plain quantities",
    "flight quantities",
    "air quantities",
    "sensors",
};

namespace {

// Passes by the lanes of their pack: the unit for one lane, and behind it those for two and for more.
Unit by_lanes(Unit one, int pack) { return static_cast<Unit>(static_cast<int>(one) + std::min(pack / 2, 2)); }

void count_bodies(const PlanData& plan, int lanes, Work& work) {
  for (const BodyEight& eight : plan.eights) {
    const int used = static_cast<int>(std::bit_width(eight.used));
    const int pack = std::min(lanes, static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(used, 1)))));
    const int passes = (used + pack - 1) / pack;
    work[by_lanes(Unit::kBodies1, pack)] += passes;
    if (plan.gravity.mu != 0) work[Unit::kCentral] += passes;
    if (eight.loaded) work[Unit::kLoaded] += passes;
  }
  work[Unit::kBodyCount] = static_cast<double>(plan.bodies.size());
  work[Unit::kJointCount] = static_cast<double>(plan.joints.size());
}

void count_group(const Group& group, int lanes, Work& work) {
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
  if (group.siblings_end) work[Unit::kEndSiblings] += 1;
  if (group.kind != BodyKind::kRigid) return;
  work[by_lanes(group.leaf ? Unit::kLeaves1 : Unit::kInner1, pack)] += passes;
  const int freedoms = std::popcount(group.freedoms), rows = std::popcount(group.rows);
  work[Unit::kFreedoms] += passes * freedoms;
  work[Unit::kFreedomPairs] += passes * freedoms * (freedoms + 1) / 2;
  if (group.may_be_by_rows || !group.has_joint) work[Unit::kByRows] += passes;
  work[Unit::kRows] += passes * rows;
  work[Unit::kRowPairs] += passes * rows * (rows - 1) / 2;
  work[Unit::kPivots] += passes * std::popcount(group.compliant);
  if (group.leaf) return;
  work[Unit::kInnerFreedoms] += passes * freedoms;
  if (group.may_be_by_rows || !group.has_joint) work[Unit::kInnerByRows] += passes;
  work[Unit::kInnerRows] += passes * rows;
}

void count_loops(const Plan& owner, const PlanData& plan, Work& work) {
  work[Unit::kLoops] = static_cast<double>(plan.non_tree_joints.size());
  if (plan.loops.empty()) return;
  const double rows = plan.loop_rows, tree_rows = plan.ring_rows, nodes = static_cast<double>(plan.loop_nodes.size());
  work[Unit::kLoopRows] = rows;
  work[Unit::kLoopNodes] = nodes;
  work[Unit::kLoopProducts] = static_cast<double>(calc_loop_cost(owner).loops);
  work[Unit::kLoopSlots] = static_cast<double>(plan.loop_slots.size());
  work[Unit::kLoopLinks] = static_cast<double>(plan.loop_links.size() + plan.loop_pairs.size());
  work[Unit::kLoopSolutions] = plan.closures.empty() ? rows * (rows + nodes) : 0;
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

void count_loads(const PlanData& plan, Work& work) {
  for (const PlanLoad& load : plan.loads) {
    work[Unit::kLoads] += 1;
    if (load.apart || load.consumption != 0) work[Unit::kApartLoads] += 1;
    if (load.law != kNone) work[Unit::kLawLoads] += 1;
  }
  // Once more for each search of their points; that of one table takes two bisections, that of four switches one.
  if (plan.time_corners) work[Unit::kCorners] += 0.25 * static_cast<double>(plan.element_scales.size());
  for (const PlanLoad& load : plan.loads)
    if (const PlanProfile& profile = plan.profiles[at(load.profile)];
        load.law == kNone && profile.kind == Profile::Kind::kTable)
      work[Unit::kCorners] += 1 + static_cast<double>(std::bit_width(static_cast<unsigned>(profile.count)));
  for (const PlanProfile& profile : plan.profiles) {
    if (profile.kind == Profile::Kind::kExponential) work[Unit::kExponentials] += 1;
    if (profile.kind == Profile::Kind::kHarmonic) work[Unit::kHarmonics] += profile.count;
    if (profile.kind == Profile::Kind::kTable)
      work[Unit::kLoadTables] += static_cast<double>(std::bit_width(static_cast<unsigned>(profile.count)));
  }
}

using geometry::ShapeKind;

bool is_round(const geometry::ShapeNumbers& shape) {
  return shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule || shape.kind == ShapeKind::kHalfSpace;
}

// Pairs of the shapes of two surfaces.
void count_shape_pair(const PlanData& plan, std::size_t a, std::size_t b, Work& work) {
  const geometry::ShapeNumbers &x = plan.shape_parts[a], &y = plan.shape_parts[b];
  if (x.kind == ShapeKind::kHollow || y.kind == ShapeKind::kHollow)
    work[Unit::kHollowPairs] += 1;
  else if (is_round(x) && is_round(y))
    work[Unit::kRoundPairs] += 1;
  else
    work[Unit::kConvexPairs] += 1;
}
void count_surface_pairs(const PlanData& plan, std::int32_t first, std::int32_t second, Work& work) {
  const PlanShapes &a = plan.shapes[at(first)], &b = plan.shapes[at(second)];
  for (std::int32_t i = 0; i < a.count; ++i)
    for (std::int32_t k = 0; k < b.count; ++k) count_shape_pair(plan, at(a.first + i), at(b.first + k), work);
}

void count_coordinates(const PlanData& plan, Coordinates set, Work& work) {
  const std::size_t count = set == Coordinates::kAll ? plan.coordinates.size() : at(plan.driven_coordinates);
  for (const PlanCoordinate& c : std::span(plan.coordinates).first(count)) {
    const bool rotates = c.row >= kRotX, universal = plan.joints[at(c.joint)].universal;
    work[!rotates ? Unit::kDisplacements : (universal ? Unit::kUniversalAngles : Unit::kAngles)] += 1;
  }
  work[Unit::kAngleEights] = std::ceil((work[Unit::kAngles] + work[Unit::kUniversalAngles]) / kEight);
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

void count_elements(const PlanData& plan, Work& work) {
  count_loads(plan, work);
  const auto set = [&](Unit unit, std::size_t count) { work[unit] = static_cast<double>(count); };
  set(Unit::kPointSprings, plan.point_springs.size());
  set(Unit::kJointSprings, plan.joint_springs.size());
  set(Unit::kPlaneTorsions, plan.plane_torsions.size());
  set(Unit::kOneSided, plan.one_sided.size());
  set(Unit::kCords, plan.drums.size());
  set(Unit::kFrictions, plan.frictions.size());
  set(Unit::kAerodynamics, plan.aerodynamics.size());
  set(Unit::kAeroTerms, plan.aero_terms.size());
  set(Unit::kCompliant, plan.compliant.size());
  set(Unit::kPlanetBodies, plan.environment.exists ? plan.bodies.size() : 0);
  set(Unit::kContacts, plan.contacts.size());
  set(Unit::kRigidContacts, at(plan.rigid_pairs));
  count_contact_rows(plan, work);
  for (const PlanOneSided& own : plan.one_sided)
    if (own.count > 0)
      work[Unit::kOneSidedTables] += static_cast<double>(std::bit_width(static_cast<unsigned>(own.count)));
  for (const ContactPair& pair : plan.contact_pairs) {
    const PlanContact& contact = plan.contacts[at(pair.contact)];
    count_shape_pair(plan, at(plan.shapes[at(contact.base)].first + pair.base_shape),
                     at(plan.shapes[at(contact.follower)].first + pair.follower_shape), work);
  }
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
  work[Unit::kFlightQuantities] += static_cast<double>(plan.laws.air_places.size());
  work[Unit::kBranches] = plan.law_numbers.places;
}

Unit get_quantity_unit(Quantity::Kind kind, SubjectOf of) {
  switch (of) {
    case SubjectOf::kBody:
      return kind == Quantity::Kind::kAttitude || kind == Quantity::Kind::kAxes ? Unit::kAttitudeQuantities
                                                                                : Unit::kBodyQuantities;
    case SubjectOf::kJoint:
      return Unit::kJointQuantities;
    case SubjectOf::kElement:
    case SubjectOf::kOneSided:
    case SubjectOf::kCord:
      return Unit::kElementQuantities;
    case SubjectOf::kContact:
      return kind == Quantity::Kind::kContactForce || kind == Quantity::Kind::kContactDepth ? Unit::kContactQuantities
                                                                                            : Unit::kPlainQuantities;
    default:
      return Unit::kPlainQuantities;
  }
}

void count_quantity(const PlanData& plan, const PlanQuantity& own, Work& work) {
  const QuantityTraits& traits = get_traits(own.kind);
  work[get_quantity_unit(own.kind, traits.of)] += 1;
  if (traits.of_planet) work[Unit::kFlightQuantities] += 1;
  if (traits.of_air) work[Unit::kAirQuantities] += 1;
  if (own.kind == Quantity::Kind::kClearance) {
    work[Unit::kDistances] += 1;
    count_surface_pairs(plan, own.subject, own.other, work);
  }
}

void count_events(const PlanData& plan, Work& work) {
  work[Unit::kEvents] = static_cast<double>(plan.events.size());
  work[Unit::kTimedEvents] = static_cast<double>(plan.timed_events.size() + plan.repeating_events.size());
  work[Unit::kConditions] = static_cast<double>(plan.conditions.size());
  for (const PlanCondition& condition : plan.conditions)
    if (condition.kind == Condition::Kind::kReach) work[Unit::kReaches] += 1;
  work[Unit::kActions] = static_cast<double>(plan.actions.size());
  work[Unit::kImpulses] = static_cast<double>(plan.impulses.size());
  work[Unit::kGuards] = static_cast<double>(plan.events.size() + plan.contact_pairs.size());
  for (const PlanQuantity& own : plan.quantities) count_quantity(plan, own, work);
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
  for (const Group& group : plan.groups) count_group(group, lanes, work);
  count_loops(owner, plan, work);
  count_varying_bodies(plan, work);
  count_elements(plan, work);
  count_coordinates(plan, coordinates, work);
  count_laws(plan, work);
  count_events(plan, work);
  return work;
}

}  // namespace unlatch::cost
