#include "hil/session/participants/liveness.h"

#include <algorithm>
#include <utility>

namespace unlatch::hil {

using Standing = Participant::Standing;

std::optional<double> calc_policy_value(Policy policy, const Channel& channel) noexcept {
  if (policy == Policy::kZero) return std::clamp(0.0, channel.minimum, channel.maximum);
  if (policy == Policy::kSafe) return channel.safe;
  return std::nullopt;
}

void Liveness::begin_round(std::int64_t tick, std::int64_t now_ns) noexcept {
  if (round_open_ && sent_ns_) {
    LateRound& place = late_rounds_[static_cast<std::size_t>(late_rounds_begun_++) % late_rounds_.size()];
    forgotten_ += place.open ? 1 : 0;
    place = {tick_, *sent_ns_, true};
  }
  tick_ = tick;
  sent_ns_ = now_ns;
  round_open_ = true;
  for (Participant& participant : participants_.all()) {
    if (!participant.waiting_since_ns) participant.waiting_since_ns = now_ns;
  }
}

void Liveness::restart(std::int64_t now_ns) noexcept {
  for (Participant& participant : participants_.all()) {
    if (participant.waiting_since_ns) participant.waiting_since_ns = now_ns;
  }
}

void Liveness::receive(const StepAckMessage& ack, Participant& sender, std::int64_t arrived_ns,
                       std::int64_t now_ns) noexcept {
  if (ack.tick < sender.ack.tick) return;
  if (ack.tick > sender.ack.tick) {
    sender.ack_arrived_ns = arrived_ns;
    sender.waiting_since_ns = now_ns;  // alive: answers that it still owes count from now
  }
  sender.ack = ack;
}

bool Liveness::resume(Participant& participant, std::int64_t now_ns) noexcept {
  if (participant.standing != Standing::kLost) return false;
  participant.standing = Standing::kPresent;
  participant.waiting_since_ns = now_ns;
  participant.seen.allow_jump();
  return true;
}

bool Liveness::update(std::int64_t now_ns) noexcept {
  std::optional<std::int64_t> last_ns;
  bool all = true;
  for (Participant& participant : participants_.all()) {
    if (!participant.is_present()) continue;
    if (participant.has_answered(tick_)) {
      participant.waiting_since_ns.reset();
      if (participant.required)
        last_ns = std::max(last_ns.value_or(participant.ack_arrived_ns), participant.ack_arrived_ns);
    } else {
      // A participant that had answered owes again if it has since announced a command that has not arrived.
      if (!participant.waiting_since_ns) participant.waiting_since_ns = now_ns;
      if (participant.required) all = false;
    }
  }
  if (!all) return false;
  if (std::exchange(round_open_, false) && last_ns) round_trip_ns_ = *last_ns - *sent_ns_;
  return true;
}

std::optional<std::int64_t> Liveness::take_round_trip_ns() noexcept { return std::exchange(round_trip_ns_, {}); }

std::optional<std::int64_t> Liveness::take_late_round_trip_ns() noexcept {
  if (get_unanswered() == forgotten_) return std::nullopt;  // none is open, as usual
  for (LateRound& round : late_rounds_) {
    if (!round.open) continue;
    std::optional<std::int64_t> last_ns;
    bool all = true;
    for (const Participant& participant : participants_.all()) {
      if (!participant.required || !participant.is_present()) continue;
      all = all && participant.ack.tick >= round.tick;
      last_ns = std::max(last_ns.value_or(participant.ack_arrived_ns), participant.ack_arrived_ns);
    }
    if (!all || !last_ns) continue;
    round.open = false;
    ++late_answers_;
    return *last_ns - round.sent_ns;
  }
  return std::nullopt;
}

Participant* Liveness::find_overdue(std::int64_t now_ns) noexcept {
  for (Participant& participant : participants_.all()) {
    if (!participant.required || !participant.is_present()) continue;
    const bool overdue = participant.waiting_since_ns && now_ns - *participant.waiting_since_ns > timeout_ns_;
    if (overdue || participant.leaving) return &participant;
  }
  return nullptr;
}

bool Liveness::lose(Participant& participant) noexcept {
  participant.standing = policy_ == Policy::kEvict ? Standing::kEvicted : Standing::kLost;
  return std::exchange(participant.leaving, false);
}

}  // namespace unlatch::hil
