#include "kernel/integrator.h"

#include <cstring>

#include "kernel/forces.h"
#include "kernel/kinematics.h"
#include "kernel/lane_state.h"
#include "kernel/loops.h"
#include "kernel/step.h"
#include "kernel/tree_solver.h"

namespace unlatch {
namespace {

constexpr Sweep kCorrection{Source::kNothing, true, false};

// One position and one velocity projection onto the rows, with one factorisation.
int project(const Plan& plan, const State& state, Workspace& ws) {
  update_kinematics(plan, ws);
  update_joints(plan, state, BiasKind::kPosition, ws);
  if (const int node = factor_and_solve(plan, state, ws, kCorrection); node != kNone) return node;
  plan.kernels->add_displacements(plan, ws);

  update_kinematics(plan, ws);
  update_joints(plan, state, BiasKind::kVelocity, ws);
  solve(plan, ws, kCorrection);
  plan.kernels->add_velocities(plan, ws);
  return kNone;
}

// Without outputs it does without multipliers, and coordinates that no spring reads. Takes as many rows of loops for
// independent as the latest evaluation has found.
int evaluate_stage(const Plan& plan, const Inputs& inputs, const State& state, double t, bool outputs, Workspace& ws) {
  update_kinematics(plan, ws);
  update_joints(plan, state, BiasKind::kAcceleration, ws);
  update_coordinates(plan, state, outputs, ws);
  update_forces(plan, inputs, state, t, ws);
  return factor_and_solve(plan, state, ws, {Source::kForces, true, outputs});
}

}  // namespace

int evaluate_lanes(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  ws.loop_most = kAllRows;
  if (const int node = evaluate_stage(plan, inputs, state, t, true, ws); node != kNone) return node;
  ws.loop_most = ws.loop_count - ws.loop_redundant;
  return kNone;
}

int evaluate(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  load_state(plan, state, ws);
  return evaluate_lanes(plan, inputs, state, t, ws);
}

int integrate(const Plan& plan, const Inputs& inputs, const State& from, double t, double h, State& to,
              Workspace& ws) noexcept {
  const LaneKernels& kernels = *plan.kernels;
  constexpr double kOuter = 1.0 / 6.0, kInner = 1.0 / 3.0;
  kernels.begin_stages(plan, ws, kOuter, 0.5 * h);
  if (const int node = evaluate_stage(plan, inputs, from, t + 0.5 * h, false, ws); node != kNone) return node;
  kernels.advance_stage(plan, ws, kInner, 0.5 * h);
  if (const int node = evaluate_stage(plan, inputs, from, t + 0.5 * h, false, ws); node != kNone) return node;
  kernels.advance_stage(plan, ws, kInner, h);
  if (const int node = evaluate_stage(plan, inputs, from, t + h, false, ws); node != kNone) return node;
  kernels.finish_stages(plan, ws, kOuter, h);
  if (const int node = project(plan, from, ws); node != kNone) return node;
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
  store_bodies(plan, ws, to);
  return kNone;
}

int apply_impulse(const Plan& plan, State& state, Workspace& ws) noexcept {
  update_joints(plan, state, BiasKind::kVelocity, ws);
  ws.loop_most = kAllRows;
  if (const int node = factor_and_solve(plan, state, ws, {Source::kNothing, true, true}); node != kNone) return node;
  plan.kernels->add_velocities(plan, ws);
  store_bodies(plan, ws, state);
  return kNone;
}

}  // namespace unlatch
