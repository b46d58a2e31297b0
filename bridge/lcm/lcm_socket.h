// The receiving end of LCM: a socket of our own and a thread that inspects each datagram (lcm_packets.h) and keeps what
// is well-formed until it is polled. liblcm only sends: its own receiver can be made to write outside its memory.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>

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

  // Session of the Hello that a simulator sends from now on; the group brings it back.
  void set_own_session(std::int64_t session) noexcept { own_session_.store(session, std::memory_order_relaxed); }

  // As MessageRing::pop.
  bool pop(hil::Message& message, bool& readable, std::chrono::nanoseconds wait) {
    return ring_.pop(message, readable, wait);
  }
  // Datagrams that were none of LCM's.
  [[nodiscard]] std::int64_t get_malformed() const noexcept { return malformed_.load(std::memory_order_relaxed); }
  // Messages that found the ring full, and datagrams that found the socket's buffer full.
  [[nodiscard]] std::int64_t get_lost() const { return ring_.get_lost() + receiver_.get_overflowed(); }

 private:
  static constexpr std::int64_t kNoSession = std::numeric_limits<std::int64_t>::min();

  void accept(const sockaddr_in& from, std::span<const std::uint8_t> datagram);
  bool is_own(std::uint64_t sender, const LcmPackets::Packet& packet);

  const Role role_;
  const Descriptor socket_;
  MessageRing ring_;
  std::atomic<std::int64_t> own_session_{kNoSession};
  LcmPackets packets_;                       // of the receiver's thread, as the next two
  std::optional<std::uint64_t> own_sender_;  // address from which our own Hello comes back
  hil::Message hello_;                       // scratch
  std::atomic<std::int64_t> malformed_{0};
  DatagramReceiver receiver_;  // the last: it uses all others
};

}  // namespace unlatch::bridge
