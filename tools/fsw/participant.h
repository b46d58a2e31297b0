// The protocol's side of flight software: introduces itself, answers every State with commands and an acknowledgement,
// answers a State that is sent again exactly as before, and leaves when the session ends. docs:
// hil/PROTOCOL.md.
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "bridge/core/port.h"
#include "hil/session/participants/other_sessions.h"
#include "tools/fsw/control_law.h"
#include "tools/fsw/vehicle.h"

namespace unlatch::fsw {

class ParticipantClient {
 public:
  // `law`: what commands the channels; outlives this. `session`: takes part in the one of that number alone; 0: in the
  // first that it hears of.
  ParticipantClient(bridge::Port& port, ControlLaw& law, const std::string& name, std::int64_t session = 0);

  struct Outcome {
    bool done = false;        // a session came to its planned end
    std::string explanation;  // for people
  };
  // Takes part in one session. Gives up when nothing is heard of a simulator for `patience_s`, or when `stop` is set.
  // Throws what the control law throws.
  Outcome run(double patience_s, const std::atomic<bool>& stop);

 private:
  // False: it is none of ours.
  bool hear_hello(const hil::HelloMessage& hello);
  void tell_of_other(const hil::HelloMessage& hello);
  void hear_state(const hil::StateMessage& state);
  void hear_verdict(const hil::VerdictMessage& verdict);
  void send_missing(std::int64_t first, std::int64_t count);
  void answer_hello();
  void refuse(const std::string& reason);
  void say(hil::AckStatus status);
  void answer(const hil::StateMessage& state, bool again);
  [[nodiscard]] bool has_ended(const hil::StateMessage& state, Outcome& outcome) const;

  bridge::Port& port_;
  ControlLaw& law_;
  const std::string name_;
  const std::int32_t id_;
  const std::int64_t wanted_session_;

  Vehicle vehicle_;
  Commands commands_;
  std::int64_t session_ = 0;             // 0: none yet
  hil::HelloAckMessage agreed_;          // what this session was agreed on
  bool attached_ = false;                // to this session's vehicle
  std::string refusal_;                  // why not
  bool told_ = false;                    // that its name is taken
  hil::OtherSessions others_heard_;      // other simulators
  std::chrono::nanoseconds silence_{0};  // of our session, while we listened
  std::int64_t answered_tick_ = -1;
  std::int64_t last_command_ = 0;                     // sequence number
  std::vector<hil::CommandMessage> answer_commands_;  // to answered_tick_
};

}  // namespace unlatch::fsw
