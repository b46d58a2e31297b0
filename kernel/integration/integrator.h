// One sub-step without events: the classical Runge–Kutta method of order four, or ROS2 where an implicit element is on
// (kernel/elements/compliance.h), on positions, quaternions and velocities; then one mass-weighted projection onto the
// rows' positions and one onto their velocities, both with one factorisation. And the evaluations between sub-steps.
//
// Functions that return an int return kNone, or the node whose pivot vanished.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/joints/coordinates.h"
#include "kernel/joints/joint_motion.h"
#include "kernel/plan/evaluation.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

// Difference of an instant from the one that an evaluation is of. Forces and accelerations follow in every case.
//
//                 differs                       is computed again           must be in the evaluation
//   kCommands     commands                      loads                       all else, the factor too
//   kVelocities   commands, velocities          joints' velocities, factor  motion, kinematics, loads, joints' frames:
//                                               what integrate() leaves at the end of its sub-step
//   kModes        commands, velocities, modes,  loads, joints, factor       motion, kinematics; modes: load_modes()
//                 elements
//   kMotion       all but modes                 motion, masses, kinematics, modes: has_same_modes()
//                                               loads, joints, factor
//   kState        all                           modes, then as kMotion      nothing
enum class Changed { kCommands, kVelocities, kModes, kMotion, kState };

// Accelerations, reactions, coordinates and speeds. The evaluation must be one of an instant that differs by `changed`
// at the most.
int evaluate(const Instant& now, Changed changed, Evaluation& ev) noexcept;

// The beginning of sub-steps, kept in the evaluation's blocks.
struct SubstepStart {
  double t;                       // s
  std::int32_t independent_rows;  // of the loops: no stage takes more for independent
};
// The instant that the evaluation is of becomes the beginning of the next sub-steps.
SubstepStart begin_substep(const PlanData& plan, double t, Evaluation& ev) noexcept;

// From `start` to time `end`, s: motion and kinematics, but not yet an evaluation; markers follow with that. `now`:
// modes, elements and commands. The start stays kept.
int integrate(const Instant& now, const SubstepStart& start, double end, Evaluation& ev) noexcept;

// Changes the velocities so that the active rows close: a perfectly plastic impulse, left in ev.multipliers, N s and N
// m s. `state`: of the evaluation, but for its modes. kForces: impulses on bodies act too, see impulses.h.
int apply_impulse(const PlanData& plan, Source source, State& state, Evaluation& ev) noexcept;

// Rotations, angular velocities, inertias, and markers, of the motion in the evaluation; and the velocities alone.
void update_kinematics(const PlanData& plan, Evaluation& ev) noexcept;
void update_velocities(const PlanData& plan, Evaluation& ev) noexcept;

// ev.coordinates and ev.speeds; needs the joints' frames. Angles are counted on from those in the state's joints.
void update_coordinates(const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev) noexcept;

// Forces on all bodies; needs kinematics, joint frames, coordinates and loads.
void update_forces(const Instant& now, Evaluation& ev) noexcept;

// Frames of all joints, and what their rows ask for; needs kinematics.
void update_joints(const PlanData& plan, const State& state, RowTarget target, Evaluation& ev) noexcept;

}  // namespace unlatch
