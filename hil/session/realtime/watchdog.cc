#include "hil/session/realtime/watchdog.h"

#include <algorithm>

#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/real_time.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kLooks = 8;                     // looks within a limit
constexpr std::int64_t kLongestSleep_ns = 50'000'000;  // longest delay of a run's end

}  // namespace

Watchdog::Watchdog(const std::atomic<std::int64_t>& beats, std::int64_t limit_ns, int priority,
                   std::function<void(std::int64_t)> report)
    : beats_(beats), limit_ns_(limit_ns), report_(std::move(report)) {
  thread_ = std::jthread([this, priority](const std::stop_token& stopping) {
    if (priority > 0) (void)request_priority(priority);  // the cyclic thread's own request says why it is refused
    watch(stopping);
  });
}

void Watchdog::watch(const std::stop_token& stopping) {
  std::int64_t last_beat = beats_.load(std::memory_order_relaxed), since_ns = get_monotonic_ns();
  bool reported = false;
  while (!stopping.stop_requested()) {
    sleep_until_ns(get_monotonic_ns() + std::clamp(limit_ns_ / kLooks, std::int64_t{1'000'000}, kLongestSleep_ns));
    const std::int64_t beat = beats_.load(std::memory_order_relaxed), now_ns = get_monotonic_ns();
    if (beat != last_beat) {
      last_beat = beat;
      since_ns = now_ns;
      reported = false;
    } else if (!reported && now_ns - since_ns >= limit_ns_) {
      reported = true;
      report_(now_ns - since_ns);
    }
  }
}

}  // namespace unlatch::hil
