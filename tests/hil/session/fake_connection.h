// A connection and a clock in memory, for tests of the parts of a session.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "hil/session/participants/connection.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/nonblocking.h"

namespace unlatch::test {

class FakeConnection final : public hil::Connection {
 public:
  bool send(const hil::Message& message) noexcept override {
    const hil::MayWait own_memory;
    if (is_full) return false;
    sent.push_back(message);
    return true;
  }
  bool receive(hil::Arrival& arrival) noexcept override {
    const hil::MayWait own_memory;  // a queue of the test, from which the cyclic thread of a run never reads
    if (arrivals.empty()) return false;
    arrival = arrivals.front();
    arrivals.pop_front();
    return true;
  }
  void wait(std::chrono::nanoseconds) noexcept override {}
  [[nodiscard]] std::int64_t get_dropped_out() const noexcept override { return 0; }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept override { return 0; }
  [[nodiscard]] std::int64_t get_malformed() const noexcept override { return 0; }

  [[nodiscard]] std::vector<hil::MessageKind> list_kinds() const {
    std::vector<hil::MessageKind> kinds;
    for (const hil::Message& message : sent) kinds.push_back(message.kind);
    return kinds;
  }

  bool is_full = false;
  std::vector<hil::Message> sent;
  std::deque<hil::Arrival> arrivals;
};

// Clock that stands still, except during sleep.
class ManualClock final : public hil::Clock {
 public:
  explicit ManualClock(std::int64_t at_ns) : now_ns(at_ns) {}
  [[nodiscard]] std::int64_t get_ns() const noexcept override { return now_ns; }
  void sleep_until_ns(std::int64_t deadline_ns) const noexcept override {
    if (deadline_ns > now_ns) now_ns = deadline_ns;
  }
  mutable std::int64_t now_ns;
};

inline hil::HelloAckMessage make_hello_ack(std::int32_t id = 7, const char* name = "fsw") {
  hil::HelloAckMessage answer;
  answer.session = 4711;
  answer.schema_hash = hil::kSchemaHash;
  answer.model_hash = 1;
  answer.dt_ns = 1'000'000;
  answer.protocol = hil::kProtocolVersion;
  answer.participant = id;
  answer.status = static_cast<std::int32_t>(hil::AckStatus::kReady);
  hil::set_name(answer.name, name);
  return answer;
}

inline hil::StepAckMessage make_step_ack(std::int64_t tick, std::int32_t id = 7) {
  hil::StepAckMessage ack;
  ack.session = 4711;
  ack.tick = tick;
  ack.participant = id;
  return ack;
}

inline hil::CommandMessage make_command(std::int64_t sequence, std::int64_t tick, double value, std::int32_t id = 7,
                                        std::int32_t channel = 0) {
  hil::CommandMessage command;
  command.session = 4711;
  command.sequence = sequence;
  command.tick = tick;
  command.valid_until_tick = -1;
  command.value = value;
  command.participant = id;
  command.channel = channel;
  return command;
}

}  // namespace unlatch::test
