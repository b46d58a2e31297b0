// One sub-step without events: the classical Runge–Kutta method of order four on positions, quaternions and velocities,
// then one mass-weighted projection onto the rows' positions and one onto their velocities, both with one
// factorisation.
#pragma once

#include "kernel/dispatch/lane_kernels.h"
#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

struct Inputs;

// Loads `state` into the lanes and evaluates it: accelerations, reactions, coordinates and speeds at time t, s. Returns
// kNone, or the node whose pivot vanished.
int evaluate(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept;

// The same for what stands in the lanes already, kinematics included; `state` for its joints, elements and signals.
int evaluate_lanes(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept;

// The same for what integrate() has left, joint frames included.
int evaluate_end(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept;

// The same again with other inputs, after an evaluation of `state` at time t: only forces differ.
void evaluate_forces(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept;

// What the latest evaluation was of is where the next sub-steps begin.
void keep_start(const Plan& plan, Workspace& ws) noexcept;

// `from`, which is at time t, at time `end`, s, in the lanes; markers follow at the next evaluation. `from` is what
// keep_start() kept, and it stays kept. Needs the latest evaluation to be of `from`, or of a state in the same modes on
// its rows. Returns as evaluate().
int integrate(const Plan& plan, const Inputs& inputs, const State& from, double t, double end, Workspace& ws) noexcept;

// Poses and velocities out of the lanes into the bodies of `state`, and the coordinates beyond the bodies.
void store_motion(const Plan& plan, const Workspace& ws, State& state) noexcept;

// Adds the velocity change that closes the active rows: a perfectly plastic impulse, left in ws.multipliers, N s and N
// m s. Needs the lanes to hold `state`, its modes but not yet its joint frames. Returns as evaluate().
int apply_impulse(const Plan& plan, State& state, Workspace& ws) noexcept;

}  // namespace unlatch
