// Run of a model: the plan, the memory that the kernel steps in, and the channels' values. Only the constructor
// allocates, and the functions that say so.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/scenario/rates.h"
#include "hil/session/realtime/nonblocking.h"
#include "unlatch/bundle.h"
#include "unlatch/frequencies.h"
#include "unlatch/model.h"
#include "unlatch/plan.h"
#include "unlatch/step.h"

namespace unlatch::hil {

// Error: the model does not compile; what() has one line an error.
class SimulationError : public std::runtime_error {
 public:
  explicit SimulationError(std::vector<ModelError> errors_in);
  std::vector<ModelError> errors;
};

class Simulation {
 public:
  Simulation(const Model& model, const PlanOptions& options, const Rates& rates = {});  // throws SimulationError
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  // Makes one tick with the channels' present values, those that are latched now (hil/scenario/rates.h). On any status
  // but kOk nothing has changed but the latched values.
  StepReport step() noexcept UNLATCH_NONBLOCKING;
  // Two halves of step(), for a step beside those of other simulations (unlatch/bundle.h): the inputs are latched;
  // then, with the bundle's report, the sensors are sampled.
  BundleRun begin_step() noexcept;
  void end_step(const StepReport& report) noexcept;

  // Keeps the knots of the motion of each step from now on; allocates. For the analysis of a run, off the cyclic
  // thread.
  void keep_motion();
  // Knots of the latest step; empty before it, and without keep_motion().
  std::span<const MotionKnot> get_motion() const noexcept { return log_.get_knots(); }
  // States between the rounds of events of the latest step, likewise.
  std::span<const RoundKnot> get_rounds() const noexcept { return log_.get_rounds(); }

  // A warm-up step: the same step, thrown away. Code and data remain in the processor's caches.
  void warm_up() noexcept UNLATCH_NONBLOCKING;

  // All data that decide the rest of the run, as 8-byte words: the state block; the channels' values, commanded and
  // held; the sensor values held. Allocates.
  [[nodiscard]] std::vector<std::uint64_t> save() const;
  // Restores the result of save(). False, and nothing changed, if it is not of this plan. `unresolved`: the step had
  // not resolved the run that led there, so that no result from here on is one. Allocates.
  [[nodiscard]] bool restore(std::span<const std::uint64_t> saved, bool unresolved = false);
  [[nodiscard]] bool begins_unresolved() const { return begins_unresolved_; }

  // Leaves out the sensors of distances but those of `read`, numbers of the model's sensors, from now on: nobody reads
  // them, so that their values are any. Allocates.
  void leave_distances_unread(std::span<const int> read);

  // Sets the commanded value of a channel, which must exist. True if it changes, to the bit.
  bool set_channel(std::size_t channel, double value) noexcept;
  // Commanded value of each channel: the next step reads it, unless the channel is in a group that is not latched then.
  std::span<double> channels() noexcept { return channels_; }
  std::span<const double> channels() const noexcept { return channels_; }

  // Value of each channel in the last step, and in the next unless it latches another.
  std::span<const double> get_inputs() const noexcept { return held_.get_channels(); }
  // Value of each sensor component as last sampled, in the order of the model's sensors.
  std::span<const double> get_sensors() const noexcept { return held_.get_sensors(); }

  // Frequencies (h·ω and so on) of the springs at the present state; overwrites the workspace.
  std::vector<ElementFrequency> calc_frequencies() { return unlatch::calc_frequencies(plan_, state_, workspace_); }

  // Hash of everything that decides a state, but the inputs (hil/scenario/rates.h).
  std::int64_t get_model_hash() const noexcept { return model_hash_; }
  const Model& model() const noexcept { return model_; }
  const Plan& plan() const noexcept { return plan_; }
  const State& state() const noexcept { return state_; }
  const Workspace& workspace() const noexcept { return workspace_; }

  std::int64_t get_tick() const noexcept { return state_.header->tick; }
  double get_time() const noexcept { return static_cast<double>(get_tick()) * plan_.get_options().dt; }  // s
  std::int64_t calc_hash() const noexcept { return static_cast<std::int64_t>(unlatch::calc_hash(state_)); }

  // True if the State of this tick is to be sent.
  bool is_state_due() const noexcept { return held_.is_state_due(get_tick()); }

 private:
  struct Free {
    void operator()(std::byte* memory) const noexcept;
  };
  using Memory = std::unique_ptr<std::byte, Free>;
  static Memory allocate(std::size_t bytes);
  std::span<const double> begin();  // sets the initial state; gives its sensor values
  [[nodiscard]] bool is_possible(const State& state) const noexcept;
  [[nodiscard]] bool take(std::span<const std::uint64_t> saved);

  Model model_;
  Plan plan_;
  Memory state_memory_, workspace_memory_, warm_up_memory_, log_memory_;
  MotionLog log_;
  State state_, warm_up_state_;
  Workspace workspace_;
  std::vector<double> channels_;
  SampleAndHold held_;  // last of these: it begins with the channels and sensors of the initial state
  const std::int64_t model_hash_;
  bool begins_unresolved_ = false;
};

}  // namespace unlatch::hil
