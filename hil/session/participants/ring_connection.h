// Connection in real time: two bounded rings without locks, system calls or allocation, one out (states, events)
// and one in (commands, acknowledgements). Exactly one thread may call send, receive and wait, exactly one take, and
// exactly one deliver (the last two may be the same thread).
#pragma once

#include <readerwriterqueue/readerwritercircularbuffer.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <variant>

#include "hil/session/participants/arrival_shares.h"
#include "hil/session/participants/connection.h"
#include "hil/session/realtime/clock.h"

namespace unlatch::hil {

class RingConnection : public Connection {
 public:
  // Messages that may wait: out, and in from one sender; others have as many places again (arrival_shares.h). All
  // memory is allocated and touched here (2.3 kB for a message out, 0.4 kB for one in).
  explicit RingConnection(std::size_t out_capacity = 1024, std::size_t in_capacity = 1024,
                          const Clock& clock = kMonotonicClock)
      : clock_(clock), out_(out_capacity), in_(2 * in_capacity) {
    touch(out_, out_capacity, Message{StateMessage{}});
    touch(in_, 2 * in_capacity, Waiting{});
  }

  // Cyclic thread.
  bool send(const Message& message) noexcept override { return put(out_, message, dropped_out_); }
  bool receive(Arrival& arrival) noexcept override {
    if (!is_awaited_ && !in_.try_dequeue(waiting_)) return false;
    is_awaited_ = false;
    shares_.give_back(waiting_.place);
    arrival = waiting_.arrival;
    return true;
  }
  void wait(std::chrono::nanoseconds limit) noexcept override {
    if (!is_awaited_) is_awaited_ = in_.wait_dequeue_timed(waiting_, limit);
  }

  // The other end: threads of the transport.
  bool take(Message& message) noexcept { return out_.try_dequeue(message); }
  bool deliver(const ParticipantMessage& message) noexcept {
    const auto place = shares_.take(get_sender(message), in_.max_capacity() - in_.size_approx());
    if (place && in_.try_enqueue({{message, clock_.get_ns()}, *place})) return true;
    dropped_in_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  // Malformed messages that the transport has dropped so far.
  void set_malformed(std::int64_t count) noexcept { malformed_.store(count, std::memory_order_relaxed); }

  [[nodiscard]] std::int64_t get_malformed() const noexcept override {
    return malformed_.load(std::memory_order_relaxed);
  }
  // Messages that found a ring, or their sender's share of it, full. From any thread.
  [[nodiscard]] std::int64_t get_dropped_out() const noexcept override {
    return dropped_out_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept override {
    return dropped_in_.load(std::memory_order_relaxed);
  }

 private:
  struct Waiting {
    Arrival arrival;
    std::uint8_t place = 0;  // among the shares
  };

  // The number that it gives; other simulators are one sender.
  static std::int64_t get_sender(const ParticipantMessage& message) noexcept {
    return std::visit(
        [](const auto& one) -> std::int64_t {
          if constexpr (requires { one.participant; }) return one.participant;
          return std::numeric_limits<std::int64_t>::min();
        },
        message);
  }

  // Queue of which only the try_ calls are used, except in wait(): two atomic counters and a copy. Its semaphores make
  // a system call only to wake a thread that waits in them; the transport's threads never do.
  template <class T>
  using Ring = moodycamel::BlockingReaderWriterCircularBuffer<T>;

  template <class T>
  static bool put(Ring<T>& ring, const T& item, std::atomic<std::int64_t>& dropped) noexcept {
    if (ring.try_enqueue(item)) return true;
    dropped.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  // Touches all pages, so that the cyclic thread never causes a page fault in a ring.
  template <class T>
  static void touch(Ring<T>& ring, std::size_t capacity, T item) {
    for (std::size_t i = 0; i < capacity; ++i) ring.try_enqueue(item);
    while (ring.try_dequeue(item)) {
    }
  }

  const Clock& clock_;
  Ring<Message> out_;
  Ring<Waiting> in_;
  ArrivalShares shares_;     // of in_
  Waiting waiting_;          // latest one dequeued
  bool is_awaited_ = false;  // it was dequeued by wait(), and not received yet
  std::atomic<std::int64_t> dropped_out_{0};
  std::atomic<std::int64_t> dropped_in_{0};
  std::atomic<std::int64_t> malformed_{0};
};

}  // namespace unlatch::hil
