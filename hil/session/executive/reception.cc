#include "hil/session/executive/reception.h"

#include "hil/session/messages/event_names.h"

namespace unlatch::hil {
namespace {

constexpr int kMaxArrivals = 512;  // limit of one call of receive(): bounds the work of a tick

}  // namespace

void Reception::receive() noexcept {
  const MayWait without_deadlines(!cutoff_ns_);
  parts_.heartbeat.beat(RunPlace::kReceiving);
  for (int i = 0; i < kMaxArrivals && parts_.connection.receive(arrival_); ++i) {
    std::visit([this](const auto& message) { handle(message, arrival_.arrived_ns); }, arrival_.message);
  }
  count_malformed();
}

void Reception::count_malformed() noexcept {
  const std::int64_t malformed = parts_.connection.get_malformed();
  if (malformed != malformed_) parts_.rejects.add(Reject::kMalformed, malformed - malformed_);
  malformed_ = malformed;
}

void Reception::handle(const HelloAckMessage& answer, std::int64_t) noexcept {
  const Handshake::Outcome outcome = parts_.handshake.receive(answer, parts_.clock.get_ns());
  if (outcome.reject) parts_.rejects.add(*outcome.reject);
  if (outcome.verdict) parts_.publisher.publish_verdict(*outcome.reject, answer.participant, answer.sequence, -1, -1);
  if (outcome.restarted != nullptr) parts_.commands.remove(*outcome.restarted);
  if (!outcome.notice.empty()) parts_.publisher.publish_notice(outcome.notice, get_name(answer.name));
}

void Reception::handle(const CommandMessage& command, std::int64_t arrived_ns) noexcept {
  Participant* const sender =
      command.session == parts_.session ? parts_.participants.find(command.participant) : nullptr;
  if (sender != nullptr) resume(*sender);
  command_ns_ = arrived_ns;
  const bool in_time = !cutoff_ns_ || arrived_ns <= *cutoff_ns_;
  const std::int64_t tick = parts_.simulation.get_tick();
  const CommandQueue::Outcome outcome = parts_.commands.add(command, sender, in_time ? tick : tick + 1);
  if (outcome.repeated) return;
  if (outcome.reason) {
    parts_.publisher.publish_verdict(*outcome.reason, command.participant, command.sequence, command.channel,
                                     outcome.applied_tick);
  }
  if (outcome.displaced) {
    parts_.publisher.publish_verdict(Reject::kNoPlace, command.participant, outcome.displaced->sequence,
                                     outcome.displaced->channel, -1);
  }
  const bool is_known = outcome.reason == Reject::kDuplicate || outcome.reason == Reject::kJump;
  if (sender != nullptr && !is_known) sender->news_ns = arrived_ns;
}

void Reception::handle(const StepAckMessage& ack, std::int64_t arrived_ns) noexcept {
  if (ack.session != parts_.session) return parts_.rejects.add(Reject::kWrongSession);
  Participant* const sender = parts_.participants.find(ack.participant);
  if (sender == nullptr || sender->standing == Participant::Standing::kEvicted) {
    return parts_.rejects.add(Reject::kUnknownParticipant);
  }
  const bool sane = ack.tick >= 0 && ack.tick <= parts_.simulation.get_tick() && ack.last_command >= 0 &&
                    ack.command_count >= 0 && ack.command_count <= SeenCommands::kWindow;
  if (!sane) return parts_.rejects.add(Reject::kMalformed);
  resume(*sender);
  parts_.liveness.receive(ack, *sender, arrived_ns, parts_.clock.get_ns());
}

// A connection never gives back our own Hello. One simulator with our session number counts more than any other.
void Reception::handle(const HelloMessage& other, std::int64_t) noexcept {
  const bool is_over = other.status >= static_cast<std::int32_t>(RunStatus::kDone);
  if (other.session == 0 || is_over) return;
  if (!has_namesake()) other_ = other;
  if (told_of_.is_news(other.session)) parts_.publisher.publish_notice(kOtherSimulator, get_name(other.scenario));
}

void Reception::resume(Participant& participant) noexcept {
  if (!parts_.liveness.resume(participant, parts_.clock.get_ns())) return;
  parts_.publisher.publish_notice(kResumed, participant.name);
}

}  // namespace unlatch::hil
