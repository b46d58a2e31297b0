#include "kernel/step/integrator.h"

#include "kernel/dynamics/auxiliary.h"
#include "kernel/dynamics/compliance.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/forces.h"
#include "kernel/dynamics/kinematics.h"
#include "kernel/dynamics/loads.h"
#include "kernel/dynamics/varying.h"
#include "kernel/solver/loops.h"
#include "kernel/solver/tree_solver.h"
#include "kernel/step/lane_state.h"
#include "unlatch/step.h"

namespace unlatch {
namespace {

constexpr Sweep kCorrection{Source::kNothing, true, false};

// Kernels that move bodies leave the kinematics of rigid ones.
void complete_kinematics(const Plan& plan, Workspace& ws) {
  if (!plan.rigid) update_kinematics(plan, ws);
}

// One position and one velocity projection onto the rows, with one factorisation.
int project(const Plan& plan, const State& state, Workspace& ws) {
  complete_kinematics(plan, ws);
  update_joints(plan, state, BiasKind::kPosition, ws);
  if (const int node = factor_and_solve(plan, state, ws, kCorrection); node != kNone) return node;
  plan.kernels->add_displacements(plan, ws);
  if (!plan.rigid) add_modal_displacements(plan, ws);

  complete_kinematics(plan, ws);
  update_joints(plan, state, BiasKind::kVelocity, ws);
  solve(plan, ws, kCorrection);
  plan.kernels->add_velocities(plan, ws);
  if (plan.rigid) return kNone;
  add_modal_velocities(plan, ws);
  update_rates(plan, ws);
  return kNone;
}

// At the present joint frames. Without outputs it does without multipliers, and coordinates that no spring reads. Takes
// as many rows of loops for independent as the latest evaluation has found.
int solve_dynamics(const Plan& plan, const State& state, double t, bool outputs, Workspace& ws) {
  update_coordinates(plan, state, outputs, ws);
  add_forces(plan, state, t, ws);
  if (const int node = factor_and_solve(plan, state, ws, {Source::kForces, true, outputs}); node != kNone) return node;
  if (!plan.rigid) update_modal_rates(plan, ws);
  return kNone;
}

int evaluate_stage(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) {
  update_masses(plan, t, ws);
  complete_kinematics(plan, ws);
  update_loads(plan, inputs, state, t, ws);
  update_joints(plan, state, BiasKind::kAcceleration, ws);
  return solve_dynamics(plan, state, t, false, ws);
}

// The end of a sub-step, on its rows.
int finish(const Plan& plan, const State& from, double end, Workspace& ws) {
  update_masses(plan, end, ws);
  return project(plan, from, ws);
}

// ROS2, see compliance.h.
int integrate_implicitly(const Plan& plan, const Inputs& inputs, const State& from, double t, double end,
                         Workspace& ws) {
  const double h = end - t;
  const LaneKernels& kernels = *plan.kernels;
  begin_compliance(plan, from, t, h, ws);
  const double lead = ws.implicit.lead;
  kernels.restart(plan, ws);
  restart_extras(ws);
  if (const int node = evaluate_stage(plan, inputs, from, t, ws); node != kNone) return node;
  kernels.finish_first_stage(plan, ws, h, lead);
  lead_modal_rates(plan, ws);
  begin_second_extras(ws, h);
  keep_first_stage(plan, ws);
  if (const int node = evaluate_stage(plan, inputs, from, end, ws); node != kNone) return node;
  kernels.finish_second_stage(plan, ws, h, lead);
  lead_modal_rates(plan, ws);
  finish_extras(ws, 0.5, h);
  return finish(plan, from, end, ws);
}

int solve_outputs(const Plan& plan, const State& state, double t, Workspace& ws) {
  end_compliance(plan, ws);
  ws.loop_most = kAllRows;
  if (const int node = solve_dynamics(plan, state, t, true, ws); node != kNone) return node;
  ws.loop_most = ws.loop_count - ws.loop_redundant;
  return kNone;
}

}  // namespace

int evaluate_lanes(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  update_loads(plan, inputs, state, t, ws);
  update_joints(plan, state, BiasKind::kAcceleration, ws);
  return solve_outputs(plan, state, t, ws);
}

int evaluate_end(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  update_loads(plan, inputs, state, t, ws);
  renew_joints(plan, state, ws);
  return solve_outputs(plan, state, t, ws);
}

int evaluate(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  load_state(plan, state, ws);
  load_extras(state, ws);
  forget_loads(plan, ws);
  update_masses(plan, t, ws);
  update_kinematics(plan, ws);
  return evaluate_lanes(plan, inputs, state, t, ws);
}

void evaluate_forces(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  forget_sizes(ws);
  update_loads(plan, inputs, state, t, ws);
  plan.kernels->init_forces(plan, ws);
  add_forces(plan, state, t, ws);
  solve(plan, ws, {Source::kForces, true, true});
  if (!plan.rigid) update_modal_rates(plan, ws);
}

void keep_start(const Plan& plan, Workspace& ws) noexcept {
  plan.kernels->keep_start(plan, ws);
  keep_extras(ws);
}

int integrate(const Plan& plan, const Inputs& inputs, const State& from, double t, double end, Workspace& ws) noexcept {
  const double h = end - t;
  if (is_stiff(plan, from, t + 0.5 * h)) return integrate_implicitly(plan, inputs, from, t, end, ws);
  const LaneKernels& kernels = *plan.kernels;
  constexpr double kOuter = 1.0 / 6.0, kInner = 1.0 / 3.0;
  kernels.begin_stages(plan, ws, kOuter, 0.5 * h);
  begin_extras(ws, kOuter, 0.5 * h);
  if (const int node = evaluate_stage(plan, inputs, from, t + 0.5 * h, ws); node != kNone) return node;
  kernels.advance_stage(plan, ws, kInner, 0.5 * h);
  advance_extras(ws, kInner, 0.5 * h);
  if (const int node = evaluate_stage(plan, inputs, from, t + 0.5 * h, ws); node != kNone) return node;
  kernels.advance_stage(plan, ws, kInner, h);
  advance_extras(ws, kInner, h);
  if (const int node = evaluate_stage(plan, inputs, from, end, ws); node != kNone) return node;
  kernels.finish_stages(plan, ws, kOuter, h);
  finish_extras(ws, kOuter, h);
  return finish(plan, from, end, ws);
}

int apply_impulse(const Plan& plan, State& state, Workspace& ws) noexcept {
  update_joints(plan, state, BiasKind::kVelocity, ws);
  ws.loop_most = kAllRows;
  if (const int node = factor_and_solve(plan, state, ws, {Source::kNothing, true, true}); node != kNone) return node;
  plan.kernels->add_velocities(plan, ws);
  if (!plan.rigid) add_modal_velocities(plan, ws);
  update_markers(plan, ws);
  store_motion(plan, ws, state);
  return kNone;
}

void store_motion(const Plan& plan, const Workspace& ws, State& state) noexcept {
  store_bodies(plan, ws, state);
  store_extras(ws, state);
}

}  // namespace unlatch
