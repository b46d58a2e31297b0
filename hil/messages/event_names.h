// Names of the Event messages that the executive itself sends, unlike the model's events. The subject is the
// participant.
#pragma once

#include <string_view>

#include "hil/messages/messages.h"

namespace unlatch::hil {

inline constexpr std::string_view kJoined = "participant.joined";
inline constexpr std::string_view kLeft = "participant.left";
inline constexpr std::string_view kResumed = "participant.resumed";          // the same start answers again
inline constexpr std::string_view kRejoined = "participant.rejoined";        // a new start of one that was lost
inline constexpr std::string_view kSecondOfName = "participant.name_taken";  // refused: one of that name takes part
inline constexpr std::string_view kNotAdmitted = "participant.refused";      // another schema or model, or evicted
inline constexpr std::string_view kOtherSimulator = "simulator.other";  // another is heard; the subject is its scenario
inline constexpr std::string_view kParticipantPrefix = "participant.";
inline constexpr std::string_view kFaultPrefix = "fault.";  // of a fault script: fault.freeze, fault.freeze.end
inline constexpr std::string_view kMessageFaultPrefix = "fault.message.";  // too many for notices
inline constexpr std::string_view kPolicyPrefix = "policy.";               // and the policy's name, e.g. policy.hold
// And the cause, e.g. overrun.late_wakeup; the subject has the parts of the tick's time. There may be many: they are no
// notices.
inline constexpr std::string_view kOverrunPrefix = "overrun.";

[[nodiscard]] inline bool is_notice(const EventMessage& event) noexcept {
  const std::string_view name = get_name(event.name);
  if (name.starts_with(kFaultPrefix)) return !name.starts_with(kMessageFaultPrefix);
  return name == kOtherSimulator || name.starts_with(kParticipantPrefix) || name.starts_with(kPolicyPrefix);
}

}  // namespace unlatch::hil
