// The commands of a session: checked on arrival, kept until the tick that they name, applied in an order that does not
// depend on how they arrived. Fixed memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hil/executive_roster.h"
#include "hil/messages.h"
#include "kernel/model.h"

namespace unlatch::hil {

class CommandDesk {
 public:
  // In lockstep a command for a past tick is refused; in real time it is late: applied at the next tick and counted.
  CommandDesk(std::span<const Channel> channels, std::int64_t session, bool accept_late);

  // Takes a command that arrived before the step of `tick`; counts it if it is refused. `sender`: null if unknown.
  void offer(const Command& command, Participant* sender, std::int64_t tick) noexcept;
  // Forgets what a participant has sent for later.
  void drop(std::int32_t participant) noexcept;
  // Passes each command that is due at `tick` to `apply`, by tick, then participant, then sequence.
  template <class Apply>
  void take_due(std::int64_t tick, Apply&& apply) noexcept {
    sort();
    std::size_t due = 0;
    for (; due < pending_.size() && pending_[due].tick <= tick; ++due) {
      if (is_expired(pending_[due], tick)) continue;
      if (pending_[due].tick < tick) ++late_;
      apply(pending_[due]);
    }
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(due));
  }

  [[nodiscard]] const std::array<std::int64_t, kRejectReasons>& get_rejected() const noexcept { return rejected_; }
  [[nodiscard]] std::int64_t get_late() const noexcept { return late_; }
  [[nodiscard]] std::int64_t get_dropped() const noexcept { return dropped_; }  // found no room

 private:
  static constexpr std::size_t kRoom = 4096;
  [[nodiscard]] std::optional<Reject> check(const Command& command, Participant* sender,
                                            std::int64_t tick) const noexcept;
  bool is_expired(const Command& command, std::int64_t tick) noexcept;
  void sort() noexcept;
  void refuse(Reject reason) noexcept { ++rejected_[static_cast<std::size_t>(reason)]; }

  const std::span<const Channel> channels_;
  const std::int64_t session_;
  const bool accept_late_;
  std::vector<Command> pending_;
  std::array<std::int64_t, kRejectReasons> rejected_{};
  std::int64_t late_ = 0, dropped_ = 0;
};

}  // namespace unlatch::hil
