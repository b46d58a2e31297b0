// A warm-up step before each tick: a step that is thrown away. Between two ticks other threads have used the caches;
// the step that counts then finds its code and data in them.
#pragma once

#include <cstdint>
#include <optional>

#include "hil/run/simulation/simulation.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/nonblocking.h"

namespace unlatch::hil {

class WarmUp {
 public:
  // Makes a warm-up step if `left_ns`, the time until the tick, is more than one and a half times the duration of the
  // latest.
  void run(Simulation& simulation, const Clock& clock, std::int64_t left_ns) noexcept UNLATCH_NONBLOCKING {
    if (left_ns <= duration_ns_ + duration_ns_ / 2) {
      duration_ns_ /= 2;  // the latest may have been longer than usual
      return;
    }
    const std::int64_t begin_ns = clock.get_ns();
    simulation.warm_up();
    ended_ns_ = clock.get_ns();
    duration_ns_ = *ended_ns_ - begin_ns;
  }

  // The latest warm-up step, if there was one, ended after `due_ns`.
  [[nodiscard]] bool has_ended_after(std::int64_t due_ns) const noexcept { return ended_ns_ && *ended_ns_ > due_ns; }

 private:
  std::int64_t duration_ns_ = 0;          // duration of the latest
  std::optional<std::int64_t> ended_ns_;  // end of the latest
};

}  // namespace unlatch::hil
