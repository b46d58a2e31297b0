// Connection of the executive to the participants: sends, receives without waiting, and in lockstep waits for messages.
// Implementations: RingConnection (real time), bridge::DirectConnection (lockstep), FaultyConnection.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <variant>

#include "hil/session/messages/messages.h"

namespace unlatch::hil {

// Message that a simulator receives: from a participant, or another simulator's Hello. A tenth of the size of
// Message, which has space for a State as well.
using ParticipantMessage = std::variant<HelloAckMessage, CommandMessage, StepAckMessage, HelloMessage>;

struct Arrival {
  ParticipantMessage message;
  std::int64_t arrived_ns = 0;  // time of arrival, of the session's clock
};

// Empty if a simulator does not receive this kind.
[[nodiscard]] inline std::optional<ParticipantMessage> to_participant_message(const Message& message) noexcept {
  switch (message.kind) {
    case MessageKind::kHelloAck:
      return message.hello_ack;
    case MessageKind::kCommand:
      return message.command;
    case MessageKind::kStepAck:
      return message.step_ack;
    case MessageKind::kHello:
      return message.hello;
    default:
      return std::nullopt;
  }
}

// Interface for the cyclic thread alone, except for the counts.
class Connection {
 public:
  virtual ~Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // False if the message could not be sent, which is counted.
  virtual bool send(const Message& message) noexcept = 0;
  // False if no message has arrived.
  virtual bool receive(Arrival& arrival) noexcept = 0;
  // Sleeps until a message has arrived, at most for `limit`. Never called in real time.
  virtual void wait(std::chrono::nanoseconds limit) noexcept = 0;

  // Messages dropped because a queue was full. From any thread.
  [[nodiscard]] virtual std::int64_t get_dropped_out() const noexcept = 0;
  [[nodiscard]] virtual std::int64_t get_dropped_in() const noexcept = 0;
  // Messages that the transport dropped because they do not match the schema; the executive publishes their number.
  [[nodiscard]] virtual std::int64_t get_malformed() const noexcept = 0;

 protected:
  Connection() = default;
};

}  // namespace unlatch::hil
