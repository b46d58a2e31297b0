// Commands of a session: checked on arrival, kept until their tick, applied in an order that does not depend on the
// order of arrival. Each participant has places of its own; when they are taken, the command that is due last gives
// way, so that far-off commands never crowd out near ones. Fixed memory; a command costs the logarithm of those that
// wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "hil/session/messages/messages.h"
#include "hil/session/participants/command_pool.h"
#include "hil/session/participants/participants.h"
#include "hil/session/participants/reject_counts.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct CommandQueueOptions {
  std::int64_t session = 0;
  std::int64_t delay_ticks = 0;  // a command of tick k is due at k + delay_ticks
  bool accept_late = false;      // real time: a command that missed its tick acts at the next; else it is refused
  std::int64_t horizon_ticks = std::int64_t{1} << 53;  // a command due later than this from the present is refused
  std::size_t places = 4096;                           // places of each required participant
};

class CommandQueue {
 public:
  struct Pending {
    CommandMessage command;
    const Participant* sender = nullptr;
    std::int64_t due_tick = 0;  // tick before whose step it acts
    bool late = false;          // acts later than it was due
  };
  // Result of add(). No reason: accepted. kLate: accepted, acts at `applied_tick`. Any other: refused.
  struct Outcome {
    std::optional<Reject> reason;
    std::int64_t applied_tick = -1;
    bool repeated = false;  // known, and its State was sent again: no refusal
    // Command removed to free a place: an earlier one of the same participant, refused as kNoPlace.
    std::optional<CommandMessage> displaced = {};
  };

  // Places of a required participant over those of a guest.
  static constexpr std::size_t kGuestShare = 16;

  // `channels`, `participants` and `rejects` must outlive the queue.
  CommandQueue(std::span<const Channel> channels, const CommandQueueOptions& options, const Participants& participants,
               RejectCounts& rejects);

  // Adds a command that can act at `earliest_tick` at the earliest; counts it if it is refused or late. `sender`: null
  // if unknown.
  Outcome add(const CommandMessage& command, Participant* sender, std::int64_t earliest_tick) noexcept;
  // Repetitions of commands of `tick` are no duplicates from now on: its State was sent again. Nor are those of the
  // latest such tick before it, whose last repetitions may arrive behind the step.
  void expect_repeats(std::int64_t tick) noexcept {
    if (tick != repeated_tick_) repeated_before_ = std::exchange(repeated_tick_, tick);
  }
  // Removes all commands of a participant.
  void remove(const Participant& sender) noexcept;
  // Removes the commands that are due at `tick` and passes each to `apply`, ordered by the tick named, then the
  // participant's name, then the sequence number.
  template <class Apply>
  void take_due(std::int64_t tick, Apply&& apply) noexcept {
    while (Waiting* const first = find_first_due(tick)) {
      const Pending pending = *first->begin();
      first->erase(first->begin());
      apply(pending);
    }
  }

  [[nodiscard]] std::int64_t get_late() const noexcept { return late_; }
  // Commands that wait for a tick after this one.
  [[nodiscard]] std::int64_t count_after(std::int64_t tick) const noexcept;

 private:
  static constexpr std::int64_t kLastTick = std::int64_t{1} << 53;  // a tick beyond it is taken as malformed
  struct IsSooner {
    bool operator()(const Pending& a, const Pending& b) const noexcept;
  };
  using Waiting = std::pmr::set<Pending, IsSooner>;

  [[nodiscard]] std::optional<Reject> check(const CommandMessage& command, std::int64_t acts_at, std::int64_t due,
                                            std::int64_t earliest_tick) const noexcept;
  [[nodiscard]] Waiting* find_first_due(std::int64_t tick) noexcept;
  [[nodiscard]] std::size_t get_places(const Participant& sender) const noexcept;

  const std::span<const Channel> channels_;
  const CommandQueueOptions options_;
  const Participants& participants_;
  RejectCounts& rejects_;
  CommandPool pool_;
  std::vector<Waiting> waiting_;  // one for each participant, by index
  std::int64_t late_ = 0;
  std::int64_t repeated_tick_ = -1, repeated_before_ = -1;  // -1: none
};

}  // namespace unlatch::hil
