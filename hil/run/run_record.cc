#include "hil/run/run_record.h"

#include <cmath>

#include "hil/run/simulation/model_messages.h"

namespace unlatch::hil {

RunRecord::RunRecord(const Simulation& simulation, Recorder* recorder)
    : simulation_(simulation),
      recorder_(recorder),
      dt_ns_(std::llround(simulation.plan().get_options().dt * 1e9)),
      events_(build_event_messages(simulation.model())) {}

void RunRecord::state(RunStatus status) noexcept {
  if (recorder_ == nullptr || (!recorder_->wants_state(simulation_.get_tick()) && status == RunStatus::kRunning))
    return;
  StateMessage message;
  message.sequence = sequence_++;
  message.hash = simulation_.calc_hash();
  message.status = static_cast<std::int32_t>(status);
  for (std::int32_t part = count_state_parts(simulation_) - 1; part >= 0; --part) {
    fill_state(simulation_, part, dt_ns_, message);
    recorder_->state(message);
  }
}

void RunRecord::change(std::size_t channel, double value) noexcept {
  if (recorder_ == nullptr) return;
  LogChange change;
  change.channel = static_cast<std::int32_t>(channel);
  change.sequence = ++change_sequence_;
  change.value = value;
  recorder_->change(change);
}

void RunRecord::tick() noexcept {
  if (recorder_ != nullptr) recorder_->tick(simulation_.get_tick(), simulation_.calc_hash());
}

void RunRecord::events(const StepReport& report) noexcept {
  if (recorder_ == nullptr) return;
  for (const FiredEvent& fired : report.events) {
    EventMessage message = events_[static_cast<std::size_t>(fired.event)];
    message.sequence = event_sequence_++;
    message.tick = simulation_.get_tick() - 1;
    message.time = fired.time;
    message.time_ns = std::llround(fired.time * 1e9);
    recorder_->event(message);
  }
}

}  // namespace unlatch::hil
