// The answers to States: which participants owe one, since when, and the policy for a required one that does not answer
// in time. Wall time decides here; simulated time everything else.
#pragma once

#include <cstdint>
#include <optional>

#include "hil/messages/messages.h"
#include "hil/session/participants.h"
#include "unlatch/model.h"

namespace unlatch::hil {

// The value that `policy` sets a channel to when its participant is lost; none if it leaves the channel alone.
[[nodiscard]] std::optional<double> calc_policy_value(Policy policy, const Channel& channel) noexcept;

class Liveness {
 public:
  // `participants` must outlive it.
  Liveness(Participants& participants, Policy policy, std::int64_t timeout_ns)
      : participants_(participants), policy_(policy), timeout_ns_(timeout_ns) {}

  // The State of `tick` was sent for the first time: each participant owes an answer.
  void begin_round(std::int64_t tick, std::int64_t now_ns) noexcept;
  // It was sent again: the round trip counts from the latest State.
  void restart_round_trip(std::int64_t now_ns) noexcept { sent_ns_ = now_ns; }
  // Answers now count for this tick.
  void set_tick(std::int64_t tick) noexcept { tick_ = tick; }
  // After a pause: answers owed are owed from now on.
  void restart(std::int64_t now_ns) noexcept;

  // A StepAck of this session from a participant that may answer.
  void receive(const StepAckMessage& ack, Participant& sender, std::int64_t arrived_ns, std::int64_t now_ns) noexcept;
  // A lost participant that sends a message is back. True if it was lost.
  bool resume(Participant& participant, std::int64_t now_ns) noexcept;
  // True when all required participants that take part have answered the tick. Those that have owe nothing any more.
  bool update(std::int64_t now_ns) noexcept;
  // The round trip that update() has completed: State sent to last answer, ns. Once for each round.
  [[nodiscard]] std::optional<std::int64_t> take_round_trip_ns() noexcept;

  // A required participant that has not answered in time, or leaves; null if there is none.
  [[nodiscard]] Participant* find_overdue(std::int64_t now_ns) noexcept;
  // The participant is lost, or evicted if the policy is. True if it was leaving.
  bool lose(Participant& participant) noexcept;

  [[nodiscard]] Policy get_policy() const noexcept { return policy_; }
  [[nodiscard]] std::int64_t get_tick() const noexcept { return tick_; }
  // Time of the latest State; none before the first.
  [[nodiscard]] std::optional<std::int64_t> get_sent_ns() const noexcept { return sent_ns_; }

 private:
  Participants& participants_;
  const Policy policy_;
  const std::int64_t timeout_ns_;
  std::int64_t tick_ = 0;                // of the latest State
  std::optional<std::int64_t> sent_ns_;  // its time
  bool round_open_ = false;              // not all have answered yet
  std::optional<std::int64_t> round_trip_ns_;
};

}  // namespace unlatch::hil
