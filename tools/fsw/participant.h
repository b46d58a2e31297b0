// The protocol's side of flight software: introduces itself, answers every State with commands and an acknowledgement,
// answers a State that is sent again exactly as before, and leaves when the session ends. docs:
// hil/PROTOCOL.md.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "bridge/port.h"
#include "tools/fsw/separation_sequence.h"
#include "tools/fsw/vehicle.h"

namespace unlatch::fsw {

class ParticipantClient {
 public:
  ParticipantClient(bridge::Port& port, const std::string& name);

  struct Outcome {
    bool done = false;        // a session came to its planned end
    std::string explanation;  // for people
  };
  // Takes part in one session. Gives up when nothing is heard of a simulator for `patience_s`, or when `stop` is set.
  Outcome run(double patience_s, const std::atomic<bool>& stop);

 private:
  void hear_hello(const hil::HelloMessage& hello);
  void hear_state(const hil::StateMessage& state);
  void hear_verdict(const hil::VerdictMessage& verdict);
  void answer_hello();
  void refuse(const std::string& reason);
  void say(hil::AckStatus status);
  void answer(const hil::StateMessage& state);
  [[nodiscard]] bool has_ended(const hil::StateMessage& state, Outcome& outcome) const;

  bridge::Port& port_;
  const std::string name_;
  const std::int32_t id_;

  Vehicle vehicle_;
  SeparationSequence sequence_;
  Commands commands_;
  std::int64_t session_ = 0;     // 0: none yet
  hil::HelloAckMessage agreed_;  // what this session was agreed on
  bool attached_ = false;        // to this session's vehicle
  std::string refusal_;          // why not
  bool told_ = false;            // that its name is taken
  std::int64_t answered_tick_ = -1;
  std::int64_t last_command_ = 0;                     // sequence number
  std::vector<hil::CommandMessage> answer_commands_;  // to answered_tick_
};

}  // namespace unlatch::fsw
