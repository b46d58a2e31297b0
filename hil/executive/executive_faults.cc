// How the faults of a script enter: messages pass through the injector on their way in and out, channels may be held.
#include "hil/executive/executive.h"
#include "hil/realtime/clock.h"

namespace unlatch::hil {

// At the beginning of each tick, before its State is said.
void Executive::begin_faults() noexcept {
  const auto go_on = [this](Participant& participant) {
    tell_faults();
    resume(participant);
  };
  options_.faults->begin_tick(simulation_.get_tick(), clock_.get_ns(), roster_, go_on);
  tell_faults();
  force_channels();
}

void Executive::say(const Message& message) noexcept {
  const MayWait without_deadlines(options_.pace != Pace::kRealtime);
  if (options_.faults == nullptr) {
    link_.send(message);
    return;
  }
  const std::int64_t now_ns = clock_.get_ns();
  std::int64_t arrived_ns = 0;
  options_.faults->offer(Direction::kOut, message, 0, now_ns, {});
  while (options_.faults->take(Direction::kOut, now_ns, spoken_, arrived_ns)) link_.send(spoken_);
}

// What has been held back until now, either way; and freezes that are over by the clock.
void Executive::pass_through_faults() noexcept {
  const std::int64_t now_ns = clock_.get_ns();
  std::int64_t arrived_ns = 0;
  options_.faults->look_at_clock(now_ns, roster_, [this](Participant& participant) { resume(participant); });
  while (options_.faults->take(Direction::kIn, now_ns, message_, arrived_ns)) hear(message_, arrived_ns);
  while (options_.faults->take(Direction::kOut, now_ns, spoken_, arrived_ns)) link_.send(spoken_);
}

// Channels go to where a fault holds them, and when it ends back to what was commanded meanwhile.
void Executive::force_channels() noexcept {
  const auto channels = simulation_.channels();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const double value = options_.faults->get_forced(i, channels[i]).value_or(commanded_[i]);
    set_channel(static_cast<std::int32_t>(i), value, ChangeCause::kFault, -1, 0);
  }
}

void Executive::tell_faults() noexcept {
  FaultNews news;
  while (options_.faults->take_news(news)) publish_notice(news.name, news.fault->subject);
}

std::string_view Executive::find_speaker(const Message& message) noexcept {
  if (message.kind == MessageKind::kHelloAck) return get_name(message.hello_ack.name);
  const std::int32_t id =
      message.kind == MessageKind::kCommand ? message.command.participant : message.step_ack.participant;
  const Participant* const participant = roster_.find(id);
  return participant != nullptr ? std::string_view(participant->name) : std::string_view();
}

}  // namespace unlatch::hil
