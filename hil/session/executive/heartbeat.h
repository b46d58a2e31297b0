// The cyclic thread's sign of life and its place in the run, for other threads: a watchdog, a display.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

namespace unlatch::hil {

enum class RunPlace : std::int32_t { kBeginning, kWaiting, kReceiving, kStepping, kPublishing, kEnding };

class Heartbeat {
 public:
  // Cyclic thread.
  void beat(RunPlace place) noexcept {
    place_.store(place, std::memory_order_relaxed);
    beats_.fetch_add(1, std::memory_order_relaxed);
  }
  void set_tick(std::int64_t tick) noexcept { tick_.store(tick, std::memory_order_relaxed); }

  // Any thread.
  [[nodiscard]] std::int64_t get_tick() const noexcept { return tick_.load(std::memory_order_relaxed); }
  // Changes as long as the cyclic thread runs.
  [[nodiscard]] const std::atomic<std::int64_t>& get_beats() const noexcept { return beats_; }
  // "in the step of tick 412".
  [[nodiscard]] std::string describe_place() const {
    static constexpr const char* kPlaces[] = {"before the first tick",   "waiting for",
                                              "receiving the inputs of", "in the step of",
                                              "publishing results of",   "at the end, after"};
    const RunPlace place = place_.load(std::memory_order_relaxed);
    const std::string text = kPlaces[static_cast<std::size_t>(place)];
    return place == RunPlace::kBeginning ? text : text + " tick " + std::to_string(get_tick());
  }

 private:
  std::atomic<std::int64_t> tick_{0}, beats_{0};
  std::atomic<RunPlace> place_{RunPlace::kBeginning};
};

}  // namespace unlatch::hil
