// Answers to States: participants that owe one, since when, and the policy for a required one that does not answer in
// time. Wall time decides here; simulated time everything else.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hil/session/messages/messages.h"
#include "hil/session/participants/participants.h"
#include "unlatch/model.h"

namespace unlatch::hil {

// Value of a channel after the loss of its participant; none if `policy` leaves the channel alone.
[[nodiscard]] std::optional<double> calc_policy_value(Policy policy, const Channel& channel) noexcept;

class Liveness {
 public:
  // `participants` must outlive it.
  Liveness(Participants& participants, Policy policy, std::int64_t timeout_ns)
      : participants_(participants), policy_(policy), timeout_ns_(timeout_ns) {}

  // Begins the round of `tick`, whose State was sent for the first time: each participant owes an answer.
  void begin_round(std::int64_t tick, std::int64_t now_ns) noexcept;
  // Restarts the round trip: the State was sent again.
  void restart_round_trip(std::int64_t now_ns) noexcept { sent_ns_ = now_ns; }
  // Tick that answers now count for.
  void set_tick(std::int64_t tick) noexcept { tick_ = tick; }
  // Restarts the timeout of pending answers, after a pause.
  void restart(std::int64_t now_ns) noexcept;

  // Takes a StepAck of this session from a participant that may answer.
  void receive(const StepAckMessage& ack, Participant& sender, std::int64_t arrived_ns, std::int64_t now_ns) noexcept;
  // Readmits a lost participant that has sent a message. True if it was lost.
  bool resume(Participant& participant, std::int64_t now_ns) noexcept;
  // True when all required participants that take part have answered the tick. Those that have owe nothing any more.
  bool update(std::int64_t now_ns) noexcept;
  // Round trip that update() has completed: State sent to last answer, ns. Once for each round.
  [[nodiscard]] std::optional<std::int64_t> take_round_trip_ns() noexcept;

  // Round trip of a State whose last answer came after the next State, ns; call until there is none. An answer to a
  // later State stands for those before it: the time is then an upper bound.
  [[nodiscard]] std::optional<std::int64_t> take_late_round_trip_ns() noexcept;
  // Numbers of such States, and of those whose answer never came; a State that has just been sent is none of them.
  [[nodiscard]] std::int64_t get_late_answers() const noexcept { return late_answers_; }
  [[nodiscard]] std::int64_t get_unanswered() const noexcept { return late_rounds_begun_ - late_answers_; }

  // Required participant that has not answered in time, or leaves; null if there is none.
  [[nodiscard]] Participant* find_overdue(std::int64_t now_ns) noexcept;
  // Marks the participant as lost, or as evicted under that policy. True if it was leaving.
  bool lose(Participant& participant) noexcept;

  [[nodiscard]] Policy get_policy() const noexcept { return policy_; }
  [[nodiscard]] std::int64_t get_tick() const noexcept { return tick_; }
  // Time of the latest State; none before the first.
  [[nodiscard]] std::optional<std::int64_t> get_sent_ns() const noexcept { return sent_ns_; }

 private:
  Participants& participants_;
  const Policy policy_;
  const std::int64_t timeout_ns_;
  std::int64_t tick_ = 0;                // tick of the latest State
  std::optional<std::int64_t> sent_ns_;  // time of the latest State
  bool round_open_ = false;              // answers are missing
  std::optional<std::int64_t> round_trip_ns_;
  // The latest States that were not answered when the next was sent; the oldest gives its place up.
  struct LateRound {
    std::int64_t tick = 0, sent_ns = 0;
    bool open = false;
  };
  std::array<LateRound, 256> late_rounds_{};
  std::int64_t late_rounds_begun_ = 0, late_answers_ = 0;
  std::int64_t forgotten_ = 0;  // that gave their places up
};

}  // namespace unlatch::hil
