// Telemetry of a session for control rooms and displays: space packets by UDP and TCP, topics by WebSocket. It hears a
// session as an observer does, in a program of its own: the simulator does not know of it, and never waits for it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bridge/core/port.h"
#include "bridge/telemetry/session_layout.h"
#include "bridge/telemetry/telemetry_counts.h"

namespace unlatch::bridge {

struct TelemetryOptions {
  std::string udp, tcp, live;        // addresses; empty: none
  std::vector<std::string> origins;  // of pages that may connect to `live`, beside those of this machine and Foxglove
  double rate = 50;                  // States in a second of wall time at most; 0: all
};

struct TelemetryReport {
  std::int64_t heard = 0, thinned = 0;  // messages; States that `rate` left out
  std::int64_t early = 0;               // messages before the layout was complete
  std::int64_t lost = 0;                // messages of the session that never came, by their numbers
  std::int64_t states_lost = 0;         // of these State messages
  OutletCounts packets, live;
};

// Implemented in the module unlatch-telemetry (telemetry_module.cc), which holds sockets and the WebSocket.
class Telemetry {
 public:
  using Time = std::chrono::steady_clock::time_point;

  Telemetry() = default;
  virtual ~Telemetry() = default;
  Telemetry(const Telemetry&) = delete;
  Telemetry& operator=(const Telemetry&) = delete;

  // Called with each layout that is complete.
  std::function<void(const SessionLayout&)> on_layout;

  virtual void hear(const hil::Message& message, Time now) = 0;
  // Does what the sockets are ready for; never waits. True if there may be more at once.
  virtual bool serve() = 0;
  [[nodiscard]] virtual TelemetryReport get_report() const = 0;
};

}  // namespace unlatch::bridge
