// Report of a cyclic thread that shows no sign of life, by a thread of higher priority that compares a counter now and
// then.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

namespace unlatch::hil {

class Watchdog {
 public:
  // `report` is called once for every silence of `limit_ns` or more, with its length so far. `priority` of SCHED_FIFO
  // if it is granted, 0 for none: without it a busy machine may silence the watchdog as well.
  Watchdog(const std::atomic<std::int64_t>& beats, std::int64_t limit_ns, int priority,
           std::function<void(std::int64_t silent_ns)> report);

 private:
  void watch(const std::stop_token& stopping);

  const std::atomic<std::int64_t>& beats_;
  const std::int64_t limit_ns_;
  const std::function<void(std::int64_t)> report_;
  std::jthread thread_;
};

}  // namespace unlatch::hil
