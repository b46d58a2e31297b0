// The cyclic thread's account of its time. Fixed memory.
#pragma once

#include <cstdint>

#include "hil/histogram.h"
#include "hil/log_format.h"

namespace unlatch::hil {

struct Timing {
  Histogram step;        // the kernel's step alone
  Histogram wakeup;      // deadline to awake; real time
  Histogram turnaround;  // State sent to last answer delivered
  std::int64_t overruns = 0, late_wakeups = 0, long_steps = 0;

  // A tick that was awake `latency_ns` after its deadline, ended at `end_ns`, and had until `next_deadline_ns`.
  void account(std::int64_t latency_ns, std::int64_t end_ns, std::int64_t deadline_ns,
               std::int64_t next_deadline_ns) noexcept;

  // Counts that others keep (late commands, drops, rejects) are left 0.
  [[nodiscard]] TimingSummary summarize() const noexcept;
};

[[nodiscard]] DurationSummary summarize(const Histogram& histogram) noexcept;

}  // namespace unlatch::hil
