// The answers to Hello: admits participants, refuses those that do not agree with the session, and lets them leave.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hil/messages/event_names.h"
#include "hil/messages/messages.h"
#include "hil/session/participants.h"

namespace unlatch::hil {

class Handshake {
 public:
  // The result of one HelloAck, for the executive to count and publish.
  struct Outcome {
    std::optional<Reject> reject = {};
    bool verdict = false;                    // the refusal is answered with a Verdict
    std::string_view notice = {};            // name of the Event to publish; empty: none
    const Participant* restarted = nullptr;  // earlier commands of this participant are void
  };

  // `hello`: the terms of the session. `participants` must outlive it.
  Handshake(const HelloMessage& hello, Participants& participants) : hello_(hello), participants_(participants) {}

  Outcome receive(const HelloAckMessage& answer, std::int64_t now_ns) noexcept;

  // The run begins: from now on a refusal is no reason not to start.
  void begin_run() noexcept { begun_ = true; }
  // Before that: the reason why a required participant does not take part; empty if none refused.
  [[nodiscard]] const std::string& get_refusal() const noexcept { return refusal_; }

 private:
  Outcome refuse(const HelloAckMessage& answer, Reject reason, std::string_view notice) noexcept;
  [[nodiscard]] std::string_view find_mismatch(const HelloAckMessage& answer) const noexcept;

  const HelloMessage hello_;
  Participants& participants_;
  bool begun_ = false;
  std::string refusal_;
  std::optional<std::int32_t> refused_id_;  // of the latest HelloAck that was refused: each start has one notice
};

}  // namespace unlatch::hil
