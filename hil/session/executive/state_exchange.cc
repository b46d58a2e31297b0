#include "hil/session/executive/state_exchange.h"

#include <algorithm>
#include <optional>

namespace unlatch::hil {

void StateExchange::publish(RunStatus status, std::int64_t hash) noexcept {
  publisher_.publish_state(status, hash);
  liveness_.begin_round(simulation_.get_tick(), clock_.get_ns());
}

void StateExchange::resend(RunStatus status) noexcept {
  liveness_.set_tick(simulation_.get_tick());
  publisher_.resend_state(status);
}

void StateExchange::repeat(RunStatus status) noexcept {
  const std::int64_t tick = simulation_.get_tick();
  commands_.expect_repeats(tick);
  ask_for_missing_commands(tick);
  resend(status);
}

void StateExchange::ask_for_missing_commands(std::int64_t tick) noexcept {
  for (const Participant& participant : participants_.all()) {
    const StepAckMessage& ack = participant.ack;
    if (!participant.is_present() || ack.tick != tick) continue;
    std::optional<SeenCommands::Gap> gap = participant.seen.find_gap(ack.last_command, ack.command_count);
    for (int asked = 0; gap && asked < Publisher::kVerdictsPerTick; ++asked) {
      publisher_.publish_missing(participant.id, gap->first, gap->count);
      gap = participant.seen.find_gap(ack.last_command, ack.command_count, gap->first + gap->count);
    }
  }
}

bool StateExchange::is_answered(std::int64_t now_ns) noexcept {
  const bool answered = liveness_.update(now_ns);
  if (const auto round_trip_ns = liveness_.take_round_trip_ns()) round_trip_.record(*round_trip_ns);
  return answered;
}

void StateExchange::record_late_answers() noexcept {
  while (const auto round_trip_ns = liveness_.take_late_round_trip_ns()) round_trip_.record(*round_trip_ns);
}

std::int64_t StateExchange::get_quiet_since_ns(std::int64_t sent_ns) const noexcept {
  for (const Participant& participant : participants_.all()) {
    if (!participant.required || !participant.is_present()) continue;
    if (participant.has_answered(liveness_.get_tick())) continue;
    sent_ns = std::max(sent_ns, participant.news_ns.value_or(sent_ns));
  }
  return sent_ns;
}

}  // namespace unlatch::hil
