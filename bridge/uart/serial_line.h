// A serial port: bytes in both directions, without any translation. Writing keeps to the pace of the line, so that what
// is sent later does not wait behind what the system has stored. A port that vanishes is opened again once it is back.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "bridge/core/datagram_receiver.h"
#include "bridge/core/port.h"

namespace unlatch::bridge {

class SerialLine {
 public:
  struct Events {
    std::function<void(std::span<const std::uint8_t>)> read;
    std::function<void()> free;    // nothing waits to be sent: what gives way to all else may be written now
    std::function<void()> silent;  // nothing has come for some time
    std::function<void()> idle;    // once in each period, whatever comes
  };

  // Called by a thread of its own alone. All that they use must outlive the line. Throws PortError.
  SerialLine(const UartOptions& options, Events events);
  // Waits for what is to be sent, at most a second; ends the thread.
  ~SerialLine();
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  // From any thread. False if so much waits already that this finds no place.
  bool write(std::span<const std::uint8_t> bytes);
  // Lets the thread look whether it is `free`. From any thread.
  void wake();
  // Bytes that have not left yet.
  [[nodiscard]] std::size_t count_waiting() const;

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  void read_all();
  void write_some();
  void reopen();
  [[nodiscard]] Clock::duration get_time(std::size_t bytes) const;

  const UartOptions options_;
  const Events events_;
  const Descriptor wake_event_;
  int file_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  std::vector<std::uint8_t> waiting_;  // to be sent
  Clock::time_point free_at_;          // when the line has sent what it has been given
  Clock::time_point heard_;
  bool is_silent_ = true;
  std::jthread thread_;
};

}  // namespace unlatch::bridge
