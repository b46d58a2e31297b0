// Messages as bytes, from one thread to another: the oldest give way to new ones when the memory is full.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "hil/session/messages/messages.h"

namespace unlatch::bridge {

class MessageRing {
 public:
  // `bytes`: of all messages that wait, their heads included; more than the longest message needs.
  explicit MessageRing(std::size_t bytes);

  void push(hil::MessageKind kind, std::span<const std::uint8_t> data);
  // The oldest, decoded; waits for it at most `wait`. `readable`: its bytes are the message's. False: none came.
  bool pop(hil::Message& message, bool& readable, std::chrono::nanoseconds wait);
  // Messages that gave way.
  [[nodiscard]] std::int64_t get_lost() const;

 private:
  struct Head {
    hil::MessageKind kind;
    std::uint32_t length;
  };
  void write(const void* from, std::size_t length);
  void read(void* to, std::size_t length);

  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::vector<std::uint8_t> bytes_;
  std::size_t first_ = 0, used_ = 0;
  std::int64_t lost_ = 0;
  std::vector<std::uint8_t> scratch_;  // of the thread that pops
};

}  // namespace unlatch::bridge
