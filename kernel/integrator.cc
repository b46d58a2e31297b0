#include "kernel/integrator.h"

#include <cstring>
#include <limits>

#include "kernel/forces.h"
#include "kernel/kinematics.h"
#include "kernel/rows.h"
#include "kernel/step.h"
#include "kernel/tree_solver.h"

namespace unlatch {
namespace {

Quat operator+(const Quat& a, const Quat& b) { return {a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z}; }
Quat operator*(double s, const Quat& a) { return {s * a.w, s * a.x, s * a.y, s * a.z}; }

BodyState advance(const BodyState& y, double h, const BodyRate& k) {
  return {y.p + h * k.p, y.q + h * k.q, y.v + h * k.v, y.w + h * k.w};
}

BodyRate combine(const BodyRate& k1, const BodyRate& k2, const BodyRate& k3, const BodyRate& k4) {
  const double a = 1.0 / 6.0, b = 1.0 / 3.0;
  return {(a * k1.p + b * k2.p) + (b * k3.p + a * k4.p), (a * k1.q + b * k2.q) + (b * k3.q + a * k4.q),
          (a * k1.v + b * k2.v) + (b * k3.v + a * k4.v), (a * k1.w + b * k2.w) + (b * k3.w + a * k4.w)};
}

void copy(const State& from, State& to) {
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
}

void clear_forces(Workspace& ws) {
  for (Spatial& force : ws.forces) force = {{0, 0, 0}, {0, 0, 0}};
}

void add_velocities(State& state, const Workspace& ws) {
  for (std::size_t b = 0; b < state.bodies.size(); ++b) {
    state.bodies[b].v += ws.accelerations[b].lin;
    state.bodies[b].w += transpose_times(ws.kinematics[b].R, ws.accelerations[b].ang);
  }
}

void add_displacements(State& state, const Workspace& ws) {
  for (std::size_t b = 0; b < state.bodies.size(); ++b) {
    const Vec3 half = 0.5 * ws.accelerations[b].ang;
    state.bodies[b].p += ws.accelerations[b].lin;
    state.bodies[b].q = normalized(state.bodies[b].q + Quat{0, half.x, half.y, half.z} * state.bodies[b].q);
  }
}

// With as many independent rows of loops as the latest evaluate() has found.
int evaluate_stage(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) {
  update_kinematics(plan, state, ws);
  update_joint_frames(plan, state, ws);
  update_coordinates(plan, state, ws);
  update_forces(plan, inputs, state, t, ws);
  update_acceleration_bias(plan, state, ws);
  if (const int node = factor(plan, state, ws); node != kNone) return node;
  solve(plan, ws);
  return kNone;
}

int project(const Plan& plan, State& state, Workspace& ws) {
  update_kinematics(plan, state, ws);
  update_joint_frames(plan, state, ws);
  if (const int node = factor(plan, state, ws); node != kNone) return node;
  clear_forces(ws);
  update_position_bias(plan, state, ws);
  solve(plan, ws);
  add_displacements(state, ws);

  update_kinematics(plan, state, ws);
  update_joint_frames(plan, state, ws);
  update_velocity_bias(plan, state, ws);
  solve(plan, ws);
  add_velocities(state, ws);
  return kNone;
}

}  // namespace

int evaluate(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws) noexcept {
  ws.loop_most = std::numeric_limits<std::int32_t>::max();
  if (const int node = evaluate_stage(plan, inputs, state, t, ws); node != kNone) return node;
  ws.loop_most = ws.loop_count - ws.loop_redundant;
  return kNone;
}

void update_rates(const Plan& plan, const State& state, int stage, Workspace& ws) noexcept {
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const BodyState& s = state.bodies[b];
    const Spatial& a = ws.accelerations[b];
    ws.rates[stage][b] = {s.v, quaternion_rate(s.q, s.w), a.lin, transpose_times(ws.kinematics[b].R, a.ang)};
  }
}

int integrate(const Plan& plan, const Inputs& inputs, const State& from, double t, double h, State& to,
              Workspace& ws) noexcept {
  copy(from, ws.stage);
  const double fractions[3] = {0.5, 0.5, 1.0};
  for (int stage = 1; stage <= 3; ++stage) {
    const double c = fractions[stage - 1];
    for (std::size_t b = 0; b < plan.bodies.size(); ++b)
      ws.stage.bodies[b] = advance(from.bodies[b], c * h, ws.rates[stage - 1][b]);
    if (const int node = evaluate_stage(plan, inputs, ws.stage, t + c * h, ws); node != kNone) return node;
    update_rates(plan, ws.stage, stage, ws);
  }
  copy(from, to);
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    to.bodies[b] = advance(from.bodies[b], h, combine(ws.rates[0][b], ws.rates[1][b], ws.rates[2][b], ws.rates[3][b]));
    to.bodies[b].q = normalized(to.bodies[b].q);
  }
  return project(plan, to, ws);
}

int apply_impulse(const Plan& plan, State& state, Workspace& ws) noexcept {
  ws.loop_most = std::numeric_limits<std::int32_t>::max();
  if (const int node = factor(plan, state, ws); node != kNone) return node;
  clear_forces(ws);
  update_velocity_bias(plan, state, ws);
  solve(plan, ws);
  add_velocities(state, ws);
  return kNone;
}

}  // namespace unlatch
