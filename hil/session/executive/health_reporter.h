// The account that a run gives of itself: Health once a second, Reactions ten times a second, and the counts in its
// last record. Fixed memory, except for summarize().
#pragma once

#include <cstdint>
#include <optional>

#include "hil/session/executive/publisher.h"
#include "hil/session/participants/command_queue.h"
#include "hil/session/participants/connection.h"
#include "hil/session/participants/liveness.h"
#include "hil/session/participants/participants.h"
#include "hil/session/participants/reject_counts.h"
#include "hil/session/realtime/executive_timing.h"

namespace unlatch::hil {

class HealthReporter {
 public:
  // Parts of a session that count; all must outlive the reporter.
  struct Sources {
    const Timing& timing;
    const Participants& participants;
    const CommandQueue& commands;
    const RejectCounts& rejects;
    const Connection& connection;
    const Liveness& liveness;
  };
  HealthReporter(const Sources& sources, Publisher& publisher) : sources_(sources), publisher_(publisher) {}

  // Starts the clock of the run.
  void begin_run(std::int64_t now_ns) noexcept { started_ns_ = health_ns_ = now_ns; }
  // Sends the messages that are due by now.
  void publish_due(std::int64_t now_ns) noexcept;
  void publish_health(std::int64_t now_ns) noexcept;
  void publish_reactions(std::int64_t now_ns) noexcept;

  // Timing of the run that ended at a tick, with all counts. Allocates.
  [[nodiscard]] TimingSummary summarize(std::int64_t tick) const;

 private:
  [[nodiscard]] std::int64_t calc_dropped() const noexcept;

  const Sources sources_;
  Publisher& publisher_;
  std::optional<std::int64_t> started_ns_;                // time of the first tick's State
  std::optional<std::int64_t> health_ns_, reactions_ns_;  // times of the latest
};

}  // namespace unlatch::hil
