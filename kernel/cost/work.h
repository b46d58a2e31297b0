// The work of a step, counted from a plan alone, in units whose instructions are measured for each target: passes over
// blocks of bodies and groups of joints, elements by kind, modes of flexible bodies, pairs of shapes. A unit is counted
// with the most that any mode of the joints can need.
#pragma once

#include <array>
#include <cstdint>

#include "kernel/plan/plan_data.h"

namespace unlatch::cost {

// clang-format off
// All units: X(name, text for readers). Their only list: tools/cost reads it here.
#define UNLATCH_COST_UNITS(X) \
  X(One, "one") \
  /* passes over blocks of eight bodies, groups of joints and their nodes, by the lanes of a pack: one, two, more */ \
  X(Bodies1, "bodies 1") \
  X(Bodies2, "bodies 2") \
  X(Bodies4, "bodies 4") \
  X(Joints1, "joints 1") \
  X(Joints2, "joints 2") \
  X(Joints4, "joints 4") \
  X(Leaves1, "leaves 1") \
  X(Leaves2, "leaves 2") \
  X(Leaves4, "leaves 4") \
  X(Inner1, "inner 1") \
  X(Inner2, "inner 2") \
  X(Inner4, "inner 4") \
  /* of passes over bodies */ \
  X(Central, "central") \
  X(Loaded, "loaded") \
  X(LoadedEights, "loaded eights") \
  /* of passes over joints */ \
  X(OwnRotationAxes, "own rotation axes") \
  X(Universal, "universal") \
  X(BaseChild, "base child") \
  X(Gather, "gather") \
  X(Contiguous, "contiguous") \
  X(Roots, "roots") \
  X(Begins, "begins") \
  X(Siblings, "siblings") \
  X(CarriedAxes, "carried axes") \
  X(JointFreedoms, "joint freedoms") \
  /* of passes over nodes */ \
  X(ByFreedoms, "by freedoms") \
  X(Singles, "singles") \
  X(Freedoms, "freedoms") \
  X(Turns, "turns") \
  X(LaterFreedoms, "later freedoms") \
  X(ByRows, "by rows") \
  X(Rows, "rows") \
  X(RowPairs, "row pairs") \
  X(Masks, "masks") \
  X(Pivots, "pivots") \
  X(EndSiblings, "end siblings") \
  X(InnerByFreedoms, "inner by freedoms") \
  X(InnerFreedoms, "inner freedoms") \
  X(InnerByRows, "inner by rows") \
  X(InnerRows, "inner rows") \
  /* single bodies, joints and numbers */ \
  X(BodyCount, "body count") \
  X(JointCount, "joint count") \
  X(StateWords, "state words") \
  X(CarriedPlaces, "carried places") \
  X(FilledLanes, "filled lanes") \
  /* closed loops */ \
  X(Loops, "loops") \
  X(StageLoops, "loops that hold") \
  X(DenseLoops, "dense loops") \
  X(DenseRows, "dense rows") \
  X(DenseNodes, "dense nodes") \
  X(DensePacks, "dense packs") \
  X(DensePivots, "dense pivots") \
  X(DensePivotPacks, "dense pivot packs") \
  X(DenseProducts, "dense products") \
  X(DenseSquares, "dense squares") \
  X(DenseCubes, "dense cubes") \
  X(DensePasses, "dense passes") \
  X(DenseByFreedoms, "dense by freedoms") \
  X(DenseFreedoms, "dense freedoms") \
  X(DenseByRows, "dense by rows") \
  X(DenseByNodeRows, "dense by node rows") \
  X(Closures, "closures") \
  X(ClosureRows, "closure rows") \
  X(ClosureCubes, "closure cubes") \
  X(ClusterNodes, "cluster nodes") \
  X(ClusterSlots, "cluster slots") \
  X(ClusterLinks, "cluster links") \
  X(ClusterPairs, "cluster pairs") \
  X(ClusterPivots, "cluster pivots") \
  X(ClusterPivotPairs, "cluster pivot pairs") \
  X(ClusterProducts, "cluster products") \
  X(SplitRows, "split rows") \
  X(SplitProducts, "split products") \
  /* bodies that bend or burn */ \
  X(Flexible, "flexible") \
  X(Modes, "modes") \
  X(ModeSquares, "mode squares") \
  X(ModeCubes, "mode cubes") \
  X(Markers, "markers") \
  X(MarkerModes, "marker modes") \
  X(MarkerModeSquares, "marker mode squares") \
  X(Varying, "varying") \
  X(VaryingKnots, "varying knots") \
  /* elements */ \
  X(Loads, "loads") \
  X(OnLoads, "loads that may be on") \
  X(AttachedLoads, "attached loads") \
  X(Exponentials, "exponentials") \
  X(Harmonics, "harmonics") \
  X(LoadTables, "load tables") \
  X(ApartLoads, "apart loads") \
  X(LawLoads, "law loads") \
  X(PointSprings, "point springs") \
  X(SlideSprings, "slide springs") \
  X(TurnSprings, "turn springs") \
  X(PlaneTorsions, "plane torsions") \
  X(PointOneSided, "one sided") \
  X(JointOneSided, "one sided in joints") \
  X(TurnOneSided, "one sided about joints") \
  X(OneSidedTables, "one sided tables") \
  X(Cords, "cords") \
  X(Frictions, "frictions") \
  X(Aerodynamics, "aerodynamics") \
  X(AeroTerms, "aero terms") \
  X(Compliant, "compliant") \
  X(Displacements, "displacements") \
  X(Angles, "angles") \
  X(UniversalAngles, "universal angles") \
  X(AngleEights, "angle eights") \
  X(PlanetBodies, "planet bodies") \
  X(PlanetWeights, "planet weights") \
  X(PlanetZonals, "planet zonals") \
  X(PlanetFalls, "planet falls") \
  X(PlanetTorques, "planet torques") \
  /* pairs of shapes: both round; else convex; one hollow; rows of those whose parts may be */ \
  /* implicit, their pairs, and rows by bodies; pairs of rigid contacts */ \
  X(Contacts, "contacts") \
  X(RoundPairs, "round pairs") \
  X(ConvexPairs, "convex pairs") \
  X(HollowPairs, "hollow pairs") \
  X(ContactRows, "contact rows") \
  X(ContactRowPairs, "contact row pairs") \
  X(ContactRowCubes, "contact row cubes") \
  X(ContactRowBodies, "contact row bodies") \
  X(RigidRows, "rigid rows") \
  X(RigidRowPairs, "rigid row pairs") \
  X(RigidRowCubes, "rigid row cubes") \
  X(RigidRowBodies, "rigid row bodies") \
  X(RigidPairs, "rigid pairs") \
  /* laws */ \
  X(LawSteps, "law steps") \
  X(LawFunctions, "law functions") \
  X(TableAxes, "table axes") \
  X(TableValues, "table values") \
  X(Corners, "corners") \
  X(Branches, "branches") \
  /* events and what is read */ \
  X(Events, "events") \
  X(TimedEvents, "timed events") \
  X(Conditions, "conditions") \
  X(Reaches, "reaches") \
  X(Actions, "actions") \
  X(Impulses, "impulses") \
  X(Guards, "guards") \
  /* quantities that are read at the end of a step; by conditions; by laws */ \
  X(ReadBodyQuantities, "read body quantities") \
  X(ReadAttitudeQuantities, "read attitude quantities") \
  X(ReadJointQuantities, "read joint quantities") \
  X(ReadElementQuantities, "read element quantities") \
  X(ReadContactQuantities, "read contact quantities") \
  X(ReadPlainQuantities, "read plain quantities") \
  X(ReadFlightQuantities, "read flight quantities") \
  X(ReadFlightAngles, "read flight angles") \
  X(ReadFallingQuantities, "read falling quantities") \
  X(ReadAirQuantities, "read air quantities") \
  X(ReadRoundDistances, "read round distances") \
  X(ReadConvexDistances, "read convex distances") \
  X(ReadHollowDistances, "read hollow distances") \
  X(GuardBodyQuantities, "guarded body quantities") \
  X(GuardAttitudeQuantities, "guarded attitude quantities") \
  X(GuardJointQuantities, "guarded joint quantities") \
  X(GuardElementQuantities, "guarded element quantities") \
  X(GuardContactQuantities, "guarded contact quantities") \
  X(GuardPlainQuantities, "guarded plain quantities") \
  X(GuardFlightQuantities, "guarded flight quantities") \
  X(GuardFlightAngles, "guarded flight angles") \
  X(GuardFallingQuantities, "guarded falling quantities") \
  X(GuardAirQuantities, "guarded air quantities") \
  X(GuardRoundDistances, "guarded round distances") \
  X(GuardConvexDistances, "guarded convex distances") \
  X(GuardHollowDistances, "guarded hollow distances") \
  X(LawBodyQuantities, "law body quantities") \
  X(LawAttitudeQuantities, "law attitude quantities") \
  X(LawJointQuantities, "law joint quantities") \
  X(LawElementQuantities, "law element quantities") \
  X(LawContactQuantities, "law contact quantities") \
  X(LawPlainQuantities, "law plain quantities") \
  X(LawFlightQuantities, "law flight quantities") \
  X(LawFlightAngles, "law flight angles") \
  X(LawFallingQuantities, "law falling quantities") \
  X(LawAirQuantities, "law air quantities") \
  X(LawRoundDistances, "law round distances") \
  X(LawConvexDistances, "law convex distances") \
  X(LawHollowDistances, "law hollow distances") \
  X(Sensors, "sensors")

// clang-format on
#define UNLATCH_UNIT(name, text) k##name,
enum class Unit : std::int32_t { UNLATCH_COST_UNITS(UNLATCH_UNIT) kCount };
#undef UNLATCH_UNIT
inline constexpr std::size_t kUnits = static_cast<std::size_t>(Unit::kCount);
#define UNLATCH_UNIT(name, text) text,
inline constexpr std::array<const char*, kUnits> kUnitNames = {UNLATCH_COST_UNITS(UNLATCH_UNIT)};
#undef UNLATCH_UNIT

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
