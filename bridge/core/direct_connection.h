// The executive's connection in lockstep: straight to a port, without rings and threads, each of which would cost a
// wake-up per tick. In lockstep the simulation waits for the answer anyway.
#pragma once

#include "bridge/core/port.h"
#include "hil/session/participants/connection.h"
#include "hil/session/realtime/clock.h"

namespace unlatch::bridge {

class DirectConnection final : public hil::Connection {
 public:
  // The port has the simulator's role and must outlive the connection, which alone may use it meanwhile.
  explicit DirectConnection(Port& port, const hil::Clock& clock = hil::kMonotonicClock) : port_(port), clock_(clock) {}

  bool send(const Message& message) noexcept override;
  bool receive(hil::Arrival& arrival) noexcept override;
  void wait(std::chrono::nanoseconds limit) noexcept override;

  [[nodiscard]] std::int64_t get_dropped_out() const noexcept override { return port_.get_counts().publish_failures; }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept override { return port_.get_counts().lost; }
  [[nodiscard]] std::int64_t get_malformed() const noexcept override { return port_.get_malformed(); }

 private:
  Port& port_;
  const hil::Clock& clock_;
  Message message_;          // the port decodes into it
  bool is_awaited_ = false;  // message_ was polled by wait() and not received yet
  std::int64_t awaited_ns_ = 0;
};

}  // namespace unlatch::bridge
