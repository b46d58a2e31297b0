// Wall time for the cyclic thread: integer nanoseconds of CLOCK_MONOTONIC, absolute deadlines, so that nothing drifts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace unlatch::hil {

[[nodiscard]] std::int64_t get_monotonic_ns() noexcept;

// Sleeps until the clock reads `deadline_ns`; returns at once when that has passed. Signals do not cut it short.
void sleep_until_ns(std::int64_t deadline_ns) noexcept;

// Locks the process's memory and gives the calling thread SCHED_FIFO. What is not permitted is said in the result, one
// sentence each with its remedy, and left as it was; empty when all was granted.
[[nodiscard]] std::vector<std::string> request_real_time();

}  // namespace unlatch::hil
