// The receiving end of LCM: a socket of our own and a thread that inspects each datagram (lcm_packets.h) and keeps what
// is well-formed until it is polled. liblcm only sends: its own receiver can be made to write outside its memory.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "bridge/core/datagram_receiver.h"
#include "bridge/core/message_ring.h"
#include "bridge/core/port.h"
#include "bridge/lcm/lcm_packets.h"
#include "bridge/lcm/lcm_route.h"

namespace unlatch::bridge {

class LcmSocket {
 public:
  // Messages that `role` receives, through `interface` alone. Throws PortError.
  LcmSocket(Role role, const LcmRoute& route, const std::string& interface);

  // As MessageRing::pop.
  bool pop(hil::Message& message, bool& readable, std::chrono::nanoseconds wait) {
    return ring_.pop(message, readable, wait);
  }
  // Datagrams that were none of LCM's.
  [[nodiscard]] std::int64_t get_malformed() const noexcept { return malformed_.load(std::memory_order_relaxed); }
  // Messages that found the ring full, and datagrams that found the socket's buffer full.
  [[nodiscard]] std::int64_t get_lost() const { return ring_.get_lost() + receiver_.get_overflowed(); }

 private:
  void accept(const sockaddr_in& from, std::span<const std::uint8_t> datagram);

  const Role role_;
  const Descriptor socket_;
  MessageRing ring_;
  LcmPackets packets_;  // of the receiver's thread
  std::atomic<std::int64_t> malformed_{0};
  DatagramReceiver receiver_;  // the last: it uses all others
};

}  // namespace unlatch::bridge
