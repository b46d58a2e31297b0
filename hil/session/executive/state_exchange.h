// The exchange of a tick: the State goes out, and every required participant answers it. Without an answer the State is
// sent again, and commands that were announced and have not arrived are asked for. Fixed memory.
#pragma once

#include <cstdint>

#include "hil/run/simulation/simulation.h"
#include "hil/session/executive/publisher.h"
#include "hil/session/participants/command_queue.h"
#include "hil/session/participants/liveness.h"
#include "hil/session/participants/participants.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/histogram.h"

namespace unlatch::hil {

class StateExchange {
 public:
  // `round_trip` takes the time from each State to its last answer, ns. All must outlive it.
  StateExchange(const Simulation& simulation, const Clock& clock, Participants& participants, Liveness& liveness,
                CommandQueue& commands, Publisher& publisher, Histogram& round_trip)
      : simulation_(simulation),
        clock_(clock),
        participants_(participants),
        liveness_(liveness),
        commands_(commands),
        publisher_(publisher),
        round_trip_(round_trip) {}

  // Sends the State of the simulation's tick for the first time: from now on each participant owes an answer.
  void publish(RunStatus status, std::int64_t hash) noexcept;
  // Sends the State once more. Asks for nothing.
  void resend(RunStatus status) noexcept;
  // Sends the State once more, to participants without an answer; asks them for the commands that are missing.
  void repeat(RunStatus status) noexcept;

  // True when all required participants that take part have answered.
  [[nodiscard]] bool is_answered(std::int64_t now_ns) noexcept;
  // Takes the round trips of States whose answers came after the next State. Call after each answer.
  void record_late_answers() noexcept;
  // The later of `sent_ns` and the time of the latest news from a participant that has not answered yet.
  [[nodiscard]] std::int64_t get_quiet_since_ns(std::int64_t sent_ns) const noexcept;

 private:
  void ask_for_missing_commands(std::int64_t tick) noexcept;

  const Simulation& simulation_;
  const Clock& clock_;
  Participants& participants_;
  Liveness& liveness_;
  CommandQueue& commands_;
  Publisher& publisher_;
  Histogram& round_trip_;
};

}  // namespace unlatch::hil
