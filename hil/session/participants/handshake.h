// Answers to Hello: admission of participants, refusal of those that do not agree with the session, departures.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hil/session/messages/event_names.h"
#include "hil/session/messages/messages.h"
#include "hil/session/participants/participants.h"

namespace unlatch::hil {

class Handshake {
 public:
  // Result of one HelloAck, to be counted and published.
  struct Outcome {
    std::optional<Reject> reject = {};
    bool verdict = false;                    // the refusal is answered with a Verdict
    std::string_view notice = {};            // name of the Event to publish; empty: none
    const Participant* restarted = nullptr;  // participant whose earlier commands are discarded
  };

  // `hello`: the terms of the session. `participants` must outlive it.
  Handshake(const HelloMessage& hello, Participants& participants) : hello_(hello), participants_(participants) {}

  Outcome receive(const HelloAckMessage& answer, std::int64_t now_ns) noexcept;

  // Begins the run: from now on a refusal is no reason not to start.
  void begin_run() noexcept { begun_ = true; }
  // Reason why a required participant does not take part, before the run; empty if none refused.
  [[nodiscard]] const std::string& get_refusal() const noexcept { return refusal_; }

 private:
  Outcome refuse(const HelloAckMessage& answer, Reject reason, std::string_view notice) noexcept;
  [[nodiscard]] std::string_view find_mismatch(const HelloAckMessage& answer) const noexcept;

  const HelloMessage hello_;
  Participants& participants_;
  bool begun_ = false;
  std::string refusal_;
  std::optional<std::int32_t> refused_id_;  // participant of the latest refusal: each start has one notice
};

}  // namespace unlatch::hil
