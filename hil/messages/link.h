// The cyclic thread's line when it has deadlines: two bounded rings without locks, system calls or allocation, one out
// (states, events) and one in (commands, acknowledgements). Exactly one thread may call send, receive and wait, exactly
// one take, and exactly one deliver (the last two may be the same thread).
#pragma once

#include <readerwriterqueue/readerwritercircularbuffer.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "hil/messages/line.h"

namespace unlatch::hil {

class Link final : public Line {
 public:
  // Capacities in messages; all memory is allocated and touched here (a slot is some 2.3 kB).
  explicit Link(std::size_t out_capacity = 1024, std::size_t in_capacity = 1024)
      : out_(out_capacity), in_(in_capacity) {
    touch(out_, out_capacity);
    touch(in_, in_capacity);
  }

  // Cyclic thread.
  bool send(const Message& message) noexcept override { return put(out_, message, dropped_out_); }
  bool receive(Message& message, std::int64_t& arrived_ns) noexcept override {
    if (!awaited_ && !in_.try_dequeue(arrival_)) return false;
    awaited_ = false;
    message = arrival_.message;
    arrived_ns = arrival_.at_ns;
    return true;
  }
  bool receive(Message& message) noexcept {
    std::int64_t arrived_ns;
    return receive(message, arrived_ns);
  }
  void wait(std::chrono::nanoseconds limit) noexcept override {
    if (!awaited_) awaited_ = in_.wait_dequeue_timed(arrival_, limit);
  }

  // Bridge threads.
  bool take(Message& message) noexcept { return out_.try_dequeue(message); }
  bool deliver(const Message& message) noexcept {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return put(in_, Arrival{message, std::chrono::nanoseconds(now).count()}, dropped_in_);
  }

  // How many malformed messages the bridge has met so far: it is the bridge that drops them, the executive that tells.
  void set_malformed(std::int64_t count) noexcept { malformed_.store(count, std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t get_malformed() const noexcept override {
    return malformed_.load(std::memory_order_relaxed);
  }

  // Messages that found a ring full. From any thread.
  [[nodiscard]] std::int64_t get_dropped_out() const noexcept override {
    return dropped_out_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept override {
    return dropped_in_.load(std::memory_order_relaxed);
  }

 private:
  // Of this queue only the try_ calls are used, but for wait: they are two atomic counters and a copy. Its semaphores
  // enter the kernel only to wake a thread that waits in them: never the bridge's, which do not wait.
  template <class T>
  using Ring = moodycamel::BlockingReaderWriterCircularBuffer<T>;
  struct Arrival {
    Message message;
    std::int64_t at_ns = 0;
  };

  template <class T>
  static bool put(Ring<T>& ring, const T& message, std::atomic<std::int64_t>& dropped) noexcept {
    if (ring.try_enqueue(message)) return true;
    dropped.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  // So that the cyclic thread never meets a page for the first time.
  template <class T>
  static void touch(Ring<T>& ring, std::size_t capacity) {
    T message{State{}};
    for (std::size_t i = 0; i < capacity; ++i) ring.try_enqueue(message);
    while (ring.try_dequeue(message)) {
    }
  }

  Ring<Message> out_;
  Ring<Arrival> in_;
  Arrival arrival_;       // of the cyclic thread
  bool awaited_ = false;  // arrival_ has not been received yet
  std::atomic<std::int64_t> dropped_out_{0};
  std::atomic<std::int64_t> dropped_in_{0};
  std::atomic<std::int64_t> malformed_{0};
};

}  // namespace unlatch::hil
