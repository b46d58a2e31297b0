// Faults on purpose: what a test engineer wants to go wrong, when, and how often, read from a YAML file. The language
// is described in hil/scenarios/FAULTS.md.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "hil/messages/messages.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct Fault {
  enum class Kind {
    kDrop,
    kDelay,
    kDuplicate,
    kReorder,
    kCorrupt,  // of messages
    kFreeze,
    kKill,  // of a participant
    kStick,
    kBias,  // of a sensor value, as published in State
    kDead,
    kJam,  // of an actuator, a command channel
  };
  Kind kind = Kind::kDrop;
  std::int64_t first_tick = 0;
  std::int64_t last_tick = std::numeric_limits<std::int64_t>::max();  // inclusive
  double probability = 1;                                             // of each message
  std::int64_t count = std::numeric_limits<std::int64_t>::max();      // messages at most
  MessageKind message = MessageKind::kState;
  std::string participant;  // freeze, kill; of messages: the sender; empty: any
  std::vector<int> values;  // sensor values, by their index in the catalog
  int channel = -1;
  std::int64_t delay_ticks = 0;  // delay
  std::int64_t time_ns = 0;      // of wall time: delay; freeze, at most, 0 for no limit
  int copies = 1;                // duplicate: beyond the one
  int bits = 1;                  // corrupt: flipped
  double offset = 0;             // bias, in the sensor's unit
  std::string subject;           // for people: "Command fsw", "gyro.x", "nozzle1"

  [[nodiscard]] bool is_of_messages() const { return kind <= Kind::kCorrupt; }
  [[nodiscard]] bool is_at(std::int64_t tick) const { return tick >= first_tick && tick <= last_tick; }
};
extern const std::vector<std::string> kFaultNames;  // "drop" …, in the order of Fault::Kind

struct FaultScript {
  std::uint64_t seed = 0;
  std::vector<Fault> faults;
};

// Both throw ScenarioError with every mistake and its place. Names are those of the scenario.
FaultScript load_faults(const std::string& path, const Scenario& scenario);
FaultScript load_faults_text(const std::string& text, const std::string& file, const Scenario& scenario);

}  // namespace unlatch::hil
