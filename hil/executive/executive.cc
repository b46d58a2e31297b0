#include "hil/executive/executive.h"

#include <unistd.h>

#include <cmath>

#include "hil/realtime/clock.h"
#include "hil/run/run.h"

namespace unlatch::hil {
namespace {

constexpr int kVerdictsPerTick = 16;
constexpr std::int64_t kHealthInterval_ns = 1'000'000'000, kReactionsInterval_ns = 100'000'000;

std::int64_t calc_cutoff_ns(const FlightSoftware& flight_software, std::int64_t dt_ns) {
  return std::llround(flight_software.cutoff * static_cast<double>(dt_ns));
}

}  // namespace

Executive::Executive(Simulation& simulation, Line& link, Recorder& recorder, const std::string& scenario,
                     const ExecutiveOptions& options)
    : simulation_(simulation),
      link_(link),
      recorder_(recorder),
      options_(options),
      clock_(*options.clock),
      dt_ns_(std::llround(simulation.plan().options.dt * 1e9)),
      timeout_ns_(std::llround(options.flight_software.timeout * 1e9)),
      catalog_(build_catalog(simulation.model())),
      source_(options.source),
      model_events_(build_event_messages(simulation.model())),
      roster_(options.pace == Pace::kFast ? std::vector<std::string>{} : options.flight_software.required),
      desk_(simulation.model().channels, {.session = options.session,
                                          .delay_ticks = options.flight_software.delay,
                                          .accept_late = options.pace == Pace::kRealtime}),
      commander_(simulation.model().channels.size(), nullptr),
      commanded_(simulation.channels().begin(), simulation.channels().end()),
      own_ticks_(std::make_unique<MonotonicTicks>(dt_ns_, std::llround(options.timing.spin * 1e9), clock_)),
      ticks_(options.ticks != nullptr ? options.ticks : own_ticks_.get()) {
  hello_.session = options.session;
  hello_.schema_hash = kSchemaHash;
  hello_.model_hash = static_cast<std::int64_t>(simulation.plan().hash);
  hello_.dt_ns = dt_ns_;
  hello_.last_tick = options.last_tick;
  hello_.protocol = kProtocolVersion;
  hello_.pace = static_cast<std::int32_t>(options.pace);
  hello_.timeout_ns = timeout_ns_;
  if (options.pace == Pace::kRealtime) hello_.cutoff_ns = calc_cutoff_ns(options.flight_software, dt_ns_);
  hello_.delay_ticks = options.flight_software.delay;
  hello_.policy = static_cast<std::int32_t>(options.flight_software.policy);
  for (const std::string& name : options.flight_software.required) {
    Catalog& item = catalog_.emplace_back();
    item.kind = static_cast<std::int32_t>(CatalogKind::kParticipant);
    item.index = hello_.participant_count++;
    set_name(item.name, name);
  }
  for (Catalog& item : catalog_) {
    item.session = options.session;
    switch (static_cast<CatalogKind>(item.kind)) {
      case CatalogKind::kBody:
        ++hello_.body_count;
        break;
      case CatalogKind::kJoint:
        ++hello_.joint_count;
        break;
      case CatalogKind::kChannel:
        ++hello_.channel_count;
        break;
      case CatalogKind::kSensor:
        ++hello_.sensor_count;
        break;
      case CatalogKind::kSignal:
        ++hello_.signal_count;
        break;
      case CatalogKind::kParticipant:
        break;  // counted above
    }
  }
  set_name(hello_.scenario, scenario);
}

LogEnd Executive::run() {
  std::string failure;
  thread_.store(gettid(), std::memory_order_relaxed);
  hash_ = simulation_.calc_hash();
  if (!introduce(failure) || !configure(failure)) return conclude(RunStatus::kAborted, failure);
  timing_.begin_counts();
  ticks_->restart(*started_ns_);

  while (simulation_.get_tick() < options_.last_tick) {
    if (await_tick() == Go::kStop || cycle() == Go::kStop) return conclude_stop();
  }
  return conclude(RunStatus::kDone, "");
}

// The only place where the cyclic thread waits.
Executive::Go Executive::await_tick() noexcept {
  beat(Place::kWaiting);
  now_ = {.tick = simulation_.get_tick()};
  if (stop_.load(std::memory_order_relaxed)) return end_message_ = "interrupted", Go::kStop;
  if (options_.pace == Pace::kLockstep) return wait_lockstep();
  if (options_.pace == Pace::kFast) return Go::kStep;
  rehearse(ticks_->doze());
  if (!ticks_->wait(stop_)) {
    const std::string failure = ticks_->get_failure();
    end_message_ = failure.empty() ? "interrupted" : "the tick source has failed: " + failure;
    return Go::kStop;
  }
  now_.wakeup_ns = ticks_->get_latency_ns();
  now_.held_up = ticks_->is_backlogged() ? 1 : rehearsed_ns_ && *rehearsed_ns_ > ticks_->get_due_ns() ? 2 : 0;
  timing_.wakeup.record(now_.wakeup_ns);
  beat(Place::kHearing);
  // The State went out a period before the instant for which we have just been woken.
  cutoff_ns_ = ticks_->get_due_ns() - dt_ns_ + hello_.cutoff_ns;
  return wait_realtime();
}

// A step for nothing: between two ticks others have had the caches, and the step that counts finds in them what it
// needs. Only if the last one, and half as much again, would have fitted into what is left.
void Executive::rehearse(std::int64_t left_ns) noexcept {
  if (left_ns <= rehearsal_ns_ + rehearsal_ns_ / 2) {
    rehearsal_ns_ /= 2;  // it may have been longer than usual
    return;
  }
  const std::int64_t begin_ns = clock_.get_ns();
  simulation_.rehearse();
  rehearsed_ns_ = clock_.get_ns();
  rehearsal_ns_ = *rehearsed_ns_ - begin_ns;
}

Executive::Go Executive::cycle() noexcept {
  // 1. The tick's inputs are decided.
  apply_commands();
  recorder_.tick(simulation_.get_tick(), hash_);

  // 2. Step.
  beat(Place::kStepping);
  const std::int64_t begin_ns = clock_.get_ns();
  const StepReport report = simulation_.step();
  const std::int64_t end_ns = clock_.get_ns();
  if (options_.pace == Pace::kRealtime) now_.input_ns = begin_ns - ticks_->get_awake_ns();
  now_.step_ns = end_ns - begin_ns;
  now_.substeps = report.substeps;
  timing_.step.record(now_.step_ns);
  last_report_ = report;
  if (report.status != StepStatus::kOk) return Go::kStop;

  // 3. Say what has become of it.
  beat(Place::kSpeaking);
  hash_ = simulation_.calc_hash();
  tick_.store(simulation_.get_tick(), std::memory_order_relaxed);
  if (options_.faults != nullptr) begin_faults();
  speak(report);

  // 4. Account for the time.
  return account(end_ns);
}

void Executive::speak(const StepReport& report) noexcept {
  const MayWait without_deadlines(options_.pace != Pace::kRealtime);
  for (const FiredEvent& fired : report.events) {
    publish_event(model_events_[static_cast<std::size_t>(fired.event)], fired.time, false);
  }
  const bool is_last = simulation_.get_tick() == options_.last_tick;
  if (!is_last && !simulation_.is_state_due()) return;
  if (!is_last && options_.pace == Pace::kRealtime &&
      options_.timing.overruns.kind == OverrunPolicy::Kind::kSkipOutput &&
      clock_.get_ns() > ticks_->get_next_due_ns()) {
    ++skipped_outputs_;
    return;
  }
  publish_state(is_last ? RunStatus::kDone : RunStatus::kRunning);
  if (applied_since_ns_) timing_.turnaround.record(sent_ns_ - *applied_since_ns_);
  applied_since_ns_.reset();
}

Executive::Go Executive::account(std::int64_t step_end_ns) noexcept {
  const MayWait without_deadlines(options_.pace != Pace::kRealtime);
  const std::int64_t now_ns = clock_.get_ns();
  now_.output_ns = now_ns - step_end_ns;
  if (options_.timing.per_tick) recorder_.timing(now_);
  if (now_ns - *health_ns_ >= kHealthInterval_ns) publish_health(now_ns);
  if (!reactions_ns_ || now_ns - *reactions_ns_ >= kReactionsInterval_ns) publish_reactions(now_ns);
  announce(now_ns);
  verdicts_left_ = kVerdictsPerTick;
  if (options_.pace != Pace::kRealtime) return Go::kStep;
  if (now_ns > ticks_->get_next_due_ns()) return account_overrun(now_ns);
  return Go::kStep;
}

Executive::Go Executive::account_overrun(std::int64_t now_ns) noexcept {
  publish_overrun(timing_.account_overrun(now_, now_ns - ticks_->get_next_due_ns()));
  const OverrunPolicy& policy = options_.timing.overruns;
  if (policy.kind == OverrunPolicy::Kind::kSlip) slipped_ns_ += ticks_->slip(now_ns);
  overrun_ends_ = policy.kind == OverrunPolicy::Kind::kFail ||
                  (policy.kind == OverrunPolicy::Kind::kCatchUp && ticks_->calc_behind(now_ns) > policy.max_ticks);
  return overrun_ends_ ? Go::kStop : Go::kStep;
}

void Executive::watch_counts() {
  const std::optional<ThreadCounts> now = read_thread_counts(thread_.load(std::memory_order_relaxed));
  if (!now) return;             // it does not run yet, or no more
  timing_.disregard(watched_);  // not the latest: an overrun may be on its way
  watched_ = *now;
}

// Why the loop was left before its last tick, for people.
LogEnd Executive::conclude_stop() {
  if (last_report_.status != StepStatus::kOk) {
    LogEnd end = conclude(RunStatus::kFaulted, "");
    end.step_status = static_cast<std::int32_t>(last_report_.status);
    end.joint = last_report_.joint;
    end.message = describe_fault(end, simulation_.model(), simulation_.plan().options.dt);
    return end;
  }
  if (overrun_ends_) {
    const bool fail = options_.timing.overruns.kind == OverrunPolicy::Kind::kFail;
    end_message_ =
        "tick " + std::to_string(now_.tick) + " overran its period (policy: " +
        (fail ? "fail" : "catch_up, at most " + std::to_string(options_.timing.overruns.max_ticks) + " ticks") +
        "); the table of overruns says why";
  }
  return conclude(RunStatus::kAborted, end_message_);
}

std::string Executive::describe_place() const {
  static constexpr const char* kPlaces[] = {"before the first tick", "waiting for", "hearing the inputs of",
                                            "in the step of",        "speaking of", "at the end, after"};
  const Place place = place_.load(std::memory_order_relaxed);
  const std::string text = kPlaces[static_cast<std::size_t>(place)];
  return place == Place::kBeginning ? text : text + " tick " + std::to_string(get_tick());
}

}  // namespace unlatch::hil
