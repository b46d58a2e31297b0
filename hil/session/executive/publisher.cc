#include "hil/session/executive/publisher.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "hil/run/simulation/model_messages.h"
#include "hil/session/messages/event_names.h"

namespace unlatch::hil {

Publisher::Publisher(const Simulation& simulation, Recorder& recorder, Connection& connection, FaultInjector* faults,
                     std::int64_t session)
    : simulation_(simulation),
      recorder_(recorder),
      connection_(connection),
      faults_(faults),
      session_(session),
      dt_ns_(std::llround(simulation.plan().get_options().dt * 1e9)),
      model_events_(build_event_messages(simulation.model())) {}

void Publisher::send_state_part(std::int32_t part, RunStatus status) noexcept {
  fill_state(simulation_, part, dt_ns_, state_);
  state_.status = static_cast<std::int32_t>(status);
  if (faults_ != nullptr) faults_->distort(state_);
  connection_.send(state_);
}

void Publisher::publish_state(RunStatus status, std::int64_t hash) noexcept {
  const bool record = recorder_.wants_state(simulation_.get_tick()) || status != RunStatus::kRunning;
  state_.session = session_;
  state_.sequence = state_sequence_++;
  state_.hash = hash;
  for (std::int32_t part = count_state_parts(simulation_) - 1; part >= 0; --part) {  // part 0, the token, comes last
    send_state_part(part, status);
    if (record) recorder_.state(state_);
  }
}

void Publisher::resend_state(RunStatus status) noexcept {
  for (std::int32_t part = count_state_parts(simulation_) - 1; part >= 0; --part) send_state_part(part, status);
  ++resent_;
}

void Publisher::publish(EventMessage& event, std::int64_t tick, double time) noexcept {
  event.session = session_;
  event.sequence = event_sequence_++;
  event.tick = tick;
  event.time = time;
  event.time_ns = std::llround(time * 1e9);
  connection_.send(event);
  recorder_.event(event);
}

void Publisher::publish_event(const FiredEvent& fired) noexcept {
  EventMessage event = model_events_[static_cast<std::size_t>(fired.event)];
  publish(event, simulation_.get_tick() - 1, fired.time);
}

void Publisher::publish_notice(std::string_view name, std::string_view subject) noexcept {
  EventMessage event;
  set_name(event.name, name);
  set_name(event.subject, subject);
  publish(event, simulation_.get_tick(), simulation_.get_time());
  if (is_notice(event)) notices_.try_enqueue(event);
}

void Publisher::publish_fault_notices() noexcept {
  if (faults_ == nullptr) return;
  FaultNotice notice;
  while (faults_->take_notice(notice)) publish_notice(notice.name, notice.fault->subject);
}

// "overrun.step", "1204 us late: woken 3, inputs 2, step 1180, outputs 19 us"; the part that does not fit is left out.
void Publisher::publish_overrun(const Overrun& overrun) noexcept {
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
  EventMessage event;
  set_name(event.subject, {text, static_cast<std::size_t>(end - text)});
  end = name;
  add_text(kOverrunPrefix);
  add_text(kOverrunCauseNames[static_cast<std::size_t>(overrun.cause)]);
  set_name(event.name, {name, static_cast<std::size_t>(end - name)});
  publish(event, simulation_.get_tick() - 1, simulation_.get_time());
}

// "refused.past_tick", or "command.late"; "fsw nozzle1". Nobody is sent it: the Verdict says the same.
void Publisher::record_verdict(Reject reason, std::string_view from, std::int32_t channel) noexcept {
  char text[2 * kNameLength], name[kNameLength];
  char* end = text;
  const auto add = [&end](std::string_view part) {
    end = std::copy_n(part.begin(), std::min(part.size(), kNameLength - 1), end);
  };
  EventMessage event;
  add(from);
  const std::vector<Channel>& channels = simulation_.model().channels;
  if (channel >= 0 && static_cast<std::size_t>(channel) < channels.size()) {
    if (!from.empty()) add(" ");
    add(channels[static_cast<std::size_t>(channel)].name);
  }
  set_name(event.subject, {text, static_cast<std::size_t>(end - text)});
  end = name;
  if (reason != Reject::kLate) add(kRefusedPrefix);
  add(reason == Reject::kLate ? kLateCommandName : get_text(reason));
  set_name(event.name, {name, static_cast<std::size_t>(end - name)});
  event.session = session_;
  event.sequence = -1;
  event.tick = simulation_.get_tick();
  event.time = simulation_.get_time();
  event.time_ns = std::llround(event.time * 1e9);
  recorder_.event(event);
}

void Publisher::publish_verdict(Reject reason, std::string_view from, std::int32_t participant, std::int64_t refers_to,
                                std::int32_t channel, std::int64_t applied_tick) noexcept {
  if (verdicts_left_ == 0) return;
  --verdicts_left_;
  record_verdict(reason, from, channel);
  VerdictMessage verdict;
  verdict.refers_to = refers_to;
  verdict.applied_tick = applied_tick;
  verdict.participant = participant;
  verdict.reason = static_cast<std::int32_t>(reason);
  verdict.channel = channel;
  verdict.count = 1;
  send_verdict(verdict);
}

void Publisher::publish_missing(std::int32_t participant, std::int64_t first, std::int64_t count) noexcept {
  VerdictMessage verdict;
  verdict.refers_to = first;
  verdict.applied_tick = -1;
  verdict.participant = participant;
  verdict.reason = static_cast<std::int32_t>(Reject::kMissing);
  verdict.channel = -1;
  verdict.count = static_cast<std::int32_t>(count);
  send_verdict(verdict);
}

void Publisher::send_verdict(VerdictMessage verdict) noexcept {
  verdict.session = session_;
  verdict.sequence = verdict_sequence_++;
  verdict.tick = simulation_.get_tick();
  connection_.send(verdict);
}

void Publisher::publish_health(HealthMessage health) noexcept {
  health.session = session_;
  health.sequence = health_sequence_++;
  health.tick = simulation_.get_tick();
  health.time_ns = health.tick * dt_ns_;
  health.resent = resent_;
  connection_.send(health);
}

void Publisher::publish_reactions() noexcept {
  const auto& all = simulation_.workspace().multipliers;
  reactions_.session = session_;
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
    connection_.send(reactions_);
  }
}

}  // namespace unlatch::hil
