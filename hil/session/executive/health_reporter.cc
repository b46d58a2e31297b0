#include "hil/session/executive/health_reporter.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kHealthInterval_ns = 1'000'000'000, kReactionsInterval_ns = 100'000'000;

bool is_due(std::int64_t now_ns, std::optional<std::int64_t> latest_ns, std::int64_t interval_ns) {
  return !latest_ns || now_ns - *latest_ns >= interval_ns;
}

}  // namespace

void HealthReporter::publish_due(std::int64_t now_ns) noexcept {
  if (is_due(now_ns, health_ns_, kHealthInterval_ns)) publish_health(now_ns);
  if (is_due(now_ns, reactions_ns_, kReactionsInterval_ns)) publish_reactions(now_ns);
}

void HealthReporter::publish_health(std::int64_t now_ns) noexcept {
  const Timing& timing = sources_.timing;
  HealthMessage health;
  health.wall_ns = now_ns - started_ns_.value_or(now_ns);
  health.step_p50_ns = timing.step.calc_percentile(0.5);
  health.step_max_ns = timing.step.get_max();
  health.wakeup_p50_ns = timing.wakeup.calc_percentile(0.5);
  health.wakeup_max_ns = timing.wakeup.get_max();
  health.overruns = timing.get_overruns();
  health.dropped = calc_dropped();
  health.late = sources_.commands.get_late();
  health.missing = sources_.participants.count_missing();
  health.rejected = sources_.rejects.by_reason;
  publisher_.publish_health(health);
  health_ns_ = now_ns;
}

void HealthReporter::publish_reactions(std::int64_t now_ns) noexcept {
  publisher_.publish_reactions();
  reactions_ns_ = now_ns;
}

std::int64_t HealthReporter::calc_dropped() const noexcept {
  return sources_.connection.get_dropped_out() + sources_.connection.get_dropped_in();
}

TimingSummary HealthReporter::summarize(std::int64_t tick) const {
  TimingSummary summary = sources_.timing.summarize();
  summary.late_commands = sources_.commands.get_late();
  summary.late_answers = sources_.liveness.get_late_answers();
  summary.unanswered = sources_.liveness.get_unanswered();
  summary.unused_commands = sources_.commands.count_after(tick);
  summary.rejected = sources_.rejects.by_reason;
  summary.dropped = calc_dropped();
  summary.resent = publisher_.get_resent();
  return summary;
}

}  // namespace unlatch::hil
