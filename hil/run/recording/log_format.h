// Records of a recording, events in an LCM event log (hil/run/recording/log_file.h) whose time stamps are
// simulated microseconds:
//
//   UNLATCH_LOG_HEADER   once, first: everything to build the same simulation again, at the state where it began
//   UNLATCH_STATE        State messages, every few ticks, for LCM's tools and for people; a replay does not need them
//   UNLATCH_EVENT        Event messages: events of the model and of the session
//   UNLATCH_LOG_TICK     every tick: the state's hash before its step, and which channels changed before it. Written
//                        before the step, so a recording cut short ends with a tick whose inputs are known
//   UNLATCH_LOG_TIMING   every tick, if asked: account of its time (TickTiming); a replay does not need it
//   UNLATCH_LOG_END      once, last: the end of the run, and counts of losses
//
// So a replay is exact: apply the changes of tick k, compare the hash, step. The cause of a change (a command, or a
// policy such as hold, zero or safe) is in the record; wall time is in nothing that is compared.
//
// A checkpoint (hil/run/checkpoint.h) is one event in the same kind of file:
//
//   UNLATCH_LOG_CHECKPOINT   the header of a recording that begins there
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "hil/run/recording/log_file.h"
#include "hil/scenario/outputs.h"
#include "hil/session/messages/messages.h"
#include "hil/session/realtime/timing_summary.h"

namespace unlatch::hil {

inline constexpr std::int32_t kLogVersion = 7;
inline constexpr std::string_view kHeaderChannel = "UNLATCH_LOG_HEADER";
inline constexpr std::string_view kCheckpointChannel = "UNLATCH_LOG_CHECKPOINT";
inline constexpr std::string_view kTickChannel = "UNLATCH_LOG_TICK";
inline constexpr std::string_view kTimingChannel = "UNLATCH_LOG_TIMING";
inline constexpr std::string_view kEndChannel = "UNLATCH_LOG_END";

struct LogHeader {
  std::int32_t version = kLogVersion;
  Pace pace = Pace::kFast;
  std::int64_t session = 0;
  std::int64_t schema_hash = kSchemaHash;
  std::int64_t model_hash = 0;  // hash of everything in the scenario that decides a state, dt included
  std::int64_t first_tick = 0, last_tick = 0;
  double dt = 0;         // s
  std::string program;   // "unlatch 0.1.0"
  std::string compiler;  // "g++ 12.2.0"
  std::string scenario_name;
  std::string scenario_path;  // source of the text; for people
  std::string scenario_text;
  std::vector<std::string> overrides;  // PATH=VALUE, in order
  std::vector<std::uint64_t> start;    // Simulation::save() at first_tick; empty: the model's initial state
  bool begins_unresolved = false;      // the step had not resolved the run that led to `start`
  bool has_received = false;           // sensor values as flight software received them are recorded
};

// Sensors that outputs of a recording have.
inline SensorsShown get_sensors_shown(const LogHeader& header) {
  return header.has_received ? SensorsShown::kAlsoReceived : SensorsShown::kAsScenario;
}

enum class ChangeCause : std::int32_t { kCommand = 0, kPolicy = 1, kFault = 2, kLateCommand = 3 };
inline constexpr std::array<const char*, 4> kChangeCauseNames{"command", "policy", "fault", "late command"};

// Value of a channel from this tick on.
struct LogChange {
  std::int32_t channel = 0;
  ChangeCause cause = ChangeCause::kCommand;
  std::int32_t participant = 0;  // sender of the command, or subject of the policy: required ones from 0, then guests
  std::int64_t sequence = 0;     // number of the command
  double value = 0;
};

// Value of a sensor component that flight software had at a tick, where it is not the one that was sampled: a fault
// has distorted it, or its State was dropped or is delayed.
struct LogReceived {
  std::int32_t value = 0;  // number of the component, in the order of the model's sensors
  double received = 0;
};

struct LogTick {
  std::int64_t tick = 0;
  std::int64_t hash = 0;        // hash of the state at this tick
  std::int64_t unrecorded = 0;  // items lost so far, see LogEnd
  std::vector<LogChange> changes;
  std::vector<LogReceived> received;  // all others are as sampled
};

struct LogEnd {
  std::int64_t tick = 0;
  std::int64_t hash = 0;
  RunStatus status = RunStatus::kDone;
  std::int32_t step_status = 0;        // StepStatus of the failed step
  std::int32_t joint = -1;             // joint of the failure; -1: none
  std::int64_t unrecorded = 0;         // items that found the recorder's ring full: not 0, and there is no replay
  std::int64_t states_unrecorded = 0;  // State messages lost in the same way; a replay does not need them
  std::string message;                 // reason of an unplanned end, for people
  std::vector<LogReceived> received;   // at the end's tick, as in LogTick
  TimingSummary timing;
};

// Inverses of each other; decode is false, and its result worthless, for bytes that are not exactly one record.
void encode(const LogHeader& record, std::vector<std::uint8_t>& to);
void encode(const LogTick& record, std::vector<std::uint8_t>& to);
void encode(const TickTiming& record, std::vector<std::uint8_t>& to);
void encode(const LogEnd& record, std::vector<std::uint8_t>& to);
[[nodiscard]] bool decode(std::span<const std::uint8_t> from, LogHeader& record);
[[nodiscard]] bool decode(std::span<const std::uint8_t> from, LogTick& record);
[[nodiscard]] bool decode(std::span<const std::uint8_t> from, TickTiming& record);
[[nodiscard]] bool decode(std::span<const std::uint8_t> from, LogEnd& record);

// "g++ 12.2.0", of this build.
std::string get_compiler();

}  // namespace unlatch::hil
