// The cyclic thread's account of its time. Fixed memory.
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "hil/realtime/histogram.h"
#include "hil/realtime/timing_summary.h"

namespace unlatch::hil {

// Counts of the operating system for a thread. They never decrease.
struct ThreadCounts {
  std::int64_t page_faults = 0, faults_read = 0, preemptions = 0;
};
// Of the calling thread: one system call.
[[nodiscard]] ThreadCounts read_thread_counts() noexcept;
// Of another thread of this process: from /proc, hence for threads that may wait.
[[nodiscard]] std::optional<ThreadCounts> read_thread_counts(pid_t thread);

// The largest part of the tick's time names the cause; work that was interrupted is put down to the interruption.
[[nodiscard]] OverrunCause attribute(const Overrun& overrun) noexcept;

class Timing {
 public:
  Histogram step;        // the kernel's step alone
  Histogram wakeup;      // due to begun; real time
  Histogram turnaround;  // a command's arrival to the State of the step that it went into
  Histogram round_trip;  // State handed to the bridge to the last answer delivered by it

  std::int64_t slipped_ns = 0;       // by which the policy `slip` has put off the ticks
  std::int64_t skipped_outputs = 0;  // States that the policy `skip_output` has left out

  // The cyclic thread, before the first tick.
  void begin_counts() noexcept;
  // One other thread, whose time does not matter, about once a second: page faults and preemptions of the cyclic thread
  // before the previous call explain no later overrun.
  void watch_counts();
  // The same, with counts of the cyclic thread from another source.
  void disregard(const ThreadCounts& until) noexcept;
  // A tick that ended `late_ns` after the next was due: completes its account, keeps it, counts it. Asks the operating
  // system what it knows.
  Overrun account_overrun(const TickTiming& tick, std::int64_t late_ns) noexcept;

  [[nodiscard]] std::int64_t get_overruns() const noexcept { return overruns_; }
  // Counts that others keep (late commands, drops, rejects, resent States) are left 0. Allocates.
  [[nodiscard]] TimingSummary summarize() const;

 private:
  void keep_if_among_the_worst(const Overrun& overrun) noexcept;

  std::atomic<pid_t> thread_{0};  // the cyclic thread; 0 before begin_counts()
  ThreadCounts counted_;          // by the last overrun
  ThreadCounts watched_;          // watching thread: of the previous call
  std::atomic<std::int64_t> old_page_faults_{0}, old_faults_read_{0}, old_preemptions_{0};
  std::int64_t overruns_ = 0;
  std::array<std::int64_t, kOverrunCauses> causes_{};
  std::array<Overrun, TimingSummary::kWorst> worst_{};  // the worst first
  std::size_t worst_count_ = 0;
};

}  // namespace unlatch::hil
