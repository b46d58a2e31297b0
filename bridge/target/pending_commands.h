// Commands of the one participant that wait for their tick: checked, ordered by tick and sequence, each once. The rules
// are those of hil/session/participants/command_queue.h for a session in lockstep, in memory of a fixed size: a command
// that finds no place is refused, and there is no horizon.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "bridge/target/session_image.h"
#include "hil/session/participants/seen_commands.h"

namespace unlatch::target {

class PendingCommands {
 public:
  static constexpr std::size_t kPlaces = 1024, kMostChannels = 256;

  // False: the session has more channels than there are places.
  bool open(const SessionImage& image);
  // A new start of the participant: what the last one sent is forgotten.
  void restart();

  // `tick`: the state's. UNLATCH_REJECT_… if the command is refused; `repeated` instead if it arrived before, for this
  // tick or the last.
  struct Outcome {
    std::optional<std::int32_t> reason;
    bool repeated = false;
  };
  Outcome add(const unlatch_wire_command& command, std::int64_t tick);
  // The next command that acts at the step of `tick`; null: there is none. It is taken away by the next call.
  const unlatch_wire_command* take_due(std::int64_t tick);

  [[nodiscard]] const hil::SeenCommands& get_seen() const { return seen_; }

 private:
  struct Range {
    double least = 0, most = 0;
  };
  [[nodiscard]] std::optional<std::int32_t> check(const unlatch_wire_command& command, std::int64_t tick) const;

  Range ranges_[kMostChannels]{};
  std::size_t channels_ = 0;
  std::int64_t delay_ = 0;                   // ticks
  unlatch_wire_command waiting_[kPlaces]{};  // the latest first
  std::size_t count_ = 0;
  unlatch_wire_command due_{};
  hil::SeenCommands seen_;
};

}  // namespace unlatch::target
