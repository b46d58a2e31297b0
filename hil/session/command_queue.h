// The commands of a session: checked on arrival, kept until their tick, applied in an order that does not depend on the
// order of arrival. Fixed memory.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hil/messages/messages.h"
#include "hil/session/participants.h"
#include "hil/session/reject_counts.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct CommandQueueOptions {
  std::int64_t session = 0;
  std::int64_t delay_ticks = 0;  // a command that names tick k is due at k + delay_ticks
  bool accept_late = false;      // real time: a command that missed its tick acts at the next; else it is refused
};

class CommandQueue {
 public:
  struct Pending {
    CommandMessage command;
    const Participant* sender = nullptr;
    std::int64_t due_tick = 0;  // acts before the step of this tick
    bool late = false;          // later than it was due
  };
  // No reason: accepted. kLate: accepted, acts at `applied_tick`. Any other: refused.
  struct Outcome {
    std::optional<Reject> reason;
    std::int64_t applied_tick = -1;
  };

  // `channels` and `rejects` must outlive the queue.
  CommandQueue(std::span<const Channel> channels, const CommandQueueOptions& options, RejectCounts& rejects);

  // Adds a command that can act at `earliest_tick` at the earliest; counts it if it is refused or late. `sender`: null
  // if unknown.
  Outcome add(const CommandMessage& command, Participant* sender, std::int64_t earliest_tick) noexcept;
  // Removes all commands of a participant.
  void remove(const Participant& sender) noexcept;
  // Removes the commands that are due at `tick` and passes each to `apply`, ordered by the tick named, then the
  // participant's name, then the sequence number.
  template <class Apply>
  void take_due(std::int64_t tick, Apply&& apply) noexcept {
    sort();
    for (const Pending& pending : pending_) {
      if (pending.due_tick <= tick) apply(pending);
    }
    std::erase_if(pending_, [tick](const Pending& pending) { return pending.due_tick <= tick; });
  }

  [[nodiscard]] std::int64_t get_late() const noexcept { return late_; }
  [[nodiscard]] std::int64_t get_dropped() const noexcept { return dropped_; }  // because the queue was full

 private:
  static constexpr std::size_t kCapacity = 4096;
  static constexpr std::int64_t kLastTick = std::int64_t{1} << 53;  // a tick beyond it is taken as malformed
  [[nodiscard]] std::optional<Reject> check(const CommandMessage& command, std::int64_t acts_at,
                                            std::int64_t due) const noexcept;
  void sort() noexcept;

  const std::span<const Channel> channels_;
  const CommandQueueOptions options_;
  RejectCounts& rejects_;
  std::vector<Pending> pending_;
  std::int64_t late_ = 0, dropped_ = 0;
};

}  // namespace unlatch::hil
