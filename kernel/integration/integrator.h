// One sub-step without events: the classical Runge–Kutta method of order four, ROS2 where an implicit element is on
// (kernel/elements/compliance.h), ROS34PW2 where contacts are (contact_stages.h), or a method of order eight in blows
// of contacts (eighth_order.h), on positions, quaternions and velocities; then one mass-weighted projection onto the
// rows' positions and one onto their velocities, both with one factorisation. And the evaluations between sub-steps.
//
// Functions that return an int return kNone, the node whose pivot vanished, or kRigidFailure (rigid_rows.h).
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/integration/contact_stages.h"
#include "kernel/joints/coordinates.h"
#include "kernel/joints/joint_motion.h"
#include "kernel/plan/evaluation.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

// What differs between an instant and that of an evaluation. Forces and accelerations are computed again in every case.
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

// Accelerations, reactions, coordinates and speeds at `now`. `ev`: the evaluation of an instant that differs from it by
// no more than `changed`.
int evaluate(const Instant& now, Changed changed, Evaluation& ev) noexcept;

// The beginning of sub-steps; its motion is kept in the evaluation's blocks.
struct SubstepStart {
  double t;                       // s
  Contacts method;                // of the sub-steps
  std::int32_t independent_rows;  // of the loops: no stage takes more for independent
  std::uint64_t rigid_rows;       // of closed rigid contacts: the RigidSet that was independent
  ContactRows contacts;           // that the sub-steps are implicit in, if there are some
};
// The instant that the evaluation is of becomes the beginning of the next sub-steps.
SubstepStart begin_substep(const Instant& now, Contacts contacts, Evaluation& ev) noexcept;

// From `start` to time `end`, s. Leaves motion and kinematics in `ev`: evaluate() computes the rest. `now` has modes,
// elements and commands. The start remains in `ev`, for another try.
int integrate(const Instant& now, const SubstepStart& start, double end, Evaluation& ev) noexcept;

// Changes the velocities in `ev` and `state` so that the active rows close, by a perfectly plastic impulse, which is
// left in ev.multipliers, N s and N m s. `ev`: with the kinematics of `state`. `source`: kNothing, or as
// set_impulses() returns it.
int apply_impulse(const PlanData& plan, Source source, State& state, Evaluation& ev) noexcept;

// The parts of an evaluation, each from those before it; Evaluation lists what each computes.
// Rotations, angular velocities, inertias, and markers, from the motion; and markers and angular velocities alone.
void update_kinematics(const PlanData& plan, Evaluation& ev) noexcept;
void update_velocities(const PlanData& plan, Evaluation& ev) noexcept;
// Frames of all joints, and the right-hand sides of their rows.
void update_joints(const PlanData& plan, const State& state, RowTarget target, Evaluation& ev) noexcept;
// Coordinates of joints and their rates. Turns of angles are counted from the angles in the state's joints.
void update_coordinates(const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev) noexcept;
// Forces on all bodies.
void update_forces(const Instant& now, Evaluation& ev) noexcept;

}  // namespace unlatch
