// A session with flight software: who takes part, what they have sent, and what is sent to them. The session owns these
// parts and takes in the messages; the executive owns the cycle. Refused messages are counted and answered with a
// Verdict. Only the constructor allocates.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hil/run/recording/recorder.h"
#include "hil/run/simulation/simulation.h"
#include "hil/session/executive/executive_options.h"
#include "hil/session/executive/heartbeat.h"
#include "hil/session/executive/publisher.h"
#include "hil/session/executive/state_exchange.h"
#include "hil/session/faults/faulty_connection.h"
#include "hil/session/messages/messages.h"
#include "hil/session/participants/announcer.h"
#include "hil/session/participants/command_queue.h"
#include "hil/session/participants/connection.h"
#include "hil/session/participants/handshake.h"
#include "hil/session/participants/liveness.h"
#include "hil/session/participants/other_sessions.h"
#include "hil/session/participants/participants.h"
#include "hil/session/participants/reject_counts.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/histogram.h"
#include "hil/session/realtime/nonblocking.h"

namespace unlatch::hil {

class Session {
 public:
  // `scenario`: its name, for participants. `round_trip` takes the time from each State to its last answer, ns. All
  // but the name and the options must outlive the session.
  Session(const Simulation& simulation, Connection& connection, Recorder& recorder, const std::string& scenario,
          const ExecutiveOptions& options, Heartbeat& heartbeat, Histogram& round_trip);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

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
  [[nodiscard]] bool is_number_taken() const noexcept { return other_.session != 0 && other_.session == number_; }

  // The parts of the session.
  [[nodiscard]] const Clock& clock() const noexcept { return clock_; }
  [[nodiscard]] Connection& connection() noexcept { return connection_; }
  [[nodiscard]] Participants& participants() noexcept { return participants_; }
  [[nodiscard]] const RejectCounts& rejects() const noexcept { return rejects_; }
  [[nodiscard]] Announcer& announcer() noexcept { return announcer_; }
  [[nodiscard]] Handshake& handshake() noexcept { return handshake_; }
  [[nodiscard]] Liveness& liveness() noexcept { return liveness_; }
  [[nodiscard]] CommandQueue& commands() noexcept { return commands_; }
  [[nodiscard]] Publisher& publisher() noexcept { return publisher_; }
  [[nodiscard]] StateExchange& exchange() noexcept { return exchange_; }

 private:
  void handle(const HelloAckMessage& answer, std::int64_t arrived_ns) noexcept;
  void handle(const CommandMessage& command, std::int64_t arrived_ns) noexcept;
  void handle(const StepAckMessage& ack, std::int64_t arrived_ns) noexcept;
  void handle(const HelloMessage& other, std::int64_t arrived_ns) noexcept;
  void count_malformed() noexcept;

  const Simulation& simulation_;
  const Clock& clock_;
  Heartbeat& heartbeat_;
  const std::int64_t number_;
  Participants participants_;
  RejectCounts rejects_;
  std::unique_ptr<FaultyConnection> faulty_connection_;
  Connection& connection_;  // the faulty one, if there is a fault script
  Announcer announcer_;
  Handshake handshake_;
  Liveness liveness_;
  CommandQueue commands_;
  Publisher publisher_;
  StateExchange exchange_;

  Arrival arrival_;  // scratch
  std::optional<std::int64_t> cutoff_ns_;
  std::optional<std::int64_t> command_ns_;
  std::int64_t malformed_ = 0;  // malformed messages of the connection, already counted
  HelloMessage other_;
  OtherSessions reported_others_;
};

}  // namespace unlatch::hil
