#include "bridge/target/pending_commands.h"

#include <cmath>

namespace unlatch::target {
namespace {

constexpr std::int64_t kLastTick = std::int64_t{1} << 53;  // beyond it two ticks may have one time in seconds

bool is_sooner(const unlatch_wire_command& a, const unlatch_wire_command& b) {
  return a.tick != b.tick ? a.tick < b.tick : a.sequence < b.sequence;
}

}  // namespace

bool PendingCommands::open(const SessionImage& image) {
  delay_ = image.get_hello().delay_ticks;
  channels_ = static_cast<std::size_t>(image.get_hello().channel_count);
  if (channels_ > kMostChannels) return false;
  for (std::size_t i = 0; i < image.get_count(); ++i) {
    const unlatch_wire_catalog item = image.get_item(i);
    if (item.kind != UNLATCH_CATALOG_KIND_CHANNEL) continue;
    const auto index = static_cast<std::size_t>(item.index);
    if (index < channels_) ranges_[index] = {item.minimum, item.maximum};
  }
  return true;
}

void PendingCommands::restart() {
  count_ = 0;
  seen_ = hil::SeenCommands{};
}

std::optional<std::int32_t> PendingCommands::check(const unlatch_wire_command& command, std::int64_t tick) const {
  const std::int64_t due = command.tick + delay_, acts_at = due < tick ? tick : due;
  const bool has_limit = command.valid_until_tick >= 0 && command.valid_until_tick < kLastTick;
  if (has_limit && command.valid_until_tick + delay_ < acts_at) return UNLATCH_REJECT_EXPIRED;
  if (due < tick) return UNLATCH_REJECT_PAST_TICK;
  if (command.channel < 0 || static_cast<std::size_t>(command.channel) >= channels_)
    return UNLATCH_REJECT_UNKNOWN_CHANNEL;
  if (!std::isfinite(command.value)) return UNLATCH_REJECT_NOT_FINITE;
  const Range& range = ranges_[command.channel];
  if (command.value < range.least || command.value > range.most) return UNLATCH_REJECT_OUT_OF_RANGE;
  return std::nullopt;
}

PendingCommands::Outcome PendingCommands::add(const unlatch_wire_command& command, std::int64_t tick) {
  if (command.sequence < 1 || command.tick < 0 || command.tick > kLastTick) return {UNLATCH_REJECT_MALFORMED};
  switch (seen_.insert(command.sequence)) {
    case hil::SeenCommands::Arrival::kNew:
      break;
    case hil::SeenCommands::Arrival::kSeen:
      if (command.tick == tick || command.tick == tick - 1) return {.reason = {}, .repeated = true};
      return {UNLATCH_REJECT_DUPLICATE};
    case hil::SeenCommands::Arrival::kTooFar:
      return {UNLATCH_REJECT_JUMP};
  }
  if (const auto reason = check(command, tick)) return {*reason};
  if (count_ == kPlaces) return {UNLATCH_REJECT_NO_PLACE};
  std::size_t place = count_++;
  for (; place > 0 && is_sooner(waiting_[place - 1], command); --place) waiting_[place] = waiting_[place - 1];
  waiting_[place] = command;
  return {};
}

const unlatch_wire_command* PendingCommands::take_due(std::int64_t tick) {
  if (count_ == 0 || waiting_[count_ - 1].tick + delay_ > tick) return nullptr;
  due_ = waiting_[--count_];
  return &due_;
}

}  // namespace unlatch::target
