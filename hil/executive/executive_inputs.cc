// What the executive hears, and when a tick has heard enough.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "hil/executive/executive.h"
#include "hil/messages/notices.h"
#include "hil/realtime/clock.h"

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
  if (Participant* const overdue = find_overdue(clock_.get_ns())) return lose(*overdue);
  return Go::kStep;
}

Executive::Go Executive::wait_lockstep() noexcept {
  if (sent_tick_ != simulation_.get_tick()) return Go::kStep;  // no State, no answers
  std::int64_t resend_at_ns = sent_ns_ + options_.resend_ns;
  while (true) {
    drain();
    if (is_answered()) return Go::kStep;
    if (stop_.load(std::memory_order_relaxed)) return end_message_ = "interrupted", Go::kStop;
    const std::int64_t now_ns = clock_.get_ns();
    if (Participant* const overdue = find_overdue(now_ns)) {
      if (lose(*overdue) == Go::kStop) return Go::kStop;
      continue;
    }
    if (now_ns >= resend_at_ns) {
      resend_state(simulation_.get_tick() == 0 ? RunStatus::kArmed : RunStatus::kRunning);
      resend_at_ns = now_ns + options_.resend_ns;
    }
    announce(now_ns);
    link_.wait(kPatience);
  }
}

// Waits, without stepping, until the participant, or a new start of it, is back.
Executive::Go Executive::pause(Participant& participant) noexcept {
  const double limit_s = options_.flight_software.pause_limit;
  const std::int64_t give_up_ns = clock_.get_ns() + std::llround(limit_s * 1e9);
  std::optional<std::int64_t> resend_at_ns;  // none: at once
  while (!participant.has_answered(simulation_.get_tick())) {
    if (stop_.load(std::memory_order_relaxed)) return end_message_ = "interrupted", Go::kStop;
    const std::int64_t now_ns = clock_.get_ns();
    if (now_ns >= give_up_ns) {
      end_message_ = "the flight software '" + participant.name + "' did not come back within the pause_limit of " +
                     std::to_string(limit_s) + " s";
      return Go::kStop;
    }
    if (!resend_at_ns || now_ns >= *resend_at_ns) {
      resend_state(RunStatus::kPaused);
      resend_at_ns = now_ns + std::max(options_.resend_ns, kPauseLook_ns);
    }
    announce(now_ns);
    clock_.sleep_until_ns(now_ns + kPauseLook_ns);
    drain();
  }
  const std::int64_t now_ns = clock_.get_ns();
  ticks_->restart(now_ns);  // the pause is no overrun
  for (Participant& other : roster_.all()) {
    if (other.waiting_since_ns) other.waiting_since_ns = now_ns;
  }
  return Go::kStep;
}

// Have all required participants that take part answered this tick? Those who have owe nothing any more.
bool Executive::is_answered() noexcept {
  const std::int64_t tick = sent_tick_;
  std::optional<std::int64_t> last_ns;
  bool all = true;
  for (Participant& participant : roster_.all()) {
    if (!participant.is_present()) continue;
    if (participant.has_answered(tick)) {
      participant.waiting_since_ns.reset();
      if (participant.required)
        last_ns = std::max(last_ns.value_or(participant.ack_arrived_ns), participant.ack_arrived_ns);
    } else {
      // Also one that had answered, and has since announced a command that is not here.
      if (!participant.waiting_since_ns) participant.waiting_since_ns = clock_.get_ns();
      if (participant.required) all = false;
    }
  }
  if (!all) return false;
  if (round_trip_open_ && last_ns) timing_.round_trip.record(*last_ns - sent_ns_);
  round_trip_open_ = false;
  return true;
}

Participant* Executive::find_overdue(std::int64_t now_ns) noexcept {
  for (Participant& participant : roster_.all()) {
    if (!participant.required || !participant.is_present()) continue;
    const bool overdue = participant.waiting_since_ns && now_ns - *participant.waiting_since_ns > timeout_ns_;
    if (overdue || participant.leaving) return &participant;
  }
  return nullptr;
}

// --- Hearing --------------------------------------------------------------------------------------------------------

void Executive::drain() noexcept {
  const MayWait without_deadlines(options_.pace != Pace::kRealtime || !started_ns_);
  beat(Place::kHearing);
  std::int64_t arrived_ns = 0;
  std::int64_t malformed = link_.get_malformed();
  for (int i = 0; i < kMessagesPerLook && link_.receive(message_, arrived_ns); ++i) {
    if (options_.faults == nullptr) {
      hear(message_, arrived_ns);
    } else {
      options_.faults->offer(Direction::kIn, message_, arrived_ns, clock_.get_ns(), find_speaker(message_));
    }
  }
  if (options_.faults != nullptr) {
    pass_through_faults();
    malformed += options_.faults->get_malformed();
  }
  if (malformed != malformed_) desk_.refuse(Reject::kMalformed, malformed - malformed_);
  malformed_ = malformed;
}

void Executive::hear(const Message& message, std::int64_t arrived_ns) noexcept {
  switch (message.kind) {
    case MessageKind::kCommand:
      return hear_command(message.command, arrived_ns);
    case MessageKind::kStepAck:
      return hear_ack(message.step_ack, arrived_ns);
    case MessageKind::kHelloAck:
      return hear_hello(message.hello_ack);
    default:
      return;  // a bridge delivers nothing else
  }
}

// What the two do not agree on; empty if they do.
std::string_view Executive::find_mismatch(const HelloAck& hello) const noexcept {
  if (hello.protocol != hello_.protocol) return "it speaks another version of the protocol";
  if (hello.schema_hash != kSchemaHash) return "it was built for another version of the message schema";
  if (hello.model_hash != hello_.model_hash) return "it expects another model";
  if (hello.dt_ns != hello_.dt_ns) return "it expects another step size";
  return {};
}

void Executive::hear_hello(const HelloAck& hello) noexcept {
  if (hello.session != options_.session) return desk_.refuse(Reject::kWrongSession);
  const std::string_view name = get_name(hello.name);
  Participant* const known = roster_.find(name);
  const auto status = static_cast<AckStatus>(hello.status);
  std::string_view mismatch = find_mismatch(hello);
  if (!mismatch.empty()) refuse(hello, Reject::kMismatch, kNotAdmitted);
  if (status == AckStatus::kRefused) mismatch = get_name(hello.reason);
  if (!mismatch.empty() || status == AckStatus::kRefused) {
    if (!started_ns_ && known != nullptr && known->required) {
      refusal_ = "the flight software '" + std::string(name) + "' does not take part: " + std::string(mismatch);
    }
    return;
  }
  if (status == AckStatus::kLeaving) {
    if (known == nullptr || !known->is_present() || known->id != hello.participant) return;
    if (!known->leaving) publish_notice(kLeft, name);
    known->leaving = known->required;
    if (!known->required) known->standing = Participant::Standing::kAbsent;
    return;
  }
  switch (roster_.admit(hello)) {
    case Admission::kKnown:
      return;
    case Admission::kFirstStart:
      return publish_notice(kJoined, name);
    case Admission::kNewStart:
      desk_.drop(*known);  // what its earlier start had sent for later
      known->waiting_since_ns = clock_.get_ns();
      return publish_notice(kRejoined, name);
    case Admission::kNameTaken:
      return refuse(hello, Reject::kNameTaken, kSecondOfName);
    default:
      return refuse(hello, Reject::kUnknownParticipant, kNotAdmitted);
  }
}

// Each start of a participant is told about once; all are counted.
void Executive::refuse(const HelloAck& hello, Reject reason, std::string_view notice) noexcept {
  desk_.refuse(reason);
  publish_verdict(reason, hello.participant, hello.sequence, -1, -1);
  if (refused_id_ == hello.participant) return;
  refused_id_ = hello.participant;
  publish_notice(notice, get_name(hello.name));
}

void Executive::hear_command(const Command& command, std::int64_t arrived_ns) noexcept {
  Participant* const sender = command.session == options_.session ? roster_.find(command.participant) : nullptr;
  if (sender != nullptr) resume(*sender);
  heard_ns_ = arrived_ns;
  const bool in_time = options_.pace != Pace::kRealtime || arrived_ns <= cutoff_ns_ || !started_ns_;
  const std::int64_t tick = simulation_.get_tick();
  const auto [reason, applied_tick] = desk_.offer(command, sender, in_time ? tick : tick + 1);
  if (reason) publish_verdict(*reason, command.participant, command.sequence, command.channel, applied_tick);
}

// A lost participant that says something is back, and owes an answer from now on.
void Executive::resume(Participant& participant) noexcept {
  if (participant.standing != Participant::Standing::kLost) return;
  participant.standing = Participant::Standing::kPresent;
  participant.waiting_since_ns = clock_.get_ns();
  publish_notice(kResumed, participant.name);
}

void Executive::hear_ack(const StepAck& ack, std::int64_t arrived_ns) noexcept {
  if (ack.session != options_.session) return desk_.refuse(Reject::kWrongSession);
  Participant* const participant = roster_.find(ack.participant);
  if (participant == nullptr || participant->standing == Participant::Standing::kEvicted) {
    return desk_.refuse(Reject::kUnknownParticipant);
  }
  const bool sane =
      ack.tick >= 0 && ack.tick <= simulation_.get_tick() && ack.last_command >= 0 && ack.command_count >= 0;
  if (!sane) return desk_.refuse(Reject::kMalformed);
  resume(*participant);
  if (ack.tick < participant->ack.tick) return;
  if (ack.tick > participant->ack.tick) {
    participant->ack_arrived_ns = arrived_ns;
    participant->waiting_since_ns = clock_.get_ns();  // alive: what it still owes counts from now
  }
  participant->ack = ack;
}

// --- Acting ---------------------------------------------------------------------------------------------------------

Executive::Go Executive::lose(Participant& participant) noexcept {
  const auto policy = options_.flight_software.policy;
  char name[kNameLength] = {};
  kPolicyPrefix.copy(name, kPolicyPrefix.size());
  kPolicyNames[static_cast<std::size_t>(policy)].copy(name + kPolicyPrefix.size(),
                                                      sizeof name - kPolicyPrefix.size() - 1);
  publish_notice(name, participant.name);
  participant.standing = Participant::Standing::kLost;
  const bool left = std::exchange(participant.leaving, false);
  if (policy == FlightSoftware::Policy::kPause) return pause(participant);
  if (policy == FlightSoftware::Policy::kAbort) {
    end_message_ = "the flight software '" + participant.name + "' " + (left ? "has left" : "did not answer in time") +
                   " (policy: abort)";
    return Go::kStop;
  }
  if (policy == FlightSoftware::Policy::kEvict) participant.standing = Participant::Standing::kEvicted;
  desk_.drop(participant);
  apply_policy(participant);
  return Go::kStep;
}

// Concerns the channels that the lost participant has set, and those that nobody has.
void Executive::apply_policy(const Participant& participant) noexcept {
  const auto policy = options_.flight_software.policy;
  if (policy != FlightSoftware::Policy::kZero && policy != FlightSoftware::Policy::kSafe) return;
  const std::vector<Channel>& channels = simulation_.model().channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (commander_[i] != &participant && commander_[i] != nullptr) continue;
    const double zero = std::clamp(0.0, channels[i].minimum, channels[i].maximum);
    const double value = policy == FlightSoftware::Policy::kZero ? zero : channels[i].safe;
    set_channel(static_cast<std::int32_t>(i), value, ChangeCause::kPolicy, roster_.get_index(participant), 0);
  }
}

void Executive::apply_commands() noexcept {
  if (options_.faults != nullptr) tell_faults();
  desk_.take_due(simulation_.get_tick(), [this](const CommandDesk::Pending& pending) {
    const Command& command = pending.command;
    commander_[static_cast<std::size_t>(command.channel)] = pending.sender;
    applied_since_ns_ = heard_ns_;
    set_channel(command.channel, command.value, pending.late ? ChangeCause::kLateCommand : ChangeCause::kCommand,
                roster_.get_index(*pending.sender), command.sequence);
  });
}

void Executive::set_channel(std::int32_t channel, double value, ChangeCause cause, std::int32_t participant,
                            std::int64_t sequence) noexcept {
  const auto index = static_cast<std::size_t>(channel);
  double& now = simulation_.channels()[index];
  if (options_.faults != nullptr && cause != ChangeCause::kFault) {
    commanded_[index] = value;
    if (options_.faults->get_forced(index, now)) return;
  }
  if (now == value && std::signbit(now) == std::signbit(value)) return;
  now = value;
  recorder_.change({channel, cause, participant, sequence, value});
}

}  // namespace unlatch::hil
