// What the executive hears, and when a tick has heard enough.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "hil/executive.h"
#include "hil/executive_notices.h"
#include "hil/pacer.h"

namespace unlatch::hil {
namespace {

constexpr int kMessagesPerLook = 512;              // bounds the work of one look at the ring
constexpr std::chrono::milliseconds kPatience(5);  // lockstep: the longest sleep between two looks at the clock
constexpr std::int64_t kPauseLook_ns = 5'000'000;

}  // namespace

// --- Waiting --------------------------------------------------------------------------------------------------------

Executive::Go Executive::wait_realtime() noexcept {
  drain();
  is_answered();  // closes the round trip
  if (Participant* const overdue = find_overdue(get_monotonic_ns())) return lose(*overdue);
  return Go::kStep;
}

Executive::Go Executive::wait_lockstep() noexcept {
  if (sent_tick_ != simulation_.get_tick()) return Go::kStep;  // no State, no answers
  std::int64_t resend_at_ns = sent_ns_ + options_.resend_ns;
  while (true) {
    drain();
    if (is_answered()) return Go::kStep;
    if (stop_.load(std::memory_order_relaxed)) return end_message_ = "interrupted", Go::kStop;
    const std::int64_t now_ns = get_monotonic_ns();
    if (Participant* const overdue = find_overdue(now_ns)) {
      if (lose(*overdue) == Go::kStop) return Go::kStop;
      continue;
    }
    if (now_ns >= resend_at_ns) {
      resend_state(RunStatus::kRunning);
      resend_at_ns = now_ns + options_.resend_ns;
    }
    link_.wait(kPatience);
  }
}

// Waits, without stepping, until the participant is back.
Executive::Go Executive::pause(Participant& participant) noexcept {
  std::int64_t resend_at_ns = 0;
  while (!participant.has_answered(simulation_.get_tick())) {
    if (stop_.load(std::memory_order_relaxed)) return end_message_ = "interrupted", Go::kStop;
    const std::int64_t now_ns = get_monotonic_ns();
    if (now_ns >= resend_at_ns) {
      resend_state(RunStatus::kPaused);
      resend_at_ns = now_ns + std::max(options_.resend_ns, kPauseLook_ns);
    }
    sleep_until_ns(now_ns + kPauseLook_ns);
    drain();
  }
  publish_notice(kResumed, participant.name);
  const std::int64_t now_ns = get_monotonic_ns();
  ticks_->restart(now_ns);  // the pause is no overrun
  for (Participant& other : roster_.all()) {
    if (other.waiting_since_ns >= 0) other.waiting_since_ns = now_ns;
  }
  return Go::kStep;
}

// Have all required participants answered this tick?
bool Executive::is_answered() noexcept {
  const std::int64_t tick = sent_tick_;
  std::int64_t last_ns = 0;
  for (const Participant& participant : roster_.all()) {
    if (!participant.required || participant.lost) continue;
    if (!participant.has_answered(tick)) return false;
    last_ns = std::max(last_ns, participant.ack_arrived_ns);
  }
  if (round_trip_open_ && last_ns > 0) timing_.round_trip.record(last_ns - sent_ns_);
  round_trip_open_ = false;
  return true;
}

Participant* Executive::find_overdue(std::int64_t now_ns) noexcept {
  for (Participant& participant : roster_.all()) {
    if (participant.required && !participant.lost && participant.waiting_since_ns >= 0 &&
        now_ns - participant.waiting_since_ns > timeout_ns_) {
      return &participant;
    }
  }
  return nullptr;
}

// --- Hearing --------------------------------------------------------------------------------------------------------

void Executive::drain() noexcept {
  const MayWait without_deadlines(options_.pace != Pace::kRealtime || started_ns_ == 0);
  beat(Place::kHearing);
  std::int64_t arrived_ns = 0;
  for (int i = 0; i < kMessagesPerLook && link_.receive(message_, arrived_ns); ++i) hear(message_, arrived_ns);
}

void Executive::hear(const Message& message, std::int64_t arrived_ns) noexcept {
  switch (message.kind) {
    case MessageKind::kCommand:
      heard_ns_ = arrived_ns;
      return desk_.offer(message.command, roster_.find(message.command.participant), simulation_.get_tick());
    case MessageKind::kStepAck:
      return hear_ack(message.step_ack, arrived_ns);
    case MessageKind::kHelloAck:
      return hear_hello(message.hello_ack);
    default:
      return;  // a bridge delivers nothing else
  }
}

void Executive::hear_hello(const HelloAck& hello) noexcept {
  if (hello.session != options_.session) return;
  const std::string_view name = get_name(hello.name);
  if (hello.schema_hash != kSchemaHash || hello.status == static_cast<std::int32_t>(AckStatus::kRefused)) {
    const auto& required = options_.flight_software.required;
    if (started_ns_ == 0 && std::find(required.begin(), required.end(), name) != required.end()) {
      refusal_ = "the flight software '" + std::string(name) + "' refuses to take part: ";
      refusal_ += hello.schema_hash != kSchemaHash ? "it was built for another version of the message schema"
                                                   : std::string(get_name(hello.reason));
    }
    return;
  }
  const bool known = roster_.find(hello.participant) != nullptr;
  const Participant* const participant = roster_.admit(hello);
  if (participant != nullptr && !known) publish_notice(kJoined, name);
}

void Executive::hear_ack(const StepAck& ack, std::int64_t arrived_ns) noexcept {
  Participant* const participant = roster_.find(ack.participant);
  if (ack.session != options_.session || participant == nullptr || ack.tick < participant->ack.tick) return;
  if (ack.tick > participant->ack.tick) participant->ack_arrived_ns = arrived_ns;
  participant->ack = ack;
  // Alive: it owes nothing, or an answer to a later State, counted from now.
  participant->waiting_since_ns = ack.tick >= sent_tick_ ? -1 : get_monotonic_ns();
}

// --- Acting ---------------------------------------------------------------------------------------------------------

Executive::Go Executive::lose(Participant& participant) noexcept {
  const auto policy = options_.flight_software.policy;
  char name[kNameLength] = {};
  kPolicyPrefix.copy(name, kPolicyPrefix.size());
  kPolicyNames[static_cast<std::size_t>(policy)].copy(name + kPolicyPrefix.size(),
                                                      sizeof name - kPolicyPrefix.size() - 1);
  publish_notice(name, participant.name);
  if (policy == FlightSoftware::Policy::kPause) return pause(participant);
  if (policy == FlightSoftware::Policy::kAbort) {
    end_message_ = "the flight software '" + participant.name + "' did not answer in time (policy: abort)";
    return Go::kStop;
  }
  participant.lost = true;
  desk_.drop(participant.id);
  apply_policy(participant);
  return Go::kStep;
}

// Concerns the channels that the lost participant has set, and those that nobody has.
void Executive::apply_policy(const Participant& participant) noexcept {
  const auto policy = options_.flight_software.policy;
  if (policy == FlightSoftware::Policy::kHold) return;
  const std::vector<Channel>& channels = simulation_.model().channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (commander_[i] != participant.id && commander_[i] != kNobody) continue;
    const double zero = std::clamp(0.0, channels[i].minimum, channels[i].maximum);
    const double value = policy == FlightSoftware::Policy::kZero ? zero : channels[i].safe;
    set_channel(static_cast<std::int32_t>(i), value, ChangeCause::kPolicy, participant.id, 0);
  }
}

void Executive::apply_commands() noexcept {
  desk_.take_due(simulation_.get_tick(), [this](const Command& command) {
    commander_[static_cast<std::size_t>(command.channel)] = command.participant;
    applied_since_ns_ = heard_ns_;
    set_channel(command.channel, command.value, ChangeCause::kCommand, command.participant, command.sequence);
  });
}

void Executive::set_channel(std::int32_t channel, double value, ChangeCause cause, std::int32_t participant,
                            std::int64_t sequence) noexcept {
  double& now = simulation_.channels()[static_cast<std::size_t>(channel)];
  if (now == value && std::signbit(now) == std::signbit(value)) return;
  now = value;
  recorder_.change({channel, cause, participant, sequence, value});
}

}  // namespace unlatch::hil
