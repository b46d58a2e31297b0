// Primitives: the functions through which a step is put together. The cost of one call, less what it calls of the
// others, is measured; how often a step calls each follows from the plan's limits (bound.cc).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace unlatch::cost {

enum class Primitive : std::int32_t {
  kFactor,           // factor_and_solve(), with reactions
  kFactorStage,      // without
  kFactorRest,       // of projections: without forces
  kSolve,            // solve(), with a factor that is there, and with reactions
  kSolveRest,        // of projections
  kSplit,            // reactions of redundant rows
  kJoints,           // update_joints(), of accelerations
  kJointPlaces,      // of places
  kJointSpeeds,      // of velocities
  kJointVelocities,  // update_joint_velocities()
  kLoopJoints,       // update_non_tree_joints()
  kKinematics,       // update_kinematics()
  kVelocities,       // update_angular_velocities()
  kBegin,            // the motion's begin_substep()
  kFirstStage,       // begin_stages()
  kStage,            // advance_stage()
  kLastStage,        // finish_stages()
  kImplicitStage,    // of ROS2: restart(), finish_first_stage(), finish_second_stage()
  kMovePlaces,       // add_displacements()
  kMoveSpeeds,       // add_velocities()
  kOwnForces,        // init_forces()
  kForces,           // add_forces()
  kLoads,            // update_loads()
  kLaws,             // update_driving_laws(), with update_law_loads()
  kOtherLaws,        // update_other_laws()
  kCoordinates,      // measure_coordinates()
  kAngles,           // update_angles()
  kUnwind,           // unwind_angles()
  kFriction,         // update_friction()
  kEvaluate,         // evaluate() of a new state
  kEvaluateModes,    // of new modes
  kEvaluateEnd,      // of new velocities
  kEvaluateNew,      // of new commands
  kIntegrate,        // integrate()
  kImpulse,          // apply_impulse()
  kGuards,           // update_guards()
  kReadings,         // update_readings()
  kParts,            // choose_contact_parts()
  kContactRows,      // begin_contact_rows()
  kRigidRows,        // solve_rigid_rows()
  kRigidStrike,      // strike_rigid_pairs()
  kRigidStop,        // stop_rigid_slips()
  kRigidSlips,       // begin_slips()
  kSearch,           // advance_to_event(), with one integration
  kTry,              // with more, for each beside the first
  kStore,            // store_substep()
  kRearm,            // rearm()
  kNextDue,          // calc_next_due()
  kAct,              // act(), where nothing is due
  kRound,            // act() where something acts, per round of events
  kWait,             // act() where events only begin to wait
  kStep,             // step(), per sub-step
  kFirstStep,        // likewise, of a state that no step has ended with
  kCount,
};
inline constexpr std::size_t kPrimitives = static_cast<std::size_t>(Primitive::kCount);
inline constexpr std::array<const char*, kPrimitives> kPrimitiveNames = {
    "factor",         "factor_stage", "factor_rest",    "solve",        "solve_rest",
    "split",          "joints",       "joint_places",   "joint_speeds", "joint_velocities",
    "loop_joints",    "kinematics",   "velocities",     "begin",        "first_stage",
    "stage",          "last_stage",   "implicit_stage", "move_places",  "move_speeds",
    "own_forces",     "forces",       "loads",          "laws",         "other_laws",
    "coordinates",    "angles",       "unwind",         "friction",     "evaluate",
    "evaluate_modes", "evaluate_end", "evaluate_new",   "integrate",    "impulse",
    "guards",         "readings",     "parts",          "contact_rows", "rigid_rows",
    "rigid_strike",   "rigid_stop",   "rigid_slips",    "search",       "try",
    "store",          "rearm",        "next_due",       "act",          "round",
    "wait",           "step",         "first_step"};

}  // namespace unlatch::cost
