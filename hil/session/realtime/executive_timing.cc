#include "hil/session/realtime/executive_timing.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace unlatch::hil {

ThreadCounts read_thread_counts() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_minflt + usage.ru_majflt, usage.ru_majflt, usage.ru_nivcsw};
}

std::optional<ThreadCounts> read_thread_counts(pid_t thread) {
  const std::string folder = "/proc/self/task/" + std::to_string(thread) + "/";
  ThreadCounts counts;
  std::string field;
  std::ifstream stat(folder + "stat");
  stat.ignore(std::numeric_limits<std::streamsize>::max(), ')');  // the thread's name may have spaces
  for (int i = 0; i < 7; ++i) stat >> field;
  stat >> counts.page_faults >> field >> counts.faults_read;
  counts.page_faults += counts.faults_read;
  std::ifstream status(folder + "status");
  while (status >> field && field != "nonvoluntary_ctxt_switches:") {
  }
  status >> counts.preemptions;
  if (!stat || !status) return std::nullopt;
  return counts;
}

namespace {

OverrunCause attribute_late_wakeup(HeldUpBy held_up_by) noexcept {
  switch (held_up_by) {
    case HeldUpBy::kNothing:
      return OverrunCause::kLateWakeup;
    case HeldUpBy::kTickBefore:
      return OverrunCause::kBacklog;
    case HeldUpBy::kWarmUp:
      return OverrunCause::kWarmUp;
  }
  return OverrunCause::kLateWakeup;
}

}  // namespace

OverrunCause attribute(const Overrun& overrun) noexcept {
  const TickTiming& t = overrun.timing;
  const std::int64_t most = std::max({t.wakeup_ns, t.input_ns, t.step_ns, t.output_ns});
  if (most == t.wakeup_ns) return attribute_late_wakeup(t.held_up_by);
  if (overrun.faults_read > 0) return OverrunCause::kPageFaults;
  if (overrun.preemptions > 0) return OverrunCause::kPreempted;
  if (most == t.step_ns) return t.substeps > 1 ? OverrunCause::kEvents : OverrunCause::kStep;
  return most == t.input_ns ? OverrunCause::kInputs : OverrunCause::kOutputs;
}

void Timing::begin_counts() noexcept {
  thread_.store(gettid(), std::memory_order_relaxed);
  counted_ = read_thread_counts();
}

void Timing::watch_counts() {
  const std::optional<ThreadCounts> now = read_thread_counts(thread_.load(std::memory_order_relaxed));
  if (!now) return;     // the thread does not run yet, or no more
  disregard(watched_);  // not the latest: an overrun may be on its way
  watched_ = *now;
}

void Timing::disregard(const ThreadCounts& until) noexcept {
  old_page_faults_.store(until.page_faults, std::memory_order_relaxed);
  old_faults_read_.store(until.faults_read, std::memory_order_relaxed);
  old_preemptions_.store(until.preemptions, std::memory_order_relaxed);
}

Overrun Timing::account_overrun(const TickTiming& tick, std::int64_t late_ns) noexcept {
  const ThreadCounts now = read_thread_counts();
  const auto count_since = [](std::int64_t count, std::int64_t last, const std::atomic<std::int64_t>& old) {
    return std::max<std::int64_t>(0, count - std::max(last, old.load(std::memory_order_relaxed)));
  };
  Overrun overrun;
  overrun.timing = tick;
  overrun.late_ns = late_ns;
  overrun.page_faults = count_since(now.page_faults, counted_.page_faults, old_page_faults_);
  overrun.faults_read = count_since(now.faults_read, counted_.faults_read, old_faults_read_);
  overrun.preemptions = count_since(now.preemptions, counted_.preemptions, old_preemptions_);
  overrun.cause = attribute(overrun);
  counted_ = now;
  ++overruns_;
  ++causes_[static_cast<std::size_t>(overrun.cause)];
  keep_if_among_the_worst(overrun);
  return overrun;
}

void Timing::keep_if_among_the_worst(const Overrun& overrun) noexcept {
  if (worst_count_ == worst_.size()) {
    if (overrun.late_ns <= worst_.back().late_ns) return;
    --worst_count_;
  }
  std::size_t place = worst_count_++;
  for (; place > 0 && worst_[place - 1].late_ns < overrun.late_ns; --place) worst_[place] = worst_[place - 1];
  worst_[place] = overrun;
}

TimingSummary Timing::summarize() const {
  TimingSummary summary;
  summary.step = step.summarize();
  summary.wakeup = wakeup.summarize();
  summary.turnaround = turnaround.summarize();
  summary.round_trip = round_trip.summarize();
  summary.overruns = overruns_;
  summary.slipped_ns = slipped_ns;
  summary.skipped_outputs = skipped_outputs;
  summary.overrun_causes = causes_;
  summary.worst_overruns.reserve(worst_.size());
  summary.worst_overruns.assign(worst_.begin(), worst_.begin() + static_cast<std::ptrdiff_t>(worst_count_));
  return summary;
}

}  // namespace unlatch::hil
