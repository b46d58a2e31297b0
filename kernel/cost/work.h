// The work of a step, counted from a plan alone, in units whose instructions are measured for each target: passes over
// blocks of bodies and groups of joints, elements by kind, modes of flexible bodies, pairs of shapes. A unit is counted
// with the most that any mode of the joints can need.
#pragma once

#include <array>
#include <cstdint>

#include "kernel/plan/plan_data.h"

namespace unlatch::cost {

enum class Unit : std::int32_t {
  kOne,
  // passes over blocks of eight bodies, groups of joints and their nodes, by the lanes of a pack: one, two, more
  kBodies1,
  kBodies2,
  kBodies4,
  kJoints1,
  kJoints2,
  kJoints4,
  kLeaves1,
  kLeaves2,
  kLeaves4,
  kInner1,
  kInner2,
  kInner4,
  // of passes over bodies
  kCentral,
  kLoaded,
  // of passes over joints
  kOwnRotationAxes,
  kUniversal,
  kBaseChild,
  kGather,
  kSiblings,
  kCarriedAxes,
  kJointFreedoms,
  // of passes over nodes
  kFreedoms,
  kFreedomPairs,
  kByRows,
  kRows,
  kRowPairs,
  kPivots,
  kEndSiblings,
  kInnerFreedoms,
  kInnerByRows,
  kInnerRows,
  // single bodies, joints and numbers
  kBodyCount,
  kJointCount,
  kStateWords,
  kCarriedPlaces,
  kFilledLanes,
  // closed loops
  kLoops,
  kLoopRows,
  kLoopNodes,
  kLoopProducts,
  kLoopSlots,
  kLoopLinks,
  kLoopSolutions,
  kSplitRows,
  kSplitProducts,
  // bodies that bend or burn
  kFlexible,
  kModes,
  kModeSquares,
  kModeCubes,
  kMarkers,
  kMarkerModes,
  kMarkerModeSquares,
  kVarying,
  kVaryingKnots,
  // elements
  kLoads,
  kExponentials,
  kHarmonics,
  kLoadTables,
  kApartLoads,
  kLawLoads,
  kPointSprings,
  kJointSprings,
  kPlaneTorsions,
  kOneSided,
  kOneSidedTables,
  kCords,
  kFrictions,
  kAerodynamics,
  kAeroTerms,
  kCompliant,
  kDisplacements,
  kAngles,
  kUniversalAngles,
  kAngleEights,
  kPlanetBodies,
  // pairs of shapes: both round; else convex; one hollow; rows of those whose parts may be
  // implicit, their pairs, and rows by bodies; pairs of rigid contacts
  kContacts,
  kRoundPairs,
  kConvexPairs,
  kHollowPairs,
  kContactRows,
  kContactRowPairs,
  kContactRowCubes,
  kContactRowBodies,
  kRigidContacts,
  // laws
  kLawSteps,
  kLawFunctions,
  kTableAxes,
  kTableValues,
  kCorners,
  kBranches,
  // events and what is read
  kEvents,
  kTimedEvents,
  kConditions,
  kReaches,
  kDistances,
  kActions,
  kImpulses,
  kGuards,
  kBodyQuantities,
  kAttitudeQuantities,
  kJointQuantities,
  kElementQuantities,
  kContactQuantities,
  kPlainQuantities,
  kFlightQuantities,
  kAirQuantities,
  kSensors,
  kCount,
};
inline constexpr std::size_t kUnits = static_cast<std::size_t>(Unit::kCount);
extern const std::array<const char*, kUnits> kUnitNames;

struct Work {
  std::array<double, kUnits> counts{};
  double& operator[](Unit unit) { return counts[static_cast<std::size_t>(unit)]; }
  double operator[](Unit unit) const { return counts[static_cast<std::size_t>(unit)]; }
};

// Coordinates that the stages of an integration read, for springs, are the first of those that an evaluation reads.
enum class Coordinates { kAll, kDriven };

// `lanes`: numbers that the widest pack of the target holds, 1 to 8.
Work count_work(const Plan& plan, int lanes, Coordinates coordinates = Coordinates::kAll);

}  // namespace unlatch::cost
