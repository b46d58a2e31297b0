// Plan: a model compiled for one step size. Never changes; copies share one plan, and any number of threads may step
// with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "unlatch/model.h"

namespace unlatch {

struct PlanData;  // kernel/plan/plan_data.h

// Instruction sets, by the numbers that one instruction works on. Every choice gives the same bits.
enum class InstructionSet {
  kAuto,    // the widest that the processor has
  kScalar,  // one
  k128,     // two: SSE2, NEON
  k256,     // four: AVX2
  k512,     // eight: AVX-512
};
// Available in this build on this processor.
bool is_supported(InstructionSet set);
// "scalar", "sse2" or "neon", "avx2", "avx512"; of kAuto, the one that it stands for.
const char* get_name(InstructionSet set);

// Options of compile_plan().
struct PlanOptions {
  double dt = 0.001;   // s, > 0
  int max_splits = 8;  // sub-steps that events may cut one step into, at most; later ones act at the next tick
  int root = kNone;    // body at the root of its tree; by default the one that makes the tree shallowest
  InstructionSet instruction_set = InstructionSet::kAuto;  // for tests and benches
};

// A body in the elimination order: parents before children, so that forward is root to leaves and backward the reverse.
struct TreeNode {
  std::int32_t body;    // index into the model's bodies
  std::int32_t parent;  // node, or kNone for the root of a tree
  std::int32_t joint;   // to the parent, or to the ground for a root that is held; kNone for a root that is not, and
                        // between a flexible body and its markers
  std::int8_t side;     // +1: this body is the joint's follower; −1: its base
  bool leaf;            // nothing is outboard of it, and its mass is constant: its block is diag(mass, inertia)
};

// How the closed loops of a plan lie beside each other. Each is eliminated where it closes; a step costs what the tree
// does, and at each body the square of the loops that are open there.
struct LoopOverlap {
  std::int32_t loops = 0;   // joints that close one over the tree
  std::int32_t widest = 0;  // most loops that are open at one body
  bool local = false;       // eliminated where they close; else by one dense matrix of all their rows
};

// A compiled model. Copies share their data.
class Plan {
 public:
  // For compile_plan().
  explicit Plan(std::shared_ptr<const PlanData> data) : data_(std::move(data)) {}

  // The options that it was compiled with.
  const PlanOptions& get_options() const noexcept;
  // Hash of the model and the options: two plans with one hash step alike.
  std::uint64_t get_hash() const noexcept;
  std::size_t get_state_bytes() const noexcept;
  std::size_t get_workspace_bytes() const noexcept;

  // The bodies in elimination order, parents before children.
  std::span<const TreeNode> get_tree() const noexcept;
  std::span<const std::int32_t> get_loops() const noexcept;  // joints that close a loop over the tree
  LoopOverlap get_loop_overlap() const noexcept;
  std::size_t get_sensor_count() const noexcept;  // values, all sensors' components counted
  // The commands of the channels at the start, for Inputs::commands.
  std::span<const double> get_initial_commands() const noexcept;
  // The whole plan as one block of bytes, see unlatch/plan_image.h.
  std::span<const std::byte> get_image() const noexcept;

 private:
  friend const PlanData& get_data(const Plan& plan) noexcept;  // kernel/plan/plan_data.h
  std::shared_ptr<const PlanData> data_;
};

// Result of compile_plan().
struct PlanResult {
  std::optional<Plan> plan;        // absent if there are errors
  std::vector<ModelError> errors;  // every mistake of the model or the options
};

// Validates and compiles; O(n log n), for sorting. Allocates; nothing after it does.
PlanResult compile_plan(const Model& model, const PlanOptions& options);

}  // namespace unlatch
