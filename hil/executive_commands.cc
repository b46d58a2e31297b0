#include "hil/executive_commands.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace unlatch::hil {

CommandDesk::CommandDesk(std::span<const Channel> channels, std::int64_t session, bool accept_late)
    : channels_(channels), session_(session), accept_late_(accept_late) {
  pending_.reserve(kRoom);
}

std::optional<Reject> CommandDesk::check(const Command& command, Participant* sender,
                                         std::int64_t tick) const noexcept {
  if (command.tick < 0) return Reject::kMalformed;
  if (command.valid_until_tick >= 0 && command.valid_until_tick < std::max(tick, command.tick)) return Reject::kExpired;
  if (command.tick < tick && !accept_late_) return Reject::kPastTick;
  if (command.channel < 0 || static_cast<std::size_t>(command.channel) >= channels_.size()) {
    return Reject::kUnknownChannel;
  }
  if (!std::isfinite(command.value)) return Reject::kNotFinite;
  const Channel& channel = channels_[static_cast<std::size_t>(command.channel)];
  if (command.value < channel.minimum || command.value > channel.maximum) return Reject::kOutOfRange;
  if (sender->lost) return Reject::kExpired;  // the policy decides for it now
  return std::nullopt;
}

void CommandDesk::offer(const Command& command, Participant* sender, std::int64_t tick) noexcept {
  if (command.session != session_ || sender == nullptr) return refuse(Reject::kWrongSession);
  if (command.sequence < 1) return refuse(Reject::kMalformed);
  if (!sender->seen.insert(command.sequence)) return refuse(Reject::kDuplicate);
  if (const auto reason = check(command, sender, tick)) return refuse(*reason);
  if (pending_.size() == kRoom) {
    ++dropped_;
    return;
  }
  pending_.push_back(command);
}

void CommandDesk::drop(std::int32_t participant) noexcept {
  std::erase_if(pending_, [participant](const Command& command) { return command.participant == participant; });
}

bool CommandDesk::is_expired(const Command& command, std::int64_t tick) noexcept {
  if (command.valid_until_tick < 0 || command.valid_until_tick >= tick) return false;
  refuse(Reject::kExpired);
  return true;
}

void CommandDesk::sort() noexcept {
  std::sort(pending_.begin(), pending_.end(), [](const Command& a, const Command& b) {
    return std::tie(a.tick, a.participant, a.sequence) < std::tie(b.tick, b.participant, b.sequence);
  });
}

}  // namespace unlatch::hil
