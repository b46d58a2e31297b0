// Fault injection script, read from a YAML file: kinds, ticks and numbers of deliberate faults. The language is
// described in hil/scenarios/FAULTS.md.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "hil/scenario/scenario.h"
#include "hil/session/messages/messages.h"

namespace unlatch::hil {

struct Fault {
  enum class Kind {
    // Messages.
    kDrop,
    kDelay,
    kDuplicate,
    kReorder,
    kCorrupt,
    // Participants.
    kFreeze,
    kKill,
    // Sensor values, as published in State.
    kStick,
    kBias,
    // Actuators: command channels.
    kDead,
    kJam,
  };
  Kind kind = Kind::kDrop;
  std::int64_t first_tick = 0;
  std::int64_t last_tick = std::numeric_limits<std::int64_t>::max();  // inclusive
  double probability = 1;                                             // probability of each message
  std::int64_t count = std::numeric_limits<std::int64_t>::max();      // largest number of messages
  MessageKind message = MessageKind::kState;
  std::string participant;  // freeze, kill; messages: the sender; empty: any
  std::vector<int> values;  // sensor values, by their index in the catalog
  int channel = -1;
  std::int64_t delay_ticks = 0;  // delay
  std::int64_t time_ns = 0;      // wall time: delay; limit of a freeze, 0 for none
  int copies = 1;                // duplicate: additional copies
  int bits = 1;                  // corrupt: flipped bits
  double offset = 0;             // bias, in the sensor's unit
  std::string subject;           // text for people: "Command fsw", "gyro.x", "nozzle1"

  [[nodiscard]] bool is_of_messages() const { return kind <= Kind::kCorrupt; }
  [[nodiscard]] bool is_at(std::int64_t tick) const { return tick >= first_tick && tick <= last_tick; }
};
extern const std::vector<std::string> kFaultNames;  // "drop" …, in the order of Fault::Kind

struct FaultScript {
  std::uint64_t seed = 0;
  std::vector<Fault> faults;
};

// Loaders; they throw ScenarioError with every mistake and its place. Names are those of the scenario.
FaultScript load_faults(const std::string& path, const Scenario& scenario);
FaultScript load_faults_text(const std::string& text, const std::string& file, const Scenario& scenario);

}  // namespace unlatch::hil
