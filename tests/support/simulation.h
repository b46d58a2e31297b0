// A model with all objects for stepping it, in one owner: for tests and benches.
#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <vector>

#include "kernel/integration/integrator.h"
#include "kernel/integration/load_state.h"
#include "unlatch/step.h"

namespace unlatch::test {

// Heap memory aligned to 64 bytes.
class Block {
 public:
  explicit Block(std::size_t bytes) : memory_(bytes + 64), size_(bytes) {}
  std::span<std::byte> get() {
    void* first = memory_.data();
    std::size_t space = memory_.size();
    return {static_cast<std::byte*>(std::align(64, size_, first, space)), size_};
  }

 private:
  std::vector<std::byte> memory_;
  std::size_t size_;
};

inline Plan compile_or_throw(const Model& model, const PlanOptions& options) {
  PlanResult result = compile_plan(model, options);
  if (!result.plan) throw std::runtime_error(result.errors.front().where + ": " + result.errors.front().what);
  return std::move(*result.plan);
}

class Simulation {
 public:
  explicit Simulation(const Model& model, const PlanOptions& options = {})
      : plan(compile_or_throw(model, options)),
        state_memory_(plan.get_state_bytes()),
        workspace_memory_(plan.get_workspace_bytes()) {
    state = State(plan, state_memory_.get());
    workspace = Workspace(plan, workspace_memory_.get());
    init_state(plan, state);
    for (const Channel& channel : model.channels) commands.push_back(channel.initial);
  }

  StepReport advance() { return step(plan, {commands}, state, workspace); }
  double get_time() const { return static_cast<double>(state.header->tick) * plan.get_options().dt; }

  // Access to the kernel's internals, for tests of its parts.
  const PlanData& data() const { return get_data(plan); }
  std::vector<std::int32_t> list_loops() const { return {data().loops.begin(), data().loops.end()}; }
  Evaluation& evaluation() const { return get_data(workspace).kept.evaluation; }

  Plan plan;
  std::vector<double> commands;
  State state;
  Workspace workspace;

 private:
  Block state_memory_, workspace_memory_;
};

// Index in the evaluation of a coordinate that an element, guard or sensor uses.
inline std::size_t find_coordinate(const PlanData& plan, int joint, int row) {
  for (std::size_t i = 0; i < plan.coordinates.size(); ++i)
    if (plan.coordinates[i].joint == joint && plan.coordinates[i].row == row) return i;
  throw std::out_of_range("nobody uses this coordinate");
}

// Updates kinematics and joint frames of the present state, which otherwise only an evaluation does.
inline void update_motion(Simulation& s) {
  load_state(s.data(), s.state, s.evaluation());
  update_kinematics(s.data(), s.evaluation());
  update_joints(s.data(), s.state, RowTarget::kAcceleration, s.evaluation());
}

// Evaluates the present state and commands; returns kNone, or the node whose pivot vanished.
inline int evaluate_state(Simulation& s, Changed changed = Changed::kState) {
  const Inputs inputs{s.commands};
  return evaluate({s.data(), inputs, s.state, s.get_time()}, changed, s.evaluation());
}

}  // namespace unlatch::test
