// A pendulum of 1 m, released from the horizontal; with the consumer's own flags, Eigen vectorised. Fails unless it is
// at the lowest point after a quarter of its period.
#include <cmath>
#include <cstdio>
#include <vector>

#include "unlatch/step.h"

int main() {
  unlatch::Model model;
  model.name = "pendulum";
  model.gravity.uniform = {0, -9.81, 0};
  unlatch::Body bob;
  bob.name = "bob";
  bob.mass = 1;
  bob.inertia = 1e-9 * Eigen::Matrix3d::Identity();
  bob.p_WB = {1, 0, 0};
  model.bodies.push_back(bob);
  unlatch::Joint pivot;
  pivot.name = "pivot";
  pivot.point_follower = {-1, 0, 0};
  pivot.modes = {{"ball", unlatch::kPointRows}};
  model.joints.push_back(pivot);

  const unlatch::PlanResult compiled = unlatch::compile_plan(model, {});
  if (!compiled.plan) {
    std::printf("%s: %s\n", compiled.errors.front().where.c_str(), compiled.errors.front().what.c_str());
    return 1;
  }
  const unlatch::Plan& plan = *compiled.plan;
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  std::vector<Line> state_memory(plan.get_state_bytes() / 64 + 1),
      workspace_memory(plan.get_workspace_bytes() / 64 + 1);
  unlatch::State state(plan, std::as_writable_bytes(std::span(state_memory)));
  unlatch::Workspace workspace(plan, std::as_writable_bytes(std::span(workspace_memory)));
  unlatch::init_state(plan, state);

  const double quarter = 1.8540746773013719 * std::sqrt(1 / 9.81);  // K(sin 45°) sqrt(l / g), s
  const int ticks = static_cast<int>(std::lround(quarter / plan.get_options().dt));
  for (int i = 0; i < ticks; ++i) {
    if (unlatch::step(plan, {}, state, workspace).status != unlatch::StepStatus::kOk) return 1;
  }
  const unlatch::Vec3 p = state.bodies[0].p;
  std::printf("after %d ticks the bob is at %.4f, %.4f\n", ticks, p.x, p.y);
  constexpr double kHalfTick = 0.5e-3 * 4.5;  // m: half a tick at the lowest point's speed
  return std::abs(p.x) < kHalfTick && std::abs(p.y + 1) < kHalfTick ? 0 : 1;
}
