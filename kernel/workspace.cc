#include "kernel/workspace.h"

#include "kernel/plan.h"
#include "kernel/step.h"

namespace unlatch {
namespace {

constexpr std::size_t kAlignment = 64;

// Hands out parts of one block, or, without a block, only counts what they need.
class Arena {
 public:
  explicit Arena(std::byte* memory) : memory_(memory) {}

  template <class T>
  void take(std::span<T>& out, std::size_t count) {
    if (memory_ != nullptr) out = {reinterpret_cast<T*>(memory_ + used_), count};
    used_ += (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
  }
  std::size_t get_used() const { return used_; }

 private:
  std::byte* memory_;
  std::size_t used_ = 0;
};

std::size_t lay_out(const Plan& plan, std::byte* memory, Workspace& ws) {
  Arena arena(memory);
  const std::size_t bodies = plan.bodies.size(), joints = plan.joints.size(), nodes = plan.nodes.size(),
                    events = plan.events.size();
  arena.take(ws.kinematics, bodies);
  arena.take(ws.forces, bodies);
  arena.take(ws.accelerations, bodies);
  for (std::span<BodyRate>& rates : ws.rates) arena.take(rates, bodies);
  arena.take(ws.frames, joints);
  arena.take(ws.bias, joints);
  arena.take(ws.multipliers, joints * kRows);
  arena.take(ws.coordinates, joints * kRows);
  arena.take(ws.speeds, joints * kRows);
  arena.take(ws.factors, nodes);
  const std::size_t loop_rows = plan.loops.size() * kRows;
  arena.take(ws.loop_rows, loop_rows);
  arena.take(ws.loop_columns, loop_rows * bodies);
  arena.take(ws.loop_multipliers, loop_rows * joints * kRows);
  arena.take(ws.loop_matrix, loop_rows * loop_rows);
  arena.take(ws.loop_solution, loop_rows);
  for (State* state : {&ws.stage, &ws.trial, &ws.accepted}) {
    std::span<std::byte> block;
    arena.take(block, plan.get_state_bytes());
    if (memory != nullptr) *state = State(plan, block);
  }
  for (std::span<double>* guards : {&ws.guards, &ws.guards_low, &ws.guards_high, &ws.guards_middle, &ws.tolerances})
    arena.take(*guards, events);
  arena.take(ws.acting, events);
  arena.take(ws.stack, static_cast<std::size_t>(plan.guard_depth));
  // An event acts at most once at an instant; a step has at most its splits and its beginning and end as instants.
  const std::size_t instants = static_cast<std::size_t>(plan.options.max_splits) + 2;
  arena.take(ws.fired, events * instants);
  arena.take(ws.audits, events * instants);
  arena.take(ws.sensors, static_cast<std::size_t>(plan.sensor_count));
  return arena.get_used();
}

}  // namespace

Workspace::Workspace(const Plan& plan, std::span<std::byte> memory) noexcept { lay_out(plan, memory.data(), *this); }

std::size_t Plan::get_workspace_bytes() const {
  Workspace scratch;
  return lay_out(*this, nullptr, scratch);
}

}  // namespace unlatch
