#include "hil/run/simulation/simulation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>
#include <utility>

#include "unlatch/contacts.h"

namespace unlatch::hil {
namespace {

constexpr std::align_val_t kAlignment{64};  // cache line; the workspace needs it

std::string join(const std::vector<ModelError>& errors) {
  std::string text;
  for (const ModelError& error : errors) {
    if (!text.empty()) text += '\n';
    text += error.where + ": " + error.what + "; " + error.mend;
  }
  return text;
}

Plan compile_or_throw(const Model& model, const PlanOptions& options) {
  PlanResult result = compile_plan(model, options);
  if (!result.plan) throw SimulationError(std::move(result.errors));
  return *std::move(result.plan);
}

std::vector<double> get_initial_channels(const Model& model) {
  std::vector<double> values;
  for (const Channel& channel : model.channels) values.push_back(channel.initial);
  return values;
}

}  // namespace

SimulationError::SimulationError(std::vector<ModelError> errors_in)
    : std::runtime_error(join(errors_in)), errors(std::move(errors_in)) {}

void Simulation::Free::operator()(std::byte* memory) const noexcept { ::operator delete(memory, kAlignment); }

Simulation::Memory Simulation::allocate(std::size_t bytes) {
  Memory memory(static_cast<std::byte*>(::operator new(bytes, kAlignment)));
  std::memset(memory.get(), 0, bytes);  // touches all pages before stepping
  return memory;
}

Simulation::Simulation(const Model& model, const PlanOptions& options, const Rates& rates)
    : model_(model),
      plan_(compile_or_throw(model_, options)),
      state_memory_(allocate(plan_.get_state_bytes())),
      workspace_memory_(allocate(plan_.get_workspace_bytes())),
      warm_up_memory_(allocate(plan_.get_state_bytes())),
      state_(plan_, {state_memory_.get(), plan_.get_state_bytes()}),
      warm_up_state_(plan_, {warm_up_memory_.get(), plan_.get_state_bytes()}),
      workspace_(plan_, {workspace_memory_.get(), plan_.get_workspace_bytes()}),
      channels_(get_initial_channels(model_)),
      held_(model_, rates, channels_, begin()),
      model_hash_(static_cast<std::int64_t>(unlatch::hil::calc_hash(rates, plan_.get_hash()))) {}

std::span<const double> Simulation::begin() {
  init_state(plan_, state_);
  if (update_outputs(plan_, Inputs{channels_}, state_, workspace_) != StepStatus::kOk) {
    throw SimulationError({{"model '" + model_.name + "'", "its accelerations at the initial state cannot be computed",
                            "look for joints that hold the same freedom twice"}});
  }
  store_rigid_forces(plan_, workspace_, state_);
  return workspace_.sensors;
}

bool Simulation::set_channel(std::size_t channel, double value) noexcept {
  double& now = channels_[channel];
  if (now == value && std::signbit(now) == std::signbit(value)) return false;
  now = value;
  return true;
}

void Simulation::keep_motion() {
  if (log_memory_) return;
  log_memory_ = allocate(MotionLog::get_bytes(plan_));
  log_ = MotionLog(plan_, {log_memory_.get(), MotionLog::get_bytes(plan_)});
}

void Simulation::leave_distances_unread(std::span<const int> read) {
  std::vector<int> unread;
  for (std::size_t i = 0; i < model_.sensors.size(); ++i) {
    const int sensor = static_cast<int>(i);
    const bool is_read = std::ranges::find(read, sensor) != read.end();
    if (model_.sensors[i].kind == Sensor::Kind::kDistance && !is_read) unread.push_back(sensor);
  }
  workspace_.leave_unread(plan_, unread);
}

BundleRun Simulation::begin_step() noexcept {
  held_.latch(get_tick(), channels_);
  return {.plan = &plan_,
          .inputs = {held_.get_channels()},
          .state = &state_,
          .workspace = &workspace_,
          .log = log_memory_ ? &log_ : nullptr};
}

void Simulation::end_step(const StepReport& report) noexcept {
  if (report.status == StepStatus::kOk) held_.sample(get_tick(), workspace_.sensors);
}

StepReport Simulation::step() noexcept {
  held_.latch(get_tick(), channels_);
  const StepReport report =
      unlatch::step(plan_, Inputs{held_.get_channels()}, state_, workspace_, log_memory_ ? &log_ : nullptr);
  end_step(report);
  return report;
}

void Simulation::warm_up() noexcept {
  std::memcpy(warm_up_state_.get_bytes().data(), state_.get_bytes().data(), state_.get_bytes().size());
  (void)unlatch::step(plan_, Inputs{held_.get_channels()}, warm_up_state_, workspace_);
  (void)update_outputs(plan_, Inputs{held_.get_channels()}, state_, workspace_);  // succeeded at this state before
}

std::vector<std::uint64_t> Simulation::save() const {
  const std::span<const std::byte> block = state_.get_bytes();
  std::vector<std::uint64_t> words(block.size() / sizeof(std::uint64_t));
  std::memcpy(words.data(), block.data(), block.size());
  for (const std::span<const double> values :
       {channels(), held_.get_channels(), held_.get_sensors(), held_.get_memory()}) {
    for (const double value : values) words.push_back(std::bit_cast<std::uint64_t>(value));
  }
  return words;
}

bool Simulation::restore(std::span<const std::uint64_t> saved, bool unresolved) {
  const std::size_t block = state_.get_bytes().size(), words = block / sizeof(std::uint64_t);
  const std::size_t inputs = 2 * channels_.size();
  if (saved.size() != words + inputs + held_.get_sensors().size() + held_.get_memory().size()) return false;
  std::vector<std::uint64_t> copy(saved.begin(), saved.end());  // a State is a view of memory that may be written
  if (!is_possible(State(plan_, {reinterpret_cast<std::byte*>(copy.data()), block}))) return false;
  // Every word of the state but its header: modes and phases, checked above, are small numbers and finite as doubles.
  const auto is_finite = [](std::uint64_t word) { return std::isfinite(std::bit_cast<double>(word)); };
  constexpr std::size_t kHeader = sizeof(StateHeader) / sizeof(std::uint64_t);
  if (!std::ranges::all_of(saved.subspan(kHeader, words - kHeader + inputs), is_finite) ||
      !std::ranges::all_of(saved.last(held_.get_memory().size()), is_finite))
    return false;

  const std::vector<std::uint64_t> before = save();
  if (take(saved)) {
    begins_unresolved_ = unresolved;
    return true;
  }
  (void)take(before);  // succeeded before
  return false;
}

bool Simulation::take(std::span<const std::uint64_t> saved) {
  const std::size_t block = state_.get_bytes().size();
  std::memcpy(state_.get_bytes().data(), saved.data(), block);
  std::vector<double> values;
  for (const std::uint64_t word : saved.subspan(block / sizeof(std::uint64_t))) {
    values.push_back(std::bit_cast<double>(word));
  }
  const std::span<const double> all = values;
  std::copy_n(all.begin(), channels_.size(), channels_.begin());
  const std::size_t inputs = 2 * channels_.size(), sensors = held_.get_sensors().size();
  held_.restore(all.subspan(channels_.size(), channels_.size()), all.subspan(inputs, sensors),
                all.subspan(inputs + sensors));
  return update_outputs(plan_, Inputs{held_.get_channels()}, state_, workspace_) == StepStatus::kOk;
}

// True if the state's numbers are in their ranges, so that they may be used as indices.
bool Simulation::is_possible(const State& state) const noexcept {
  constexpr std::int64_t kMaxTick = std::int64_t{1} << 53;  // limit: beyond it two ticks may have one time in seconds
  if (state.header->plan_hash != plan_.get_hash() || state.header->tick < 0 || state.header->tick > kMaxTick)
    return false;
  for (std::size_t i = 0; i < state.joints.size(); ++i) {
    const std::int64_t mode = state.joints[i].mode;
    if (mode < 0 || mode >= static_cast<std::int64_t>(model_.joints[i].modes.size())) return false;
  }
  return std::all_of(state.events.begin(), state.events.end(), [](const EventState& event) {
    return event.phase >= EventPhase::kArmed && event.phase <= EventPhase::kSpent;
  });
}

}  // namespace unlatch::hil
