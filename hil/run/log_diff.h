// Compares two recordings of one model: the first tick whose states differ, in which fields and by how much, and the
// inputs of the step that led there. The states are found by replaying; if this program's bits differ from a
// recording's own (written by another build), the State messages recorded next are compared.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/recording/replay_reader.h"
#include "hil/run/simulation/simulation.h"
#include "hil/run/simulation/state_fields.h"

namespace unlatch::hil {

using Two = std::array<double, 2>;  // one value of each recording

// Values of a channel during one step.
struct InputDifference {
  std::int64_t tick = 0;  // first tick of the step
  std::int32_t channel = 0;
  Two values{};
};

struct StateDifference {
  std::int64_t tick = 0;  // first tick whose hashes differ
  std::array<std::int64_t, 2> hashes{};
  std::int64_t fields_tick = -1;        // tick at which `fields` differ: `tick`, or a later one; -1: unknown
  std::vector<FieldDifference> fields;  // in the order of the state
  std::vector<Two> channels;            // values of all channels during the step to `tick`; empty: no such step
  std::array<std::vector<LogChange>, 2> changes{};  // changes of channels just before that step
};

// Place up to which one recording was read, and its last record.
struct LogEnding {
  std::int64_t tick = 0;
  std::optional<RunStatus> status;  // status of its last record, if it was read
  std::string message;              // reason of the end, or of the missing last record
  bool damaged = false;
  std::int64_t unreproduced = -1;  // first tick at which this program's bits differ from the recording's; -1: none
};

struct LogDiff {
  std::int64_t first_tick = 0;           // first common tick
  std::int64_t compared = 0;             // ticks
  std::optional<StateDifference> state;  // the first difference
  std::optional<InputDifference> input;  // the first difference, of a step before `state`
  std::array<LogEnding, 2> endings{};

  [[nodiscard]] bool is_damaged() const { return endings[0].damaged || endings[1].damaged; }
  [[nodiscard]] bool agrees() const {
    return !state && !input && endings[0].tick == endings[1].tick && endings[0].status == endings[1].status;
  }
};

// Compares recordings. Both simulations must be at the states where their recordings begin. Throws LogError for
// recordings of different models, without a common tick, or with losses. `look`, if given, is called with each compared
// tick.
LogDiff diff(std::array<RecordingReader*, 2> recordings, std::array<Simulation*, 2> simulations,
             const std::function<void(std::int64_t)>& look = {});

}  // namespace unlatch::hil
