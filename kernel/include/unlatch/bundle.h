// Bundle: runs of one kind of system stepped side by side, for campaigns. Their bodies share the lanes of the
// processor's packs, and each run has the bits that step() gives it alone: its own modes, events and sub-steps. A run
// takes a step alone in which it has an event or a closed contact.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "unlatch/model.h"
#include "unlatch/motion.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/step_data.h"
#include "unlatch/workspace.h"

namespace unlatch {

struct BundleData;  // kernel/step/bundle.h

// One of the runs, as step() takes it.
struct BundleRun {
  const Plan* plan = nullptr;      // of its model
  Inputs inputs;                   // of this step
  State* state = nullptr;          // its own
  Workspace* workspace = nullptr;  // its own; afterwards with the outputs of the new state, as step() leaves them, and
                                   // what calc_element() and calc_one_sided() read
  MotionLog* log = nullptr;        // as for step()
  bool goes_on = true;             // false: it has ended, and is not stepped
  StepReport report{};             // of the step
};

// Several runs in the lanes of one plan, with memory of its own.
class Bundle {
 public:
  static constexpr std::size_t kMost = 8;  // runs side by side

  // `models` with their plans, all compiled with the same options; each plan must outlive the bundle. Empty where a
  // bundle saves nothing or cannot be: fewer than two models or more than kMost, closed loops, flexible bodies,
  // different gravity or environment. Allocates.
  static std::optional<Bundle> build(std::span<const Model* const> models, std::span<const Plan* const> plans);
  Bundle(Bundle&&) noexcept;
  Bundle& operator=(Bundle&&) noexcept;
  ~Bundle();

  // A step of each run that goes on, in the order of the models. Allocates nothing.
  void step(std::span<BundleRun> runs) noexcept;

 private:
  explicit Bundle(std::unique_ptr<BundleData> data);
  std::unique_ptr<BundleData> data_;
};

}  // namespace unlatch
