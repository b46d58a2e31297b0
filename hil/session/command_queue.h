// The commands of a session: checked on arrival, kept until the tick that they are due, applied in an order that does
// not depend on how they arrived. Fixed memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hil/messages/messages.h"
#include "hil/session/roster.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct DeskOptions {
  std::int64_t session = 0;
  std::int64_t delay_ticks = 0;  // a command that names tick k is due at k + delay_ticks
  bool accept_late = false;      // real time: a command that missed its tick acts at the next; else it is refused
};

class CommandDesk {
 public:
  struct Pending {
    Command command;
    const Participant* sender = nullptr;
    std::int64_t due = 0;  // tick before whose step it acts
    bool late = false;     // later than it was due
  };
  // What became of a command: nothing to say, or a reason; kLate is accepted, to act at `applied_tick`.
  struct Outcome {
    std::optional<Reject> reason;
    std::int64_t applied_tick = -1;
  };

  CommandDesk(std::span<const Channel> channels, const DeskOptions& options);

  // Takes a command whose earliest tick is `earliest`; counts it if it is refused or late. `sender`: null if unknown.
  Outcome offer(const Command& command, Participant* sender, std::int64_t earliest) noexcept;
  // Counts something else that was refused.
  void refuse(Reject reason, std::int64_t count = 1) noexcept { rejected_[static_cast<std::size_t>(reason)] += count; }
  // Forgets what a participant has sent for later.
  void drop(const Participant& sender) noexcept;
  // Passes each command that is due at `tick` to `apply`, by the tick named, then participant's name, then sequence.
  template <class Apply>
  void take_due(std::int64_t tick, Apply&& apply) noexcept {
    sort();
    for (const Pending& pending : pending_) {
      if (pending.due <= tick) apply(pending);
    }
    std::erase_if(pending_, [tick](const Pending& pending) { return pending.due <= tick; });
  }

  [[nodiscard]] const std::array<std::int64_t, kRejectReasons>& get_rejected() const noexcept { return rejected_; }
  [[nodiscard]] std::int64_t get_late() const noexcept { return late_; }
  [[nodiscard]] std::int64_t get_dropped() const noexcept { return dropped_; }  // found no room

 private:
  static constexpr std::size_t kRoom = 4096;
  static constexpr std::int64_t kLastTick = std::int64_t{1} << 53;  // beyond it nobody means what he says
  [[nodiscard]] std::optional<Reject> check(const Command& command, std::int64_t acts_at,
                                            std::int64_t due) const noexcept;
  void sort() noexcept;

  const std::span<const Channel> channels_;
  const DeskOptions options_;
  std::vector<Pending> pending_;
  std::array<std::int64_t, kRejectReasons> rejected_{};
  std::int64_t late_ = 0, dropped_ = 0;
};

}  // namespace unlatch::hil
