#include "hil/session/participants/handshake.h"

namespace unlatch::hil {

std::string_view Handshake::find_mismatch(const HelloAckMessage& answer) const noexcept {
  if (answer.protocol != hello_.protocol) return "it uses another version of the protocol";
  if (answer.schema_hash != hello_.schema_hash) return "it was built for another version of the message schema";
  if (answer.model_hash != hello_.model_hash) return "it expects another model";
  if (answer.dt_ns != hello_.dt_ns) return "it expects another step size";
  return {};
}

Handshake::Outcome Handshake::refuse(const HelloAckMessage& answer, Reject reason, std::string_view notice) noexcept {
  const bool first = refused_id_ != answer.participant;
  refused_id_ = answer.participant;
  return {.reject = reason, .verdict = true, .notice = first ? notice : std::string_view{}};
}

Handshake::Outcome Handshake::receive(const HelloAckMessage& answer, std::int64_t now_ns) noexcept {
  if (answer.session != hello_.session) return {.reject = Reject::kWrongSession};
  const std::string_view name = get_name(answer.name);
  Participant* const known = participants_.find(name);
  const auto status = static_cast<AckStatus>(answer.status);
  const std::string_view mismatch = find_mismatch(answer);
  if (!mismatch.empty() || status == AckStatus::kRefused) {
    const std::string_view reason = status == AckStatus::kRefused ? get_name(answer.reason) : mismatch;
    if (!begun_ && known != nullptr && known->required) {
      refusal_ = "the flight software '" + std::string(name) + "' does not take part: " + std::string(reason);
    }
    return mismatch.empty() ? Outcome{} : refuse(answer, Reject::kMismatch, kNotAdmitted);
  }
  if (status == AckStatus::kLeaving) {
    if (known == nullptr || !known->is_present() || known->id != answer.participant) return {};
    const bool first = !known->leaving;
    known->leaving = known->required;
    if (!known->required) known->standing = Participant::Standing::kAbsent;
    return {.notice = first ? kLeft : std::string_view{}};
  }
  switch (participants_.admit(answer)) {
    case Admission::kKnown:
      return {};
    case Admission::kFirstStart:
      return {.notice = kJoined};
    case Admission::kNewStart:
      known->waiting_since_ns = now_ns;
      return {.notice = kRejoined, .restarted = known};
    case Admission::kNameTaken:
      return refuse(answer, Reject::kNameTaken, kSecondOfName);
    default:
      return refuse(answer, Reject::kUnknownParticipant, kNotAdmitted);
  }
}

}  // namespace unlatch::hil
