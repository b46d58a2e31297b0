// Refused messages, counted by reason.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hil/session/messages/messages.h"

namespace unlatch::hil {

struct RejectCounts {
  std::array<std::int64_t, kRejectReasons> by_reason{};

  void add(Reject reason, std::int64_t count = 1) noexcept { by_reason[static_cast<std::size_t>(reason)] += count; }
};

}  // namespace unlatch::hil
