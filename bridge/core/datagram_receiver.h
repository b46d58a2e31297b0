// A thread that reads the datagrams of a UDP socket as they come and hands each to its owner.
#pragma once

#include <netinet/in.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace unlatch::bridge {

// A file descriptor that is closed with it; −1 for none.
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

// A UDP socket that does not block, with a large buffer for what comes. Throws PortError; `transport` begins its text.
[[nodiscard]] int open_datagram_socket(const std::string& transport);

// The error of the system call that has just failed, as a PortError: "UDP: binding the port failed: …".
[[noreturn]] void throw_port_error(const std::string& transport, const std::string& what);

class DatagramReceiver {
 public:
  using Accept = std::function<void(const sockaddr_in& from, std::span<const std::uint8_t> datagram)>;
  using Idle = std::function<void()>;

  // Both are called by the thread alone; `idle` once in each `period` or somewhat later, whatever comes. The socket
  // stays the caller's and must outlive the receiver; so must all that the functions use.
  DatagramReceiver(int socket, Accept accept, Idle idle = {},
                   std::chrono::milliseconds period = std::chrono::hours(24));
  // Ends the thread.
  ~DatagramReceiver();
  DatagramReceiver(const DatagramReceiver&) = delete;
  DatagramReceiver& operator=(const DatagramReceiver&) = delete;

  // Datagrams that found the socket's buffer full.
  [[nodiscard]] std::int64_t get_overflowed() const noexcept { return overflowed_.load(std::memory_order_relaxed); }

 private:
  void run();
  bool receive();

  const int socket_;
  const Accept accept_;
  const Idle idle_;
  const std::chrono::milliseconds period_;
  const Descriptor stop_;
  std::vector<std::uint8_t> datagram_;  // of the thread
  std::atomic<std::int64_t> overflowed_{0};
  std::jthread thread_;
};

}  // namespace unlatch::bridge
