// Compares two recordings of one model: the first tick whose states differ, in which fields and by how much, and what
// the step that led there had as inputs on either side. The states are found by replaying; where this program gives
// other bits than a recording's own (another build wrote it), the State messages recorded next are compared.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hil/recording/replay_reader.h"
#include "hil/simulation/simulation.h"
#include "hil/simulation/state_fields.h"

namespace unlatch::hil {

using Two = std::array<double, 2>;  // of one recording, of the other

// A channel's values during one step.
struct InputDifference {
  std::int64_t tick = 0;  // of the step from this tick to the next
  std::int32_t channel = 0;
  Two values{};
};

struct StateDifference {
  std::int64_t tick = 0;  // the first at which the hashes differ
  std::array<std::int64_t, 2> hashes{};
  std::int64_t fields_tick = -1;        // at which `fields` differ: `tick`, or a later one; -1: not known
  std::vector<FieldDifference> fields;  // in the state's order
  std::vector<Two> channels;            // every channel's value during the step to `tick`; empty: none was made
  std::array<std::vector<LogChange>, 2> changes{};  // what set them, just before that step
};

// The place up to which one recording was read, and its last record.
struct LogEnding {
  std::int64_t tick = 0;
  std::optional<RunStatus> status;  // of its last record, if it was read
  std::string message;              // why it ended so, or why it has no last record
  bool damaged = false;
  std::int64_t unreproduced = -1;  // first tick at which this program gives other bits than the recording; -1: none
};

struct LogDiff {
  std::int64_t first_tick = 0;           // that both have
  std::int64_t compared = 0;             // ticks
  std::optional<StateDifference> state;  // the first
  std::optional<InputDifference> input;  // the first, of a step before `state`
  std::array<LogEnding, 2> endings{};

  [[nodiscard]] bool is_damaged() const { return endings[0].damaged || endings[1].damaged; }
  [[nodiscard]] bool agrees() const {
    return !state && !input && endings[0].tick == endings[1].tick && endings[0].status == endings[1].status;
  }
};

// Both simulations must be at the states where their recordings begin. Throws LogError: recordings of different models,
// with no tick in common, or with losses. `look`, if given, is called with each tick that is compared.
LogDiff diff(std::array<RecordingReader*, 2> recordings, std::array<Simulation*, 2> simulations,
             const std::function<void(std::int64_t)>& look = {});

}  // namespace unlatch::hil
