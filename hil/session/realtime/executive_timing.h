// Account of the cyclic thread's time. Fixed memory.
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "hil/session/realtime/histogram.h"
#include "hil/session/realtime/timing_summary.h"

namespace unlatch::hil {

// Counts of the operating system for a thread. They never decrease.
struct ThreadCounts {
  std::int64_t page_faults = 0, faults_read = 0, preemptions = 0;
};
// Counts of the calling thread: one system call.
[[nodiscard]] ThreadCounts read_thread_counts() noexcept;
// Counts of another thread of this process, from /proc: for threads that may wait.
[[nodiscard]] std::optional<ThreadCounts> read_thread_counts(pid_t thread);

// Cause of an overrun: the largest part of the tick's time; work that was interrupted is put down to the interruption.
[[nodiscard]] OverrunCause attribute(const Overrun& overrun) noexcept;

class Timing {
 public:
  Histogram step;        // the kernel's step alone
  Histogram wakeup;      // due to begun; real time
  Histogram turnaround;  // a command's arrival to the State of the step that it went into
  Histogram round_trip;  // State handed to the bridge to the last answer delivered by it

  std::int64_t slipped_ns = 0;       // delay of the ticks by the policy `slip`
  std::int64_t skipped_outputs = 0;  // States left out by the policy `skip_output`

  // Cyclic thread, before the first tick.
  void begin_counts() noexcept;
  // One other thread, whose time does not matter, about once a second: page faults and preemptions of the cyclic thread
  // before the previous call explain no later overrun.
  void watch_counts();
  // Counts of the cyclic thread that explain no later overrun.
  void disregard(const ThreadCounts& until) noexcept;
  // Completes, keeps and counts the account of a tick that ended `late_ns` after the next was due. Asks the operating
  // system for the thread's counts.
  Overrun account_overrun(const TickTiming& tick, std::int64_t late_ns) noexcept;

  [[nodiscard]] std::int64_t get_overruns() const noexcept { return overruns_; }
  // Counts that others keep (late commands, drops, rejects, resent States) are left 0. Allocates.
  [[nodiscard]] TimingSummary summarize() const;

 private:
  void keep_if_among_the_worst(const Overrun& overrun) noexcept;

  std::atomic<pid_t> thread_{0};  // the cyclic thread; 0 before begin_counts()
  ThreadCounts counted_;          // at the last overrun
  ThreadCounts watched_;          // watching thread: at the previous call
  std::atomic<std::int64_t> old_page_faults_{0}, old_faults_read_{0}, old_preemptions_{0};
  std::int64_t overruns_ = 0;
  std::array<std::int64_t, kOverrunCauses> causes_{};
  std::array<Overrun, TimingSummary::kWorst> worst_{};  // the worst first
  std::size_t worst_count_ = 0;
};

}  // namespace unlatch::hil
