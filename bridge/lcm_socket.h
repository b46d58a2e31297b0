// The receiving end of LCM: a socket of our own and a thread that inspects each datagram (lcm_packets.h) and keeps what
// is well-formed until it is polled. liblcm only sends: its own receiver can be made to write outside its memory.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "bridge/lcm_packets.h"
#include "bridge/lcm_route.h"
#include "bridge/message_ring.h"
#include "bridge/port.h"

namespace unlatch::bridge {

class LcmSocket {
 public:
  // Messages that `role` receives, through `interface` alone. Throws PortError.
  LcmSocket(Role role, const LcmRoute& route, const std::string& interface);
  ~LcmSocket();
  LcmSocket(const LcmSocket&) = delete;
  LcmSocket& operator=(const LcmSocket&) = delete;

  // As MessageRing::pop.
  bool pop(hil::Message& message, bool& readable, std::chrono::nanoseconds wait) {
    return ring_.pop(message, readable, wait);
  }
  // Datagrams that were none of LCM's.
  [[nodiscard]] std::int64_t get_malformed() const noexcept { return malformed_.load(std::memory_order_relaxed); }
  // Messages that found the ring full, and datagrams that found the socket's buffer full.
  [[nodiscard]] std::int64_t get_lost() const { return ring_.get_lost() + overflowed_.load(std::memory_order_relaxed); }

 private:
  class Descriptor {
   public:
    explicit Descriptor(int file) : file_(file) {}
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    [[nodiscard]] int get() const { return file_; }

   private:
    const int file_;
  };

  void join_group(const LcmRoute& route, const std::string& interface) const;
  void run();
  void receive();

  const Role role_;
  const Descriptor socket_, stop_;
  MessageRing ring_;
  LcmPackets packets_;                  // of the thread
  std::vector<std::uint8_t> datagram_;  // "
  std::atomic<std::int64_t> malformed_{0}, overflowed_{0};
  std::jthread thread_;
};

}  // namespace unlatch::bridge
