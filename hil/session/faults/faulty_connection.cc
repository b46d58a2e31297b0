#include "hil/session/faults/faulty_connection.h"

#include <utility>

namespace unlatch::hil {
namespace {

constexpr int kMaxArrivals = 512;  // collected at once: bounds the work of a tick

}  // namespace

bool FaultyConnection::send(const Message& message) noexcept {
  const std::int64_t now_ns = clock_.get_ns();
  faults_.offer(Direction::kOut, message, 0, now_ns, {});
  send_due(now_ns);
  return true;
}

void FaultyConnection::send_due(std::int64_t now_ns) noexcept {
  std::int64_t arrived_ns = 0;
  while (faults_.take(Direction::kOut, now_ns, out_, arrived_ns)) {
    if (out_.kind == MessageKind::kState) faults_.note_sent(out_.state);
    inner_.send(out_);
  }
}

void FaultyConnection::collect() noexcept {
  for (int i = 0; i < kMaxArrivals && inner_.receive(arrival_); ++i) {
    if (const auto* const hello = std::get_if<HelloMessage>(&arrival_.message)) {
      other_simulator_ = Arrival{*hello, arrival_.arrived_ns};  // none of this session's messages
      continue;
    }
    in_ = std::visit([](const auto& message) { return Message(message); }, arrival_.message);
    faults_.offer(Direction::kIn, in_, arrival_.arrived_ns, clock_.get_ns(), find_sender(in_));
  }
  collected_ns_ = clock_.get_ns();
  faults_.end_timed_freezes(collected_ns_, participants_, resume_);
}

bool FaultyConnection::receive(Arrival& arrival) noexcept {
  if (!std::exchange(is_collected_, true)) collect();
  if (other_simulator_) {
    arrival = *std::exchange(other_simulator_, std::nullopt);
    return true;
  }
  while (faults_.take(Direction::kIn, collected_ns_, in_, arrival.arrived_ns)) {
    const auto message = to_participant_message(in_);
    if (!message) continue;
    arrival.message = *message;
    return true;
  }
  is_collected_ = false;
  send_due(collected_ns_);
  return false;
}

std::string_view FaultyConnection::find_sender(const Message& message) noexcept {
  if (message.kind == MessageKind::kHelloAck) return get_name(message.hello_ack.name);
  const std::int32_t id =
      message.kind == MessageKind::kCommand ? message.command.participant : message.step_ack.participant;
  const Participant* const participant = participants_.find(id);
  return participant != nullptr ? std::string_view(participant->name) : std::string_view();
}

}  // namespace unlatch::hil
