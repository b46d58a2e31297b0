// The executive's line when it has no deadlines: straight to the port, without rings and threads in between, each of
// which would cost a wake-up per tick. In lockstep everybody waits for the answer anyway.
#pragma once

#include "bridge/port.h"
#include "hil/messages/line.h"

namespace unlatch::bridge {

class PortLine final : public hil::Line {
 public:
  // The port belongs to the simulator's side and must outlive the line; nobody else may use it meanwhile.
  explicit PortLine(Port& port) : port_(port) {}

  bool send(const Message& message) noexcept override;
  bool receive(Message& message, std::int64_t& arrived_ns) noexcept override;
  void wait(std::chrono::nanoseconds limit) noexcept override;

  [[nodiscard]] std::int64_t get_dropped_out() const noexcept override { return port_.get_counts().publish_failures; }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept override { return port_.get_counts().lost; }
  [[nodiscard]] std::int64_t get_malformed() const noexcept override { return port_.get_malformed(); }

 private:
  Port& port_;
  Message awaited_;  // heard by wait(), not received yet
  std::int64_t arrived_ns_ = 0;
  bool is_awaited_ = false;
};

}  // namespace unlatch::bridge
