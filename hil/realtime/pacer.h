// Wall time for the cyclic thread: integer nanoseconds of CLOCK_MONOTONIC, absolute deadlines, so that nothing drifts.
#pragma once

#include <cstdint>

namespace unlatch::hil {

[[nodiscard]] std::int64_t get_monotonic_ns() noexcept;

// Sleeps until the clock reads `deadline_ns`; returns at once when that has passed. Signals do not cut it short.
void sleep_until_ns(std::int64_t deadline_ns) noexcept;

}  // namespace unlatch::hil
