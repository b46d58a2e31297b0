// Primitives: the functions through which a step is put together. The cost of one call, less what it calls of the
// others, is measured; how often a step calls each follows from the plan's limits (bound.cc).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace unlatch::cost {

enum class Primitive : std::int32_t {
  kFactor,           // factor_and_solve()
  kSolve,            // solve(), with a factor that is there
  kSplit,            // reactions of redundant rows
  kJoints,           // update_joints()
  kJointVelocities,  // update_joint_velocities()
  kLoopJoints,       // update_non_tree_joints()
  kKinematics,       // update_kinematics(), update_angular_velocities()
  kMotion,           // the stages, and the projections' changes
  kOwnForces,        // init_forces()
  kForces,           // add_forces()
  kLoads,            // update_loads()
  kLaws,             // update_driving_laws(), update_other_laws(), update_law_loads()
  kCoordinates,      // measure_coordinates()
  kAngles,           // update_angles(), unwind_angles()
  kFriction,         // update_friction()
  kEvaluate,         // evaluate() of a new state or of new modes
  kEvaluateEnd,      // evaluate() of new velocities, or of new commands
  kIntegrate,        // integrate()
  kImpulse,          // apply_impulse()
  kGuards,           // update_guards()
  kReadings,         // update_readings()
  kParts,            // choose_contact_parts()
  kContactRows,      // begin_contact_rows()
  kSearch,           // advance_to_event(), per integration
  kStore,            // store_substep()
  kRearm,            // rearm(), calc_next_due()
  kAct,              // act(), where nothing is due
  kRound,            // act() where something is due, per round of events
  kStep,             // step(), per sub-step
  kCount,
};
inline constexpr std::size_t kPrimitives = static_cast<std::size_t>(Primitive::kCount);
inline constexpr std::array<const char*, kPrimitives> kPrimitiveNames = {
    "factor",      "solve",        "split",        "joints",     "joint_velocities",
    "loop_joints", "kinematics",   "motion",       "own_forces", "forces",
    "loads",       "laws",         "coordinates",  "angles",     "friction",
    "evaluate",    "evaluate_end", "integrate",    "impulse",    "guards",
    "readings",    "parts",        "contact_rows", "search",     "store",
    "rearm",       "act",          "round",        "step"};

}  // namespace unlatch::cost
