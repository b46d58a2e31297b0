// Connection with the message faults of a script: it stands between the executive and the real connection, above all
// transports.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "hil/session/faults/fault_injector.h"
#include "hil/session/participants/connection.h"
#include "hil/session/participants/participants.h"
#include "hil/session/realtime/clock.h"

namespace unlatch::hil {

class FaultyConnection final : public Connection {
 public:
  // All must outlive it. `resume` is called by receive() for a participant whose freeze has ended by the clock.
  FaultyConnection(Connection& inner, FaultInjector& faults, Participants& participants, const Clock& clock,
                   std::function<void(Participant&)> resume)
      : inner_(inner), faults_(faults), participants_(participants), clock_(clock), resume_(std::move(resume)) {}

  // True: losses here are deliberate.
  bool send(const Message& message) noexcept override;
  bool receive(Arrival& arrival) noexcept override;
  void wait(std::chrono::nanoseconds limit) noexcept override { inner_.wait(limit); }

  [[nodiscard]] std::int64_t get_dropped_out() const noexcept override { return inner_.get_dropped_out(); }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept override {
    return inner_.get_dropped_in() + faults_.get_dropped();
  }
  [[nodiscard]] std::int64_t get_malformed() const noexcept override {
    return inner_.get_malformed() + faults_.get_malformed();
  }

 private:
  void collect() noexcept;
  void send_due(std::int64_t now_ns) noexcept;
  [[nodiscard]] std::string_view find_sender(const Message& message) noexcept;

  Connection& inner_;
  FaultInjector& faults_;
  Participants& participants_;
  const Clock& clock_;
  const std::function<void(Participant&)> resume_;
  bool is_collected_ = false;  // arrivals have been passed to the injector; receive() gives its results
  std::int64_t collected_ns_ = 0;
  std::optional<Arrival> other_simulator_;  // latest Hello of another simulator
  Message in_, out_;                        // scratch
  Arrival arrival_;                         // scratch
};

}  // namespace unlatch::hil
