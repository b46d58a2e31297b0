#include "hil/executive_timing.h"

namespace unlatch::hil {

void Timing::account(std::int64_t latency_ns, std::int64_t end_ns, std::int64_t deadline_ns,
                     std::int64_t next_deadline_ns) noexcept {
  wakeup.record(latency_ns);
  if (end_ns <= next_deadline_ns) return;
  ++overruns;
  // The larger share of the time names the cause.
  const std::int64_t worked_ns = end_ns - deadline_ns - latency_ns;
  ++(latency_ns > worked_ns ? late_wakeups : long_steps);
}

DurationSummary summarize(const Histogram& histogram) noexcept {
  return {histogram.get_count(), histogram.calc_percentile(0.5), histogram.calc_percentile(0.99),
          histogram.calc_percentile(0.999), histogram.get_max()};
}

TimingSummary Timing::summarize() const noexcept {
  TimingSummary summary;
  summary.step = hil::summarize(step);
  summary.wakeup = hil::summarize(wakeup);
  summary.turnaround = hil::summarize(turnaround);
  summary.overruns = overruns;
  summary.late_wakeups = late_wakeups;
  summary.long_steps = long_steps;
  return summary;
}

}  // namespace unlatch::hil
