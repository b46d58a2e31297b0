// Messages from participants: each goes to the part of the session that it is for; refused ones are counted and
// answered with a Verdict. Fixed memory.
#pragma once

#include <cstdint>
#include <optional>

#include "hil/run/simulation/simulation.h"
#include "hil/session/executive/heartbeat.h"
#include "hil/session/executive/publisher.h"
#include "hil/session/messages/messages.h"
#include "hil/session/participants/command_queue.h"
#include "hil/session/participants/connection.h"
#include "hil/session/participants/handshake.h"
#include "hil/session/participants/liveness.h"
#include "hil/session/participants/other_sessions.h"
#include "hil/session/participants/participants.h"
#include "hil/session/participants/reject_counts.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/nonblocking.h"

namespace unlatch::hil {

class Reception {
 public:
  // Parts of the session; all must outlive the reception.
  struct Parts {
    Connection& connection;
    const Simulation& simulation;
    const Clock& clock;
    Participants& participants;
    Handshake& handshake;
    Liveness& liveness;
    CommandQueue& commands;
    RejectCounts& rejects;
    Publisher& publisher;
    Heartbeat& heartbeat;
    std::int64_t session;
  };

  explicit Reception(const Parts& parts) : parts_(parts) {}

  // Takes in the messages that have arrived, a bounded number of them. Without a cut-off it may wait.
  void receive() noexcept UNLATCH_NONBLOCKING;
  // Commands that arrive later are for the next tick: real time. Before the first call, and at other paces, every
  // command is in time.
  void set_cutoff(std::int64_t cutoff_ns) noexcept { cutoff_ns_ = cutoff_ns; }
  // Readmits the participant if it was lost.
  void resume(Participant& participant) noexcept;

  // Arrival of the latest command.
  [[nodiscard]] std::optional<std::int64_t> get_command_ns() const noexcept { return command_ns_; }
  // Latest Hello of another simulator, or the first of one with our session number; session 0: none yet.
  [[nodiscard]] const HelloMessage& get_other() const noexcept { return other_; }
  // Another simulator has our session number.
  [[nodiscard]] bool has_namesake() const noexcept { return other_.session != 0 && other_.session == parts_.session; }

 private:
  void handle(const HelloAckMessage& answer, std::int64_t arrived_ns) noexcept;
  void handle(const CommandMessage& command, std::int64_t arrived_ns) noexcept;
  void handle(const StepAckMessage& ack, std::int64_t arrived_ns) noexcept;
  void handle(const HelloMessage& other, std::int64_t arrived_ns) noexcept;
  void count_malformed() noexcept;

  const Parts parts_;
  Arrival arrival_;  // scratch
  std::optional<std::int64_t> cutoff_ns_;
  std::optional<std::int64_t> command_ns_;
  std::int64_t malformed_ = 0;  // malformed messages of the connection, already counted
  HelloMessage other_;
  OtherSessions told_of_;
};

}  // namespace unlatch::hil
