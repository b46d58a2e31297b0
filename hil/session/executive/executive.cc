#include "hil/session/executive/executive.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "hil/run/run.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/number_text.h"
#include "hil/session/messages/event_names.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kPausePoll_ns = 5'000'000;      // sleep between two calls of receive()
constexpr std::chrono::milliseconds kLockstepWait(5);  // longest sleep between two looks at the clock
constexpr int kFinalStates = 3;                        // the last State, repeated for transports that lose messages
constexpr std::int64_t kFinalInterval_ns = 5'000'000;

}  // namespace

// Calls take() for the sensor values that flight software has and that are not those sampled; only faults make them.
template <class Take>
void Executive::list_received(Take&& take) const noexcept {
  if (options_.faults == nullptr) return;
  const std::span<const double> received = options_.faults->get_received(), sampled = simulation_.get_sensors();
  for (std::size_t i = 0; i < std::min(received.size(), sampled.size()); ++i)
    if (!std::isnan(received[i]) && received[i] != sampled[i])
      take(LogReceived{static_cast<std::int32_t>(i), received[i]});
}

Executive::Executive(Simulation& simulation, Connection& connection, Recorder& recorder, const std::string& scenario,
                     const ExecutiveOptions& options)
    : options_(options),
      clock_(*options.clock),
      simulation_(simulation),
      recorder_(recorder),
      session_(simulation, connection, recorder, scenario, options, heartbeat_, timing_.round_trip),
      channels_(simulation, recorder, options.faults),
      health_({.timing = timing_,
               .participants = session_.participants(),
               .commands = session_.commands(),
               .rejects = session_.rejects(),
               .connection = session_.connection(),
               .liveness = session_.liveness()},
              session_.publisher()),
      own_ticks_(std::make_unique<MonotonicTicks>(session_.announcer().get_hello().dt_ns,
                                                  std::llround(options.timing.spin * 1e9), clock_)),
      ticks_(options.ticks != nullptr ? *options.ticks : *own_ticks_) {}

LogEnd Executive::run() {
  hash_ = simulation_.calc_hash();
  if (auto failure = begin()) return conclude(RunStatus::kAborted, std::move(*failure));

  while (simulation_.get_tick() < options_.last_tick) {
    if (await_tick() == Next::kStop || cycle() == Next::kStop) return conclude_stop();
  }
  return conclude(RunStatus::kDone, "");
}

// --- The cycle ------------------------------------------------------------------------------------------------------

// The only place where the cyclic thread waits between two ticks.
Executive::Next Executive::await_tick() noexcept {
  heartbeat_.beat(RunPlace::kWaiting);
  now_ = {.tick = simulation_.get_tick()};
  if (stop_.load(std::memory_order_relaxed)) return stop("interrupted");
  if (options_.pace == Pace::kLockstep) return wait_lockstep();
  if (options_.pace == Pace::kFast) return Next::kStep;
  warm_up_.run(simulation_, clock_, ticks_.doze());
  if (!ticks_.wait(stop_)) {
    const std::string failure = ticks_.get_failure();
    return stop(failure.empty() ? "interrupted" : "the tick source has failed: " + failure);
  }
  now_.wakeup_ns = ticks_.get_latency_ns();
  if (warm_up_.has_ended_after(ticks_.get_due_ns())) now_.held_up_by = HeldUpBy::kWarmUp;
  if (ticks_.is_backlogged()) now_.held_up_by = HeldUpBy::kTickBefore;
  timing_.wakeup.record(now_.wakeup_ns);
  // The State was sent a period before this tick was due.
  const HelloMessage& hello = session_.announcer().get_hello();
  session_.set_cutoff(ticks_.get_due_ns() - hello.dt_ns + hello.cutoff_ns);
  return wait_realtime();
}

// No step waits for a participant.
Executive::Next Executive::wait_realtime() noexcept {
  session_.receive();
  const std::int64_t now_ns = clock_.get_ns();
  (void)session_.exchange().is_answered(now_ns);  // for its round trip alone
  Participant* const overdue = session_.liveness().find_overdue(now_ns);
  return overdue != nullptr ? lose(*overdue) : Next::kStep;
}

Executive::Next Executive::wait_lockstep() noexcept {
  if (session_.liveness().get_tick() != simulation_.get_tick()) return Next::kStep;  // no State, no answers
  std::int64_t sent_ns = *session_.liveness().get_sent_ns();
  while (true) {
    session_.receive();
    const std::int64_t now_ns = clock_.get_ns();
    if (session_.exchange().is_answered(now_ns)) return Next::kStep;
    if (stop_.load(std::memory_order_relaxed)) return stop("interrupted");
    if (Participant* const overdue = session_.liveness().find_overdue(now_ns)) {
      if (lose(*overdue) == Next::kStop) return Next::kStop;
      continue;
    }
    if (now_ns - session_.exchange().get_quiet_since_ns(sent_ns) >= options_.resend_ns) {
      session_.exchange().repeat(simulation_.get_tick() == 0 ? RunStatus::kArmed : RunStatus::kRunning);
      sent_ns = now_ns;
    }
    session_.announcer().announce(now_ns);
    session_.connection().wait(kLockstepWait);
  }
}

// A required participant has not answered in time, or leaves: the policy is applied.
Executive::Next Executive::lose(Participant& participant) noexcept {
  const Policy policy = session_.liveness().get_policy();
  char name[kNameLength] = {};
  const std::string_view policy_name = get_text(policy);
  kPolicyPrefix.copy(name, kPolicyPrefix.size());
  policy_name.copy(name + kPolicyPrefix.size(), sizeof name - kPolicyPrefix.size() - 1);
  session_.publisher().publish_notice(name, participant.name);
  const bool left = session_.liveness().lose(participant);
  if (policy == Policy::kPause) return pause(participant);
  if (policy == Policy::kAbort) {
    return stop("the flight software '" + participant.name + "' " + (left ? "has left" : "did not answer in time") +
                " (policy: abort)");
  }
  session_.commands().remove(participant);
  channels_.apply_policy(policy, session_.participants().get_index(participant));
  return Next::kStep;
}

// Waits, without stepping, until the participant, or a new start of it, is back.
Executive::Next Executive::pause(Participant& participant) noexcept {
  const double limit_s = options_.flight_software.pause_limit;
  const std::int64_t give_up_ns = clock_.get_ns() + std::llround(limit_s * 1e9);
  std::optional<std::int64_t> resend_at_ns;  // none: at once
  while (!participant.has_answered(simulation_.get_tick())) {
    if (stop_.load(std::memory_order_relaxed)) return stop("interrupted");
    const std::int64_t now_ns = clock_.get_ns();
    if (now_ns >= give_up_ns) {
      return stop("the flight software '" + participant.name + "' did not come back within the pause_limit of " +
                  write_number(limit_s) + " s");
    }
    if (!resend_at_ns || now_ns >= *resend_at_ns) {
      session_.exchange().repeat(RunStatus::kPaused);
      resend_at_ns = now_ns + std::max(options_.resend_ns, kPausePoll_ns);
    }
    session_.announcer().announce(now_ns);
    clock_.sleep_until_ns(now_ns + kPausePoll_ns);
    session_.receive();
  }
  const std::int64_t now_ns = clock_.get_ns();
  ticks_.restart(now_ns);  // the pause is no overrun
  session_.liveness().restart(now_ns);
  return Next::kStep;
}

Executive::Next Executive::cycle() noexcept {
  // 1. Apply the commands of this tick.
  apply_commands();
  list_received([this](const LogReceived& one) noexcept { recorder_.received(one); });
  recorder_.tick(simulation_.get_tick(), hash_);

  // 2. Step.
  heartbeat_.beat(RunPlace::kStepping);
  const std::int64_t begin_ns = clock_.get_ns();
  const StepReport report = simulation_.step();
  const std::int64_t end_ns = clock_.get_ns();
  if (is_realtime()) now_.input_ns = begin_ns - ticks_.get_awake_ns();
  now_.step_ns = end_ns - begin_ns;
  now_.substeps = report.substeps;
  timing_.step.record(now_.step_ns);
  last_report_ = report;
  if (report.status != StepStatus::kOk) return Next::kStop;

  // 3. Publish the result.
  heartbeat_.beat(RunPlace::kPublishing);
  hash_ = simulation_.calc_hash();
  heartbeat_.set_tick(simulation_.get_tick());
  begin_faults();
  publish(report);

  // 4. Account for the time.
  return account(end_ns);
}

void Executive::apply_commands() noexcept {
  const MayWait without_deadlines(!is_realtime());
  session_.publisher().publish_fault_notices();
  session_.commands().take_due(simulation_.get_tick(), [this](const CommandQueue::Pending& pending) {
    const CommandMessage& command = pending.command;
    applied_ns_ = session_.get_command_ns();
    channels_.set({.channel = command.channel,
                   .cause = pending.late ? ChangeCause::kLateCommand : ChangeCause::kCommand,
                   .participant = session_.participants().get_index(*pending.sender),
                   .sequence = command.sequence,
                   .value = command.value});
  });
}

// Before the State of a tick is published.
void Executive::begin_faults() noexcept {
  if (options_.faults == nullptr) return;
  const MayWait without_deadlines(!is_realtime());
  const auto end_freeze = [this](Participant& participant) {
    session_.publisher().publish_fault_notices();
    session_.resume(participant);
  };
  options_.faults->begin_tick(simulation_.get_tick(), clock_.get_ns(), session_.participants(), end_freeze);
  session_.publisher().publish_fault_notices();
  channels_.update_faults();
}

void Executive::publish(const StepReport& report) noexcept {
  const MayWait without_deadlines(!is_realtime());
  for (const FiredEvent& fired : report.events) session_.publisher().publish_event(fired);
  const bool is_last = simulation_.get_tick() == options_.last_tick;
  if (!is_last && !simulation_.is_state_due()) return;
  if (!is_last && is_realtime() && options_.timing.overruns.kind == OverrunPolicy::Kind::kSkipOutput &&
      clock_.get_ns() > ticks_.get_next_due_ns()) {
    ++timing_.skipped_outputs;
    return;
  }
  session_.exchange().publish(is_last ? RunStatus::kDone : RunStatus::kRunning, hash_);
  if (applied_ns_) timing_.turnaround.record(*session_.liveness().get_sent_ns() - *applied_ns_);
  applied_ns_.reset();
}

Executive::Next Executive::account(std::int64_t step_end_ns) noexcept {
  const MayWait without_deadlines(!is_realtime());
  const std::int64_t now_ns = clock_.get_ns();
  now_.output_ns = now_ns - step_end_ns;
  if (options_.timing.per_tick) recorder_.timing(now_);
  health_.publish_due(now_ns);
  session_.announcer().announce(now_ns);
  session_.publisher().begin_tick();
  if (is_realtime() && now_ns > ticks_.get_next_due_ns()) return account_overrun(now_ns);
  return Next::kStep;
}

Executive::Next Executive::account_overrun(std::int64_t now_ns) noexcept {
  session_.publisher().publish_overrun(timing_.account_overrun(now_, now_ns - ticks_.get_next_due_ns()));
  const OverrunPolicy& policy = options_.timing.overruns;
  if (policy.kind == OverrunPolicy::Kind::kSlip) timing_.slipped_ns += ticks_.slip(now_ns);
  overrun_ends_ = policy.kind == OverrunPolicy::Kind::kFail ||
                  (policy.kind == OverrunPolicy::Kind::kCatchUp && ticks_.calc_behind(now_ns) > policy.max_ticks);
  return overrun_ends_ ? Next::kStop : Next::kStep;
}

// --- The beginning and the end: nothing here is in the cycle --------------------------------------------------------

std::optional<std::string> Executive::begin() {
  if (options_.pace == Pace::kFast) {
    session_.announcer().send_all();
    begin_faults();
  } else {
    const SessionStart start(session_, options_, stop_, [this] { begin_faults(); });
    if (auto failure = start.run(hash_)) return failure;
    session_.commands().expect_repeats(0);
    session_.exchange().resend(RunStatus::kArmed);
    session_.publisher().set_resent(0);
  }
  session_.announcer().set_status(RunStatus::kRunning);
  session_.handshake().begin_run();
  const std::int64_t started_ns = clock_.get_ns();
  health_.begin_run(started_ns);
  if (options_.pace == Pace::kFast) {
    session_.exchange().publish(options_.last_tick == 0 ? RunStatus::kDone : RunStatus::kRunning, hash_);
  }
  timing_.begin_counts();
  ticks_.restart(started_ns);
  return std::nullopt;
}

Executive::Next Executive::stop(std::string message) noexcept {
  end_message_ = std::move(message);
  return Next::kStop;
}

// The loop was left before its last tick.
LogEnd Executive::conclude_stop() {
  if (last_report_.status != StepStatus::kOk) {
    LogEnd end = conclude(RunStatus::kFaulted, "");
    end.step_status = static_cast<std::int32_t>(last_report_.status);
    end.joint = last_report_.joint;
    end.message = describe_fault(last_report_, end.tick, simulation_.model(), simulation_.plan().get_options().dt);
    return end;
  }
  if (overrun_ends_) {
    const bool fail = options_.timing.overruns.kind == OverrunPolicy::Kind::kFail;
    end_message_ = "tick " + std::to_string(now_.tick) + " overran its period (policy: " +
                   (fail ? "fail" : "catch_up, at most " + count(options_.timing.overruns.max_ticks, "tick")) +
                   "); the table of overruns has the cause";
  }
  return conclude(RunStatus::kAborted, end_message_);
}

LogEnd Executive::conclude(RunStatus status, std::string message) {
  session_.publisher().publish_fault_notices();
  heartbeat_.beat(RunPlace::kEnding);
  session_.announcer().set_status(status);
  session_.announcer().send_farewell();
  while (session_.announcer().send_unsent_source_part()) heartbeat_.beat(RunPlace::kEnding);
  for (int i = 0; i < kFinalStates; ++i) {
    session_.exchange().resend(status);
    clock_.sleep_until_ns(clock_.get_ns() + kFinalInterval_ns);
  }
  session_.publisher().set_resent(session_.publisher().get_resent() - kFinalStates);
  health_.publish_health(clock_.get_ns());
  if (status != RunStatus::kFaulted) health_.publish_reactions(clock_.get_ns());

  LogEnd end;
  end.tick = simulation_.get_tick();
  end.hash = hash_;
  end.status = status;
  end.message = std::move(message);
  list_received([&end](const LogReceived& one) { end.received.push_back(one); });
  end.timing = health_.summarize(end.tick);
  return end;
}

}  // namespace unlatch::hil
