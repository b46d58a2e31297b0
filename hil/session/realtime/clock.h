// Wall time: integer nanoseconds, absolute deadlines, so that nothing drifts. The origin of a clock means nothing
// (CLOCK_MONOTONIC counts from boot): 0 and negative readings are instants like any other, never "none".
#pragma once

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace unlatch::hil {

// CLOCK_MONOTONIC, ns.
[[nodiscard]] inline std::int64_t get_monotonic_ns() noexcept {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

// Sleeps until CLOCK_MONOTONIC reads `deadline_ns`; returns at once when that has passed. Signals do not cut it short.
inline void sleep_until_ns(std::int64_t deadline_ns) noexcept {
  if (deadline_ns <= 0) return;  // before boot; timespec has no negative nanoseconds
  const timespec deadline{deadline_ns / 1'000'000'000, deadline_ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

// The clock of a session; tests inject one of their own. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

  [[nodiscard]] virtual std::int64_t get_ns() const noexcept = 0;
  // Returns at once when `deadline_ns` has passed.
  virtual void sleep_until_ns(std::int64_t deadline_ns) const noexcept = 0;

 protected:
  Clock() = default;
};

class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] std::int64_t get_ns() const noexcept override { return get_monotonic_ns(); }
  void sleep_until_ns(std::int64_t deadline_ns) const noexcept override { hil::sleep_until_ns(deadline_ns); }
};

inline const MonotonicClock kMonotonicClock;

}  // namespace unlatch::hil
