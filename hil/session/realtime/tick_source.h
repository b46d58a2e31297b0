// Source of ticks for the cyclic thread: the monotonic clock, or a descriptor that another program or the system makes
// readable once a tick.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "hil/session/realtime/clock.h"

namespace unlatch::hil {

class TickSource {
 public:
  virtual ~TickSource() = default;
  TickSource(const TickSource&) = delete;
  TickSource& operator=(const TickSource&) = delete;

  // Restarts the time base: the next tick is due a period from `now_ns`, or with the next one from outside.
  virtual void restart(std::int64_t now_ns) noexcept = 0;
  // Sleeps until shortly before the next tick, and returns the time left until it is due, ns; 0 if there may be none.
  virtual std::int64_t doze() noexcept { return 0; }
  // Waits until the next tick is due. False if there is none any more: `stop` was set, or see get_failure().
  [[nodiscard]] virtual bool wait(const std::atomic<bool>& stop) noexcept = 0;
  // Restarts the time base for a tick that ended late, and returns the delay of the ticks, ns.
  virtual std::int64_t slip(std::int64_t now_ns) noexcept = 0;
  // Ticks that are due by `now_ns` and were not waited for yet, to the source's knowledge.
  [[nodiscard]] virtual std::int64_t calc_behind(std::int64_t now_ns) const noexcept = 0;
  [[nodiscard]] virtual const char* get_failure() const noexcept { return ""; }

  // Times of the latest tick, ns of the clock.
  [[nodiscard]] std::int64_t get_due_ns() const noexcept { return due_ns_; }
  [[nodiscard]] std::int64_t get_next_due_ns() const noexcept { return due_ns_ + period_ns_; }
  [[nodiscard]] std::int64_t get_awake_ns() const noexcept { return awake_ns_; }
  // Due to begun.
  [[nodiscard]] std::int64_t get_latency_ns() const noexcept { return latency_ns_; }
  // True if the latest tick was due before it was waited for.
  [[nodiscard]] bool is_backlogged() const noexcept { return backlogged_; }

 protected:
  explicit TickSource(std::int64_t period_ns) : period_ns_(period_ns) {}

  const std::int64_t period_ns_;
  std::int64_t due_ns_ = 0, awake_ns_ = 0, latency_ns_ = 0;
  bool backlogged_ = false;
};

// Absolute deadlines, a whole number of periods apart: nothing drifts. Sleeps until `spin_ns` before a deadline and
// looks at the clock again and again from there: no wake-up latency, at the price of that much of a CPU.
class MonotonicTicks final : public TickSource {
 public:
  MonotonicTicks(std::int64_t period_ns, std::int64_t spin_ns, const Clock& clock = kMonotonicClock)
      : TickSource(period_ns), clock_(clock), spin_ns_(spin_ns) {}

  void restart(std::int64_t now_ns) noexcept override { due_ns_ = now_ns; }
  std::int64_t doze() noexcept override;
  bool wait(const std::atomic<bool>& stop) noexcept override;
  std::int64_t slip(std::int64_t now_ns) noexcept override;
  std::int64_t calc_behind(std::int64_t now_ns) const noexcept override;

 private:
  const Clock& clock_;
  const std::int64_t spin_ns_;
  bool dozed_ = false;  // doze() was called since the latest tick
};

// Ticks from outside: a timerfd or eventfd (a read gives how many), or a pipe, socket or character device (each byte is
// one). The descriptor stays the caller's and is made non-blocking. Since the intended time of a tick is unknown,
// one that comes alone is due when it is seen, and its latency is how much later it came than a period after the one
// before; of several that are there at once the last is due when they are seen, those before it a period earlier each.
class DescriptorTicks final : public TickSource {
 public:
  // Silence for `patience_ns` is a failure.
  DescriptorTicks(int descriptor, std::int64_t period_ns, std::int64_t patience_ns);

  void restart(std::int64_t now_ns) noexcept override;
  bool wait(const std::atomic<bool>& stop) noexcept override;
  std::int64_t slip(std::int64_t now_ns) noexcept override;
  std::int64_t calc_behind(std::int64_t) const noexcept override { return pending_; }
  const char* get_failure() const noexcept override { return failure_; }

 private:
  // Ticks available; -1 after a failure.
  std::int64_t read_ticks() noexcept;
  bool wait_for_ticks(const std::atomic<bool>& stop) noexcept;

  const int descriptor_;
  const bool counts_;  // true if a read gives a count of 8 bytes
  const std::int64_t patience_ns_;
  std::int64_t pending_ = 0;  // ticks that are due and not waited for
  const char* failure_ = "";
};

}  // namespace unlatch::hil
