// The cyclic thread's account of its time. Fixed memory.
#pragma once

#include <array>
#include <cstdint>

#include "hil/histogram.h"
#include "hil/timing_summary.h"

namespace unlatch::hil {

// What the operating system counts for the calling thread. A system call.
struct ThreadCounts {
  std::int64_t page_faults = 0, faults_read = 0, preemptions = 0;
};
[[nodiscard]] ThreadCounts read_thread_counts() noexcept;

// The largest part of the tick's time names the cause; work that was interrupted is put down to the interruption.
[[nodiscard]] OverrunCause attribute(const Overrun& overrun) noexcept;

class Timing {
 public:
  Histogram step;        // the kernel's step alone
  Histogram wakeup;      // due to begun; real time
  Histogram turnaround;  // a command's arrival to the State of the step that it went into
  Histogram round_trip;  // State handed to the bridge to the last answer delivered by it

  // What the operating system counts is counted from here: the first tick, and later once a second, so that what befell
  // the thread long ago explains no overrun.
  void keep_counts() noexcept { counts_ = read_thread_counts(); }
  // A tick that ended `late_ns` after the next was due: completes its account, keeps it, counts it. Asks the operating
  // system what it knows.
  Overrun account_overrun(const TickTiming& tick, std::int64_t late_ns) noexcept;

  [[nodiscard]] std::int64_t get_overruns() const noexcept { return overruns_; }
  // Counts that others keep (slips, skips, late commands, drops, rejects) are left 0. Allocates.
  [[nodiscard]] TimingSummary summarize() const;

 private:
  void keep_if_among_the_worst(const Overrun& overrun) noexcept;

  ThreadCounts counts_;
  std::int64_t overruns_ = 0;
  std::array<std::int64_t, kOverrunCauses> causes_{};
  std::array<Overrun, TimingSummary::kWorst> worst_{};  // the worst first
  std::size_t worst_count_ = 0;
};

}  // namespace unlatch::hil
