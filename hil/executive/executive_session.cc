// How a session begins and ends, and what the executive says in between.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "hil/executive/executive.h"
#include "hil/messages/notices.h"
#include "hil/realtime/clock.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kHelloInterval_ns = 100'000'000;
constexpr std::int64_t kLook_ns = 1'000'000;
constexpr int kFarewells = 3;  // the last State, repeated for transports that lose messages
constexpr std::int64_t kFarewellInterval_ns = 5'000'000;

}  // namespace

// --- The beginning: nothing here is in the cycle --------------------------------------------------------------------

bool Executive::introduce(std::string& failure) {
  if (options_.pace == Pace::kFast) return say_hello(), true;
  const std::int64_t give_up_ns = clock_.get_ns() + options_.start_timeout_ns;
  do {
    if (stop_.load(std::memory_order_relaxed)) return failure = "interrupted", false;
    say_hello();
    if (wait_for_introductions(clock_.get_ns() + kHelloInterval_ns)) {
      hello_.status = static_cast<std::int32_t>(RunStatus::kConfigured);
      return true;
    }
    if (!refusal_.empty()) return failure = refusal_, false;
  } while (clock_.get_ns() < give_up_ns);
  failure = "no answer from the flight software " +
            roster_.list_required([](const Participant& participant) { return !participant.is_present(); }) +
            " within " + std::to_string(options_.start_timeout_ns / 1'000'000'000) +
            " s: start it on the same transport, with the name that the scenario requires";
  return false;
}

// Configured: State(0) goes out until everybody required has answered it, so that the way is known to be open in both
// directions, for every topic, before the clock starts. Armed: it is; the first step follows.
bool Executive::configure(std::string& failure) {
  const std::int64_t give_up_ns = clock_.get_ns() + options_.start_timeout_ns;
  if (options_.faults != nullptr) begin_faults();
  if (options_.pace != Pace::kFast) {
    publish_state(RunStatus::kConfigured);
    while (drain(), !is_answered()) {
      if (stop_.load(std::memory_order_relaxed)) return failure = "interrupted", false;
      const std::int64_t now_ns = clock_.get_ns();
      if (now_ns > give_up_ns || !roster_.is_complete()) {
        failure = "the flight software " + roster_.list_required([](const Participant& participant) {
          return !participant.has_answered(0);
        }) + " has introduced itself, but does not answer State 0: does it hear the State and send StepAck?";
        return false;
      }
      announce(now_ns);
      if (now_ns - sent_ns_ >= options_.resend_ns) {
        resend_state(RunStatus::kConfigured);
        sent_ns_ = now_ns;
      }
      clock_.sleep_until_ns(now_ns + kLook_ns);
    }
    resend_state(RunStatus::kArmed);
    resent_ = 0;
  }
  hello_.status = static_cast<std::int32_t>(RunStatus::kRunning);
  started_ns_ = health_ns_ = clock_.get_ns();
  if (options_.pace == Pace::kFast) publish_state(options_.last_tick == 0 ? RunStatus::kDone : RunStatus::kRunning);
  return true;
}

bool Executive::wait_for_introductions(std::int64_t deadline_ns) {
  while (!roster_.is_complete() && refusal_.empty() && clock_.get_ns() < deadline_ns) {
    drain();
    clock_.sleep_until_ns(clock_.get_ns() + kLook_ns);
  }
  return roster_.is_complete() && refusal_.empty();
}

void Executive::say_hello() {
  (void)send_until_taken(hello_);
  ++hello_.sequence;
  for (Catalog& item : catalog_) {
    item.sequence = catalog_sequence_++;
    (void)send_until_taken(item);
  }
}

// A large catalog does not fit the ring at once; without anybody at its other end we do not wait for ever.
// Returns whether it went.
bool Executive::send_until_taken(const Message& message) {
  if (options_.faults != nullptr) {
    say(message);
    return true;
  }
  for (int attempt = 0; attempt < 100; ++attempt) {
    if (link_.send(message)) return true;
    clock_.sleep_until_ns(clock_.get_ns() + kLook_ns);
  }
  return false;
}

// For those who come later, or come back: one message now and then, so that no tick is burdened with a whole catalog.
void Executive::announce(std::int64_t now_ns) noexcept {
  if (announced_ns_ && now_ns - *announced_ns_ < options_.announce_ns) return;
  announced_ns_ = now_ns;
  if (announce_next_ == 0) {
    say(hello_);
    ++hello_.sequence;
  } else {
    Catalog& item = catalog_[announce_next_ - 1];
    item.sequence = catalog_sequence_++;
    say(item);
  }
  announce_next_ = (announce_next_ + 1) % (catalog_.size() + 1);
  announce_source();
}

void Executive::announce_source() noexcept {
  if (source_.empty()) return;
  Source& part = source_[source_next_];
  part.sequence = source_sequence_++;
  say(part);
  source_next_ = (source_next_ + 1) % source_.size();
}

// A run may be over before each part has had its turn. Nobody waits for it if nobody takes it.
void Executive::tell_rest_of_source() {
  for (; source_sequence_ < static_cast<std::int64_t>(source_.size()); ++source_sequence_) {
    beat(Place::kEnding);
    Source& part = source_[static_cast<std::size_t>(source_sequence_)];
    part.sequence = source_sequence_;
    if (!send_until_taken(part)) return;
  }
}

// --- What is said while it runs -------------------------------------------------------------------------------------

void Executive::publish_state(RunStatus status) noexcept {
  const std::int32_t parts = simulation_.get_part_count();
  const bool record = recorder_.wants_state(simulation_.get_tick()) || status != RunStatus::kRunning;
  state_.session = options_.session;
  state_.sequence = state_sequence_++;
  state_.hash = hash_;
  state_.status = static_cast<std::int32_t>(status);
  for (std::int32_t part = parts - 1; part >= 0; --part) {  // part 0 comes last: it is the token of lockstep
    simulation_.fill_state(part, dt_ns_, state_);
    if (options_.faults != nullptr) options_.faults->distort(state_);
    say(state_);
    if (record) recorder_.state(state_);
  }
  sent_ns_ = clock_.get_ns();
  sent_tick_ = simulation_.get_tick();
  round_trip_open_ = true;
  for (Participant& participant : roster_.all()) {
    if (!participant.waiting_since_ns) participant.waiting_since_ns = sent_ns_;
  }
}

void Executive::resend_state(RunStatus status) noexcept {
  state_.status = static_cast<std::int32_t>(status);
  sent_tick_ = simulation_.get_tick();
  for (std::int32_t part = simulation_.get_part_count() - 1; part >= 0; --part) {
    simulation_.fill_state(part, dt_ns_, state_);
    if (options_.faults != nullptr) options_.faults->distort(state_);
    say(state_);
  }
  ++resent_;
}

void Executive::publish_event(Event event, double time, bool notice) noexcept {
  event.session = options_.session;
  event.sequence = event_sequence_++;
  event.tick = simulation_.get_tick() - (notice ? 0 : 1);  // of the step that it happened in
  event.time = time;
  event.time_ns = std::llround(time * 1e9);
  say(event);
  recorder_.event(event);
  if (notice && is_notice(event)) notices_.try_enqueue(event);
}

void Executive::publish_notice(std::string_view what, std::string_view subject) noexcept {
  Event event;
  set_name(event.name, what);
  set_name(event.subject, subject);
  publish_event(event, simulation_.get_time(), true);
}

// "overrun.step", "1204 us late: woken 3, inputs 2, step 1180, outputs 19 us"; the part that does not fit is left out.
void Executive::publish_overrun(const Overrun& overrun) noexcept {
  char text[160], name[kNameLength];
  char* end = text;
  const auto add_text = [&end](std::string_view part) { end = std::copy(part.begin(), part.end(), end); };
  const auto add_us = [&end](std::int64_t ns) { end = std::to_chars(end, end + 20, ns / 1000).ptr; };
  add_us(overrun.late_ns);
  add_text(" us late: woken ");
  add_us(overrun.timing.wakeup_ns);
  add_text(", inputs ");
  add_us(overrun.timing.input_ns);
  add_text(", step ");
  add_us(overrun.timing.step_ns);
  add_text(", outputs ");
  add_us(overrun.timing.output_ns);
  Event event;
  set_name(event.subject, {text, static_cast<std::size_t>(end - text)});
  end = name;
  add_text(kOverrunPrefix);
  add_text(kOverrunCauseNames[static_cast<std::size_t>(overrun.cause)]);
  set_name(event.name, {name, static_cast<std::size_t>(end - name)});
  publish_event(event, simulation_.get_time(), false);
}

void Executive::publish_verdict(Reject reason, std::int32_t participant, std::int64_t refers_to, std::int32_t channel,
                                std::int64_t applied_tick) noexcept {
  if (verdicts_left_ == 0) return;
  --verdicts_left_;
  Verdict verdict;
  verdict.session = options_.session;
  verdict.sequence = verdict_sequence_++;
  verdict.tick = simulation_.get_tick();
  verdict.refers_to = refers_to;
  verdict.applied_tick = applied_tick;
  verdict.participant = participant;
  verdict.reason = static_cast<std::int32_t>(reason);
  verdict.channel = channel;
  say(verdict);
}

void Executive::publish_health(std::int64_t now_ns) noexcept {
  Health health;
  health.session = options_.session;
  health.sequence = health_sequence_++;
  health.tick = simulation_.get_tick();
  health.time_ns = health.tick * dt_ns_;
  health.wall_ns = started_ns_ ? now_ns - *started_ns_ : 0;
  health.step_p50_ns = timing_.step.calc_percentile(0.5);
  health.step_max_ns = timing_.step.get_max();
  health.wakeup_p50_ns = timing_.wakeup.calc_percentile(0.5);
  health.wakeup_max_ns = timing_.wakeup.get_max();
  health.overruns = timing_.get_overruns();
  health.dropped = calc_dropped();
  health.resent = resent_;
  health.late = desk_.get_late();
  health.missing = roster_.count_missing();
  health.rejected = desk_.get_rejected();
  say(health);
  health_ns_ = now_ns;
}

// Of the last step that was made; all parts of a tick at once.
void Executive::publish_reactions(std::int64_t now_ns) noexcept {
  const auto& all = simulation_.workspace().multipliers;
  reactions_.session = options_.session;
  reactions_.sequence = reactions_sequence_++;
  reactions_.tick = simulation_.get_tick();
  reactions_.time_ns = reactions_.tick * dt_ns_;
  reactions_.parts =
      static_cast<std::int32_t>(std::max<std::size_t>(1, (all.size() + kReactionsPerPart - 1) / kReactionsPerPart));
  for (reactions_.part = 0; reactions_.part < reactions_.parts; ++reactions_.part) {
    const std::size_t begin = static_cast<std::size_t>(reactions_.part) * kReactionsPerPart;
    const std::size_t count = std::min(kReactionsPerPart, all.size() - begin);
    reactions_.count = static_cast<std::int32_t>(count);
    reactions_.multipliers.fill(0);
    for (std::size_t i = 0; i < count; ++i) reactions_.multipliers[i] = all[begin + i];
    say(reactions_);
  }
  reactions_ns_ = now_ns;
}

std::int64_t Executive::calc_dropped() const noexcept {
  const std::int64_t by_faults = options_.faults != nullptr ? options_.faults->get_dropped() : 0;
  return link_.get_dropped_out() + link_.get_dropped_in() + desk_.get_dropped() + by_faults;
}

// --- The end: nothing here is in the cycle --------------------------------------------------------------------------

LogEnd Executive::conclude(RunStatus status, std::string message) {
  if (options_.faults != nullptr) tell_faults();
  beat(Place::kEnding);
  tell_rest_of_source();
  for (int i = 0; i < kFarewells; ++i) {
    resend_state(status);
    clock_.sleep_until_ns(clock_.get_ns() + kFarewellInterval_ns);
  }
  resent_ -= kFarewells;
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
  end.timing.late_commands = desk_.get_late();
  end.timing.rejected = desk_.get_rejected();
  end.timing.dropped = calc_dropped();
  end.timing.resent = resent_;
  return end;
}

}  // namespace unlatch::hil
