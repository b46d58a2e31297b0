// Numbers of telemetry that people see.
#pragma once

#include <cstdint>

namespace unlatch::bridge {

struct OutletCounts {
  std::int64_t sent = 0;     // packets, or messages, to all clients together
  std::int64_t dropped = 0;  // that found a client's queue full, or that a socket refused
  std::int64_t clients = 0;  // now
  std::int64_t refused = 0;  // clients beyond the most that are served, or that do not speak the protocol

  void add(const OutletCounts& other) {
    sent += other.sent;
    dropped += other.dropped;
  }
};

}  // namespace unlatch::bridge
