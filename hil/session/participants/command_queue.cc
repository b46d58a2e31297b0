#include "hil/session/participants/command_queue.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace unlatch::hil {
namespace {

constexpr std::size_t kNodeOverhead = 4 * sizeof(void*);  // colour and three pointers of a red-black tree

std::size_t calc_guest_places(const CommandQueueOptions& options) {
  return std::max<std::size_t>(options.places / CommandQueue::kGuestShare, 1);
}

// One more than its places for each participant: a new command is added before the last one gives way.
std::size_t calc_nodes(const CommandQueueOptions& options, const Participants& participants) {
  const std::size_t required = participants.get_required_count();
  const std::size_t guests = participants.get_capacity() - required;
  return required * (options.places + 1) + guests * (calc_guest_places(options) + 1);
}

}  // namespace

bool CommandQueue::IsSooner::operator()(const Pending& a, const Pending& b) const noexcept {
  return std::tie(a.due_tick, a.command.tick, a.command.sequence) <
         std::tie(b.due_tick, b.command.tick, b.command.sequence);
}

CommandQueue::CommandQueue(std::span<const Channel> channels, const CommandQueueOptions& options,
                           const Participants& participants, RejectCounts& rejects)
    : channels_(channels),
      options_(options),
      participants_(participants),
      rejects_(rejects),
      pool_(calc_nodes(options, participants), sizeof(Pending) + kNodeOverhead) {
  waiting_.reserve(participants.get_capacity());
  for (std::size_t i = 0; i < participants.get_capacity(); ++i) waiting_.emplace_back(&pool_);
}

std::size_t CommandQueue::get_places(const Participant& sender) const noexcept {
  return sender.required ? options_.places : calc_guest_places(options_);
}

// The window in which a command may act is shifted by the transport's delay, as its tick is.
std::optional<Reject> CommandQueue::check(const CommandMessage& command, std::int64_t acts_at, std::int64_t due,
                                          std::int64_t earliest_tick) const noexcept {
  const bool has_limit = command.valid_until_tick >= 0 && command.valid_until_tick < kLastTick;
  if (has_limit && command.valid_until_tick + options_.delay_ticks < acts_at) return Reject::kExpired;
  if (due < acts_at && !options_.accept_late) return Reject::kPastTick;
  if (command.tick - earliest_tick > options_.horizon_ticks) return Reject::kTooFar;
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
  switch (sender->seen.insert(command.sequence)) {
    case SeenCommands::Arrival::kNew:
      break;
    case SeenCommands::Arrival::kSeen:
      if (command.tick == repeated_tick_ || command.tick == repeated_before_) return {.reason = {}, .repeated = true};
      return refused(Reject::kDuplicate);
    case SeenCommands::Arrival::kTooFar:
      return refused(Reject::kJump);
  }
  const std::int64_t due = command.tick + options_.delay_ticks;
  const std::int64_t acts_at = std::max(due, earliest_tick);
  if (const auto reason = check(command, acts_at, due, earliest_tick)) return refused(*reason);
  const bool late = due < acts_at;
  Waiting& waiting = waiting_[static_cast<std::size_t>(participants_.get_index(*sender))];
  const auto place = waiting.insert(waiting.end(), {command, sender, acts_at, late});  // most come in order
  Outcome outcome;
  if (waiting.size() > get_places(*sender)) {
    rejects_.add(Reject::kNoPlace);
    const auto last = std::prev(waiting.end());
    const bool is_new = last == place;
    outcome.displaced = last->command;
    waiting.erase(last);
    if (is_new) return {Reject::kNoPlace, -1};
  }
  if (!late) return outcome;
  ++late_;
  outcome.reason = Reject::kLate;
  outcome.applied_tick = acts_at;
  return outcome;
}

void CommandQueue::remove(const Participant& sender) noexcept {
  waiting_[static_cast<std::size_t>(participants_.get_index(sender))].clear();
}

std::int64_t CommandQueue::count_after(std::int64_t tick) const noexcept {
  std::int64_t sum = 0;
  for (const Waiting& waiting : waiting_)
    sum += std::ranges::count_if(waiting, [tick](const Pending& one) { return one.command.tick > tick; });
  return sum;
}

CommandQueue::Waiting* CommandQueue::find_first_due(std::int64_t tick) noexcept {
  Waiting* first = nullptr;
  for (Waiting& waiting : waiting_) {
    if (waiting.empty() || waiting.begin()->due_tick > tick) continue;
    if (first != nullptr) {
      const Pending &mine = *waiting.begin(), &other = *first->begin();
      const bool is_before = std::tie(mine.command.tick, mine.sender->name, mine.command.sequence) <
                             std::tie(other.command.tick, other.sender->name, other.command.sequence);
      if (!is_before) continue;
    }
    first = &waiting;
  }
  return first;
}

}  // namespace unlatch::hil
