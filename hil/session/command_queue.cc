#include "hil/session/command_queue.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace unlatch::hil {

CommandQueue::CommandQueue(std::span<const Channel> channels, const CommandQueueOptions& options, RejectCounts& rejects)
    : channels_(channels), options_(options), rejects_(rejects) {
  pending_.reserve(kCapacity);
}

// The window in which a command may act is shifted by the transport's delay, as its tick is.
std::optional<Reject> CommandQueue::check(const CommandMessage& command, std::int64_t acts_at,
                                          std::int64_t due) const noexcept {
  const bool has_limit = command.valid_until_tick >= 0 && command.valid_until_tick < kLastTick;
  if (has_limit && command.valid_until_tick + options_.delay_ticks < acts_at) return Reject::kExpired;
  if (due < acts_at && !options_.accept_late) return Reject::kPastTick;
  if (command.channel < 0 || static_cast<std::size_t>(command.channel) >= channels_.size()) {
    return Reject::kUnknownChannel;
  }
  if (!std::isfinite(command.value)) return Reject::kNotFinite;
  const Channel& channel = channels_[static_cast<std::size_t>(command.channel)];
  if (command.value < channel.minimum || command.value > channel.maximum) return Reject::kOutOfRange;
  return std::nullopt;
}

CommandQueue::Outcome CommandQueue::add(const CommandMessage& command, Participant* sender,
                                        std::int64_t earliest_tick) noexcept {
  const auto refused = [this](Reject reason) {
    rejects_.add(reason);
    return Outcome{reason, -1};
  };
  if (command.session != options_.session) return refused(Reject::kWrongSession);
  if (sender == nullptr || !sender->is_present()) return refused(Reject::kUnknownParticipant);
  if (command.sequence < 1 || command.tick < 0 || command.tick > kLastTick) return refused(Reject::kMalformed);
  if (!sender->seen.insert(command.sequence)) return refused(Reject::kDuplicate);
  const std::int64_t due = command.tick + options_.delay_ticks;
  const std::int64_t acts_at = std::max(due, earliest_tick);
  if (const auto reason = check(command, acts_at, due)) return refused(*reason);
  if (pending_.size() == kCapacity) {
    ++dropped_;
    return {};
  }
  const bool late = due < acts_at;
  pending_.push_back({command, sender, acts_at, late});
  if (!late) return {};
  ++late_;
  return {Reject::kLate, acts_at};
}

void CommandQueue::remove(const Participant& sender) noexcept {
  std::erase_if(pending_, [&sender](const Pending& pending) { return pending.sender == &sender; });
}

void CommandQueue::sort() noexcept {
  std::sort(pending_.begin(), pending_.end(), [](const Pending& a, const Pending& b) {
    return std::tie(a.command.tick, a.sender->name, a.command.sequence) <
           std::tie(b.command.tick, b.sender->name, b.command.sequence);
  });
}

}  // namespace unlatch::hil
