// Names of the Event messages of the executive itself, in contrast to the model's events. The subject is the
// participant.
#pragma once

#include <string_view>

#include "hil/session/messages/messages.h"

namespace unlatch::hil {

inline constexpr std::string_view kJoined = "participant.joined";
inline constexpr std::string_view kLeft = "participant.left";
inline constexpr std::string_view kResumed = "participant.resumed";    // the same participant process answers again
inline constexpr std::string_view kRejoined = "participant.rejoined";  // a lost participant has restarted
inline constexpr std::string_view kSecondOfName = "participant.name_taken";  // refused: the name is in use
inline constexpr std::string_view kNotAdmitted = "participant.refused";      // another schema or model, or evicted
inline constexpr std::string_view kOtherSimulator = "simulator.other";       // another one sends; subject: its scenario
inline constexpr std::string_view kParticipantPrefix = "participant.";
inline constexpr std::string_view kFaultPrefix = "fault.";  // events of a fault script: fault.freeze, fault.freeze.end
inline constexpr std::string_view kMessageFaultPrefix = "fault.message.";  // too many for notices
inline constexpr std::string_view kPolicyPrefix = "policy.";  // followed by the policy's name, e.g. policy.hold
// In recordings alone, since participants get a Verdict: a message that was refused, followed by the reason, e.g.
// refused.past_tick, and a command that acts later than it should. The subject is its sender and its channel.
inline constexpr std::string_view kRefusedPrefix = "refused.";
inline constexpr std::string_view kLateCommandName = "command.late";
// Followed by the cause, e.g. overrun.late_wakeup; the subject has the parts of the tick's time. There may be many, so
// they are no notices.
inline constexpr std::string_view kOverrunPrefix = "overrun.";

[[nodiscard]] inline bool is_notice(const EventMessage& event) noexcept {
  const std::string_view name = get_name(event.name);
  if (name.starts_with(kFaultPrefix)) return !name.starts_with(kMessageFaultPrefix);
  return name == kOtherSimulator || name.starts_with(kParticipantPrefix) || name.starts_with(kPolicyPrefix);
}

// An event of the session, in contrast to one of the model: a notice, or one of which there may be many.
[[nodiscard]] inline bool is_of_session(const EventMessage& event) noexcept {
  const std::string_view name = get_name(event.name);
  return is_notice(event) || name.starts_with(kMessageFaultPrefix) || name.starts_with(kRefusedPrefix) ||
         name.starts_with(kOverrunPrefix) || name == kLateCommandName;
}

}  // namespace unlatch::hil
