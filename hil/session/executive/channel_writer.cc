#include "hil/session/executive/channel_writer.h"

#include "hil/session/participants/liveness.h"

namespace unlatch::hil {

ChannelWriter::ChannelWriter(Simulation& simulation, Recorder& recorder, FaultInjector* faults)
    : simulation_(simulation), recorder_(recorder), commanders_(simulation.channels().size()) {
  if (faults != nullptr) faults_.emplace(*faults, simulation.channels());
}

void ChannelWriter::set(const LogChange& change) noexcept {
  const auto channel = static_cast<std::size_t>(change.channel);
  const bool is_command = change.cause == ChangeCause::kCommand || change.cause == ChangeCause::kLateCommand;
  if (is_command) commanders_[channel] = change.participant;
  if (faults_ && change.cause != ChangeCause::kFault) {
    if (!faults_->command(channel, change.value, simulation_.channels()[channel])) return;
  }
  if (simulation_.set_channel(channel, change.value)) recorder_.change(change);
}

void ChannelWriter::apply_policy(Policy policy, std::int32_t lost) noexcept {
  const std::vector<Channel>& channels = simulation_.model().channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (commanders_[i].value_or(lost) != lost) continue;
    const std::optional<double> value = calc_policy_value(policy, channels[i]);
    if (!value) continue;
    set({.channel = static_cast<std::int32_t>(i),
         .cause = ChangeCause::kPolicy,
         .participant = lost,
         .sequence = 0,
         .value = *value});
  }
}

void ChannelWriter::update_faults() noexcept {
  if (!faults_) return;
  for (std::size_t i = 0; i < commanders_.size(); ++i) {
    set({.channel = static_cast<std::int32_t>(i),
         .cause = ChangeCause::kFault,
         .participant = -1,
         .sequence = 0,
         .value = faults_->calc_value(i, simulation_.channels()[i])});
  }
}

}  // namespace unlatch::hil
