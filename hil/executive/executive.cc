#include "hil/executive/executive.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "hil/messages/event_names.h"
#include "hil/run/run.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kHealthInterval_ns = 1'000'000'000, kReactionsInterval_ns = 100'000'000;
constexpr std::int64_t kPausePoll_ns = 5'000'000;      // sleep between two calls of receive()
constexpr std::chrono::milliseconds kLockstepWait(5);  // the longest sleep between two looks at the clock
constexpr int kMaxArrivals = 512;                      // of one call of receive(): bounds the work of a tick
constexpr int kFinalStates = 3;                        // the last State, repeated for transports that lose messages
constexpr std::int64_t kFinalInterval_ns = 5'000'000;

std::vector<std::string> get_required(const SessionOptions& options) {
  return options.pace == Pace::kFast ? std::vector<std::string>{} : options.flight_software.required;
}

std::int64_t calc_horizon_ticks(const FlightSoftware& flight_software, const HelloMessage& hello) {
  constexpr double kMost = 0x1p53;
  return static_cast<std::int64_t>(
      std::min(std::ceil(flight_software.horizon * 1e9 / static_cast<double>(hello.dt_ns)), kMost));
}

Announcer build_announcer(const Simulation& simulation, const std::string& scenario, const ExecutiveOptions& options,
                          Connection& connection) {
  std::vector<CatalogMessage> catalog = build_session_catalog(simulation, options);
  const HelloMessage hello = build_hello(simulation, scenario, options, catalog);
  return {hello, std::move(catalog), options.source, connection, *options.clock, options.announce_ns};
}

}  // namespace

Executive::Executive(Simulation& simulation, Connection& connection, Recorder& recorder, const std::string& scenario,
                     const ExecutiveOptions& options)
    : options_(options),
      clock_(*options.clock),
      simulation_(simulation),
      recorder_(recorder),
      participants_(get_required(options)),
      faulty_connection_(options.faults == nullptr ? nullptr
                                                   : std::make_unique<FaultyConnection>(
                                                         connection, *options.faults, participants_, clock_,
                                                         [this](Participant& participant) { resume(participant); })),
      connection_(faulty_connection_ ? *faulty_connection_ : connection),
      announcer_(build_announcer(simulation, scenario, options, connection_)),
      handshake_(announcer_.get_hello(), participants_),
      liveness_(participants_, options.flight_software.policy, announcer_.get_hello().timeout_ns),
      commands_(simulation.model().channels,
                {.session = options.session,
                 .delay_ticks = options.flight_software.delay,
                 .accept_late = options.pace == Pace::kRealtime,
                 .horizon_ticks = calc_horizon_ticks(options.flight_software, announcer_.get_hello()),
                 .places = static_cast<std::size_t>(options.flight_software.queue)},
                participants_, rejects_),
      publisher_(simulation, recorder, connection_, options.faults, options.session),
      exchange_(simulation, clock_, participants_, liveness_, commands_, publisher_, timing_.round_trip),
      commanders_(simulation.model().channels.size(), nullptr),
      own_ticks_(std::make_unique<MonotonicTicks>(announcer_.get_hello().dt_ns, std::llround(options.timing.spin * 1e9),
                                                  clock_)),
      ticks_(options.ticks != nullptr ? *options.ticks : *own_ticks_) {
  if (options.faults != nullptr) channel_faults_.emplace(*options.faults, simulation.channels());
}

LogEnd Executive::run() {
  thread_.store(gettid(), std::memory_order_relaxed);
  hash_ = simulation_.calc_hash();
  if (auto failure = begin()) return conclude(RunStatus::kAborted, std::move(*failure));
  timing_.begin_counts();
  ticks_.restart(*started_ns_);

  while (simulation_.get_tick() < options_.last_tick) {
    if (await_tick() == Next::kStop || cycle() == Next::kStop) return conclude_stop();
  }
  return conclude(RunStatus::kDone, "");
}

// --- The cycle ------------------------------------------------------------------------------------------------------

// The only place where the cyclic thread waits between two ticks.
Executive::Next Executive::await_tick() noexcept {
  beat(Place::kWaiting);
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
  now_.held_up = ticks_.is_backlogged() ? 1 : warm_up_.has_ended_after(ticks_.get_due_ns()) ? 2 : 0;
  timing_.wakeup.record(now_.wakeup_ns);
  // The State was sent a period before the instant for which this thread has just been woken.
  cutoff_ns_ = ticks_.get_due_ns() - announcer_.get_hello().dt_ns + announcer_.get_hello().cutoff_ns;
  return wait_realtime();
}

// No step waits for a participant.
Executive::Next Executive::wait_realtime() noexcept {
  receive();
  const std::int64_t now_ns = clock_.get_ns();
  (void)exchange_.is_answered(now_ns);  // for its round trip alone
  Participant* const overdue = liveness_.find_overdue(now_ns);
  return overdue != nullptr ? lose(*overdue) : Next::kStep;
}

Executive::Next Executive::wait_lockstep() noexcept {
  if (liveness_.get_tick() != simulation_.get_tick()) return Next::kStep;  // no State, no answers
  std::int64_t sent_ns = *liveness_.get_sent_ns();
  while (true) {
    receive();
    const std::int64_t now_ns = clock_.get_ns();
    if (exchange_.is_answered(now_ns)) return Next::kStep;
    if (stop_.load(std::memory_order_relaxed)) return stop("interrupted");
    if (Participant* const overdue = liveness_.find_overdue(now_ns)) {
      if (lose(*overdue) == Next::kStop) return Next::kStop;
      continue;
    }
    if (now_ns - exchange_.get_quiet_since_ns(sent_ns) >= options_.resend_ns) {
      exchange_.repeat(simulation_.get_tick() == 0 ? RunStatus::kArmed : RunStatus::kRunning);
      sent_ns = now_ns;
    }
    announcer_.announce(now_ns);
    connection_.wait(kLockstepWait);
  }
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
                  std::to_string(limit_s) + " s");
    }
    if (!resend_at_ns || now_ns >= *resend_at_ns) {
      exchange_.repeat(RunStatus::kPaused);
      resend_at_ns = now_ns + std::max(options_.resend_ns, kPausePoll_ns);
    }
    announcer_.announce(now_ns);
    clock_.sleep_until_ns(now_ns + kPausePoll_ns);
    receive();
  }
  const std::int64_t now_ns = clock_.get_ns();
  ticks_.restart(now_ns);  // the pause is no overrun
  liveness_.restart(now_ns);
  return Next::kStep;
}

Executive::Next Executive::cycle() noexcept {
  // 1. Apply the commands of this tick.
  apply_commands();
  recorder_.tick(simulation_.get_tick(), hash_);

  // 2. Step.
  beat(Place::kStepping);
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
  beat(Place::kPublishing);
  hash_ = simulation_.calc_hash();
  tick_.store(simulation_.get_tick(), std::memory_order_relaxed);
  if (options_.faults != nullptr) begin_faults();
  publish(report);

  // 4. Account for the time.
  return account(end_ns);
}

void Executive::apply_commands() noexcept {
  const MayWait without_deadlines(!is_realtime());
  if (options_.faults != nullptr) publish_faults();
  commands_.take_due(simulation_.get_tick(), [this](const CommandQueue::Pending& pending) {
    const CommandMessage& command = pending.command;
    commanders_[static_cast<std::size_t>(command.channel)] = pending.sender;
    applied_ns_ = command_ns_;
    set_channel({.channel = command.channel,
                 .cause = pending.late ? ChangeCause::kLateCommand : ChangeCause::kCommand,
                 .participant = participants_.get_index(*pending.sender),
                 .sequence = command.sequence,
                 .value = command.value});
  });
}

void Executive::publish(const StepReport& report) noexcept {
  const MayWait without_deadlines(!is_realtime());
  for (const FiredEvent& fired : report.events) publisher_.publish_event(fired);
  const bool is_last = simulation_.get_tick() == options_.last_tick;
  if (!is_last && !simulation_.is_state_due()) return;
  if (!is_last && is_realtime() && options_.timing.overruns.kind == OverrunPolicy::Kind::kSkipOutput &&
      clock_.get_ns() > ticks_.get_next_due_ns()) {
    ++skipped_outputs_;
    return;
  }
  exchange_.publish(is_last ? RunStatus::kDone : RunStatus::kRunning, hash_);
  if (applied_ns_) timing_.turnaround.record(*liveness_.get_sent_ns() - *applied_ns_);
  applied_ns_.reset();
}

Executive::Next Executive::account(std::int64_t step_end_ns) noexcept {
  const MayWait without_deadlines(!is_realtime());
  const std::int64_t now_ns = clock_.get_ns();
  now_.output_ns = now_ns - step_end_ns;
  if (options_.timing.per_tick) recorder_.timing(now_);
  if (now_ns - *health_ns_ >= kHealthInterval_ns) publish_health(now_ns);
  if (!reactions_ns_ || now_ns - *reactions_ns_ >= kReactionsInterval_ns) publish_reactions(now_ns);
  announcer_.announce(now_ns);
  publisher_.begin_tick();
  if (is_realtime() && now_ns > ticks_.get_next_due_ns()) return account_overrun(now_ns);
  return Next::kStep;
}

Executive::Next Executive::account_overrun(std::int64_t now_ns) noexcept {
  publisher_.publish_overrun(timing_.account_overrun(now_, now_ns - ticks_.get_next_due_ns()));
  const OverrunPolicy& policy = options_.timing.overruns;
  if (policy.kind == OverrunPolicy::Kind::kSlip) slipped_ns_ += ticks_.slip(now_ns);
  overrun_ends_ = policy.kind == OverrunPolicy::Kind::kFail ||
                  (policy.kind == OverrunPolicy::Kind::kCatchUp && ticks_.calc_behind(now_ns) > policy.max_ticks);
  return overrun_ends_ ? Next::kStop : Next::kStep;
}

// --- Inputs ---------------------------------------------------------------------------------------------------------

void Executive::receive() noexcept {
  const MayWait without_deadlines(!is_realtime() || !started_ns_);
  beat(Place::kReceiving);
  for (int i = 0; i < kMaxArrivals && connection_.receive(arrival_); ++i) {
    std::visit([this](const auto& message) { handle(message, arrival_.arrived_ns); }, arrival_.message);
  }
  const std::int64_t malformed = connection_.get_malformed();
  if (malformed != malformed_) rejects_.add(Reject::kMalformed, malformed - malformed_);
  malformed_ = malformed;
}

void Executive::handle(const HelloAckMessage& answer, std::int64_t) noexcept {
  const Handshake::Outcome outcome = handshake_.receive(answer, clock_.get_ns());
  if (outcome.reject) rejects_.add(*outcome.reject);
  if (outcome.verdict) publisher_.publish_verdict(*outcome.reject, answer.participant, answer.sequence, -1, -1);
  if (outcome.restarted != nullptr) commands_.remove(*outcome.restarted);
  if (!outcome.notice.empty()) publisher_.publish_notice(outcome.notice, get_name(answer.name));
}

void Executive::handle(const CommandMessage& command, std::int64_t arrived_ns) noexcept {
  Participant* const sender = command.session == options_.session ? participants_.find(command.participant) : nullptr;
  if (sender != nullptr) resume(*sender);
  command_ns_ = arrived_ns;
  const bool in_time = !is_realtime() || !cutoff_ns_ || arrived_ns <= *cutoff_ns_;
  const std::int64_t tick = simulation_.get_tick();
  const CommandQueue::Outcome outcome = commands_.add(command, sender, in_time ? tick : tick + 1);
  if (outcome.repeated) return;
  if (outcome.reason) {
    publisher_.publish_verdict(*outcome.reason, command.participant, command.sequence, command.channel,
                               outcome.applied_tick);
  }
  if (outcome.displaced) {
    publisher_.publish_verdict(Reject::kNoPlace, command.participant, outcome.displaced->sequence,
                               outcome.displaced->channel, -1);
  }
  const bool is_known = outcome.reason == Reject::kDuplicate || outcome.reason == Reject::kJump;
  if (sender != nullptr && !is_known) sender->news_ns = arrived_ns;
}

void Executive::handle(const StepAckMessage& ack, std::int64_t arrived_ns) noexcept {
  if (ack.session != options_.session) return rejects_.add(Reject::kWrongSession);
  Participant* const sender = participants_.find(ack.participant);
  if (sender == nullptr || sender->standing == Participant::Standing::kEvicted) {
    return rejects_.add(Reject::kUnknownParticipant);
  }
  const bool sane = ack.tick >= 0 && ack.tick <= simulation_.get_tick() && ack.last_command >= 0 &&
                    ack.command_count >= 0 && ack.command_count <= SeenCommands::kWindow;
  if (!sane) return rejects_.add(Reject::kMalformed);
  resume(*sender);
  liveness_.receive(ack, *sender, arrived_ns, clock_.get_ns());
}

// Another simulator, or our own messages come back.
void Executive::handle(const HelloMessage& other, std::int64_t) noexcept {
  const bool is_over = other.status >= static_cast<std::int32_t>(RunStatus::kDone);
  if (other.session == options_.session || other.session == 0 || is_over) return;
  const bool is_news = other.session != other_.session;
  other_ = other;
  if (is_news) publisher_.publish_notice(kOtherSimulator, get_name(other.scenario));
}

void Executive::resume(Participant& participant) noexcept {
  if (liveness_.resume(participant, clock_.get_ns())) publisher_.publish_notice(kResumed, participant.name);
}

// A required participant has not answered in time, or leaves: the policy is applied.
Executive::Next Executive::lose(Participant& participant) noexcept {
  const Policy policy = liveness_.get_policy();
  char name[kNameLength] = {};
  const std::string_view policy_name = get_text(policy);
  kPolicyPrefix.copy(name, kPolicyPrefix.size());
  policy_name.copy(name + kPolicyPrefix.size(), sizeof name - kPolicyPrefix.size() - 1);
  publisher_.publish_notice(name, participant.name);
  const bool left = liveness_.lose(participant);
  if (policy == Policy::kPause) return pause(participant);
  if (policy == Policy::kAbort) {
    return stop("the flight software '" + participant.name + "' " + (left ? "has left" : "did not answer in time") +
                " (policy: abort)");
  }
  commands_.remove(participant);
  // Concerns the channels that the lost participant has set, and those without a commander.
  const std::vector<Channel>& channels = simulation_.model().channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (commanders_[i] != &participant && commanders_[i] != nullptr) continue;
    const std::optional<double> value = calc_policy_value(policy, channels[i]);
    if (!value) continue;
    set_channel({.channel = static_cast<std::int32_t>(i),
                 .cause = ChangeCause::kPolicy,
                 .participant = participants_.get_index(participant),
                 .sequence = 0,
                 .value = *value});
  }
  return Next::kStep;
}

void Executive::set_channel(const LogChange& change) noexcept {
  const auto channel = static_cast<std::size_t>(change.channel);
  const bool is_fault = change.cause == ChangeCause::kFault;
  if (channel_faults_ && !is_fault) {
    if (!channel_faults_->command(channel, change.value, simulation_.channels()[channel])) return;
  }
  if (simulation_.set_channel(channel, change.value)) recorder_.change(change);
}

// --- Outputs --------------------------------------------------------------------------------------------------------

void Executive::publish_health(std::int64_t now_ns) noexcept {
  HealthMessage health;
  health.wall_ns = started_ns_ ? now_ns - *started_ns_ : 0;
  health.step_p50_ns = timing_.step.calc_percentile(0.5);
  health.step_max_ns = timing_.step.get_max();
  health.wakeup_p50_ns = timing_.wakeup.calc_percentile(0.5);
  health.wakeup_max_ns = timing_.wakeup.get_max();
  health.overruns = timing_.get_overruns();
  health.dropped = calc_dropped();
  health.late = commands_.get_late();
  health.missing = participants_.count_missing();
  health.rejected = rejects_.by_reason;
  publisher_.publish_health(health);
  health_ns_ = now_ns;
}

void Executive::publish_reactions(std::int64_t now_ns) noexcept {
  publisher_.publish_reactions();
  reactions_ns_ = now_ns;
}

// At the beginning of each tick, before its State is published.
void Executive::begin_faults() noexcept {
  const MayWait without_deadlines(!is_realtime());
  const auto end_freeze = [this](Participant& participant) {
    publish_faults();
    resume(participant);
  };
  options_.faults->begin_tick(simulation_.get_tick(), clock_.get_ns(), participants_, end_freeze);
  publish_faults();
  for (std::size_t i = 0; i < simulation_.channels().size(); ++i) {
    set_channel({.channel = static_cast<std::int32_t>(i),
                 .cause = ChangeCause::kFault,
                 .participant = -1,
                 .sequence = 0,
                 .value = channel_faults_->calc_value(i, simulation_.channels()[i])});
  }
}

void Executive::publish_faults() noexcept {
  FaultNotice notice;
  while (options_.faults->take_notice(notice)) publisher_.publish_notice(notice.name, notice.fault->subject);
}

std::int64_t Executive::calc_dropped() const noexcept {
  return connection_.get_dropped_out() + connection_.get_dropped_in();
}

// --- The beginning and the end: nothing here is in the cycle --------------------------------------------------------

std::optional<std::string> Executive::begin() {
  const auto begin_faults_if_any = [this] {
    if (options_.faults != nullptr) begin_faults();
  };
  if (options_.pace == Pace::kFast) {
    announcer_.send_all();
    begin_faults_if_any();
  } else {
    const SessionStart start({.options = options_,
                              .clock = clock_,
                              .announcer = announcer_,
                              .handshake = handshake_,
                              .participants = participants_,
                              .liveness = liveness_,
                              .exchange = exchange_,
                              .other = other_,
                              .stop = stop_,
                              .receive = [this] { receive(); },
                              .begin_faults = begin_faults_if_any,
                              .timeout_ns = options_.start_timeout_ns,
                              .resend_ns = options_.resend_ns});
    if (auto failure = start.run(hash_)) return failure;
    commands_.expect_repeats(0);
    exchange_.resend(RunStatus::kArmed);
    publisher_.set_resent(0);
  }
  announcer_.set_status(RunStatus::kRunning);
  handshake_.begin_run();
  started_ns_ = health_ns_ = clock_.get_ns();
  if (options_.pace == Pace::kFast) {
    exchange_.publish(options_.last_tick == 0 ? RunStatus::kDone : RunStatus::kRunning, hash_);
  }
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
    end.message = describe_fault(end, simulation_.model(), simulation_.plan().get_options().dt);
    return end;
  }
  if (overrun_ends_) {
    const bool fail = options_.timing.overruns.kind == OverrunPolicy::Kind::kFail;
    end_message_ =
        "tick " + std::to_string(now_.tick) + " overran its period (policy: " +
        (fail ? "fail" : "catch_up, at most " + std::to_string(options_.timing.overruns.max_ticks) + " ticks") +
        "); the table of overruns has the cause";
  }
  return conclude(RunStatus::kAborted, end_message_);
}

LogEnd Executive::conclude(RunStatus status, std::string message) {
  if (options_.faults != nullptr) publish_faults();
  beat(Place::kEnding);
  announcer_.set_status(status);
  announcer_.send_farewell();
  while (announcer_.send_unsent_source_part()) beat(Place::kEnding);
  for (int i = 0; i < kFinalStates; ++i) {
    exchange_.resend(status);
    clock_.sleep_until_ns(clock_.get_ns() + kFinalInterval_ns);
  }
  publisher_.set_resent(publisher_.get_resent() - kFinalStates);
  publish_health(clock_.get_ns());
  if (status != RunStatus::kFaulted) publish_reactions(clock_.get_ns());

  LogEnd end;
  end.tick = simulation_.get_tick();
  end.hash = hash_;
  end.status = status;
  end.message = std::move(message);
  end.timing = timing_.summarize();
  end.timing.slipped_ns = slipped_ns_;
  end.timing.skipped_outputs = skipped_outputs_;
  end.timing.late_commands = commands_.get_late();
  end.timing.rejected = rejects_.by_reason;
  end.timing.dropped = calc_dropped();
  end.timing.resent = publisher_.get_resent();
  return end;
}

// --- The watching thread --------------------------------------------------------------------------------------------

void Executive::watch_counts() {
  const std::optional<ThreadCounts> now = read_thread_counts(thread_.load(std::memory_order_relaxed));
  if (!now) return;             // it does not run yet, or no more
  timing_.disregard(watched_);  // not the latest: an overrun may be on its way
  watched_ = *now;
}

std::string Executive::describe_place() const {
  static constexpr const char* kPlaces[] = {"before the first tick", "waiting for",           "receiving the inputs of",
                                            "in the step of",        "publishing results of", "at the end, after"};
  const Place place = place_.load(std::memory_order_relaxed);
  const std::string text = kPlaces[static_cast<std::size_t>(place)];
  return place == Place::kBeginning ? text : text + " tick " + std::to_string(get_tick());
}

}  // namespace unlatch::hil
