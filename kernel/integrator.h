// One sub-step without events: the classical Runge–Kutta method of order four on positions, quaternions and velocities,
// then one mass-weighted projection onto the rows' positions and one onto their velocities, both with one
// factorisation.
#pragma once

#include "kernel/plan.h"
#include "kernel/workspace.h"

namespace unlatch {

struct Inputs;

// Accelerations, reactions, coordinates and speeds of `state` at time t, s. Returns kNone, or the node whose pivot
// vanished.
int evaluate(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept;

// ws.rates[stage] from the latest evaluation, which was of `state`.
void update_rates(const Plan& plan, const State& state, int stage, Workspace& ws) noexcept;

// `to` = `from` after h seconds. Needs the latest evaluate() to be of `from`, or of a state in the same modes on its
// rows, and ws.rates[0] of `from`, which it leaves as it is. Returns as evaluate().
int integrate(const Plan& plan, const Inputs& inputs, const State& from, double t, double h, State& to,
              Workspace& ws) noexcept;

// Adds the velocity change that closes the active rows: a perfectly plastic impulse, left in ws.multipliers, N s and N
// m s. Needs ws.kinematics and ws.frames of `state`. Returns as evaluate().
int apply_impulse(const Plan& plan, State& state, Workspace& ws) noexcept;

}  // namespace unlatch
