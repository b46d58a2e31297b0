// The only way between the cyclic thread and the rest of the process: two bounded rings without locks, system calls or
// allocation, one out (states, events) and one in (commands, acknowledgements). Exactly one thread may call send and
// receive, exactly one take, and exactly one deliver (the last two may be the same thread).
#pragma once

#include <readerwriterqueue/readerwritercircularbuffer.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "hil/messages.h"

namespace unlatch::hil {

class Link {
 public:
  // Capacities in messages; all memory is allocated and touched here (a slot is some 2.3 kB).
  explicit Link(std::size_t out_capacity = 1024, std::size_t in_capacity = 1024)
      : out_(out_capacity), in_(in_capacity) {
    touch(out_, out_capacity);
    touch(in_, in_capacity);
  }

  // Cyclic thread. False when the ring is full, which is counted; false when there is nothing to receive.
  bool send(const Message& message) noexcept { return put(out_, message, dropped_out_); }
  bool receive(Message& message) noexcept { return in_.try_dequeue(message); }

  // Bridge threads.
  bool take(Message& message) noexcept { return out_.try_dequeue(message); }
  bool deliver(const Message& message) noexcept { return put(in_, message, dropped_in_); }

  // Messages that found a ring full. From any thread.
  [[nodiscard]] std::int64_t get_dropped_out() const noexcept { return dropped_out_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept { return dropped_in_.load(std::memory_order_relaxed); }

 private:
  // Of this queue only the try_ calls are used: they are two atomic counters and a copy. Its semaphores would enter the
  // kernel only to wake a thread that waits in them, and none ever does.
  using Ring = moodycamel::BlockingReaderWriterCircularBuffer<Message>;

  static bool put(Ring& ring, const Message& message, std::atomic<std::int64_t>& dropped) noexcept {
    if (ring.try_enqueue(message)) return true;
    dropped.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  // So that the cyclic thread never meets a page for the first time.
  static void touch(Ring& ring, std::size_t capacity) {
    Message message{State{}};
    for (std::size_t i = 0; i < capacity; ++i) ring.try_enqueue(message);
    while (ring.try_dequeue(message)) {
    }
  }

  Ring out_;
  Ring in_;
  std::atomic<std::int64_t> dropped_out_{0};
  std::atomic<std::int64_t> dropped_in_{0};
};

}  // namespace unlatch::hil
