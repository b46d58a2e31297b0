// Names of the Event messages that the executive itself sends, as against the model's events. The subject is the
// participant.
#pragma once

#include <string_view>

#include "hil/messages.h"

namespace unlatch::hil {

inline constexpr std::string_view kJoined = "participant.joined";
inline constexpr std::string_view kResumed = "participant.resumed";
inline constexpr std::string_view kPolicyPrefix = "policy.";  // and the policy's name, e.g. policy.hold
// And the cause, e.g. overrun.late_wakeup; the subject says where the time went. There may be many: they are no notices.
inline constexpr std::string_view kOverrunPrefix = "overrun.";

[[nodiscard]] inline bool is_notice(const Event& event) noexcept {
  const std::string_view name = get_name(event.name);
  return name == kJoined || name == kResumed || name.starts_with(kPolicyPrefix);
}

}  // namespace unlatch::hil
