// Timing of a run: distributions, overruns and their causes, counts. Kept in a recording's last record.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "hil/messages/bytes.h"
#include "hil/messages/messages.h"

namespace unlatch::hil {

// A histogram in a few numbers, ns, and its buckets that are not empty.
struct DurationSummary {
  struct Bin {
    std::int64_t upper_ns = 0, count = 0;  // durations up to and including upper_ns, above the bin before
  };
  std::int64_t count = 0, min = 0, p50 = 0, p90 = 0, p99 = 0, p999 = 0, p9999 = 0, p99999 = 0, max = 0;
  std::vector<Bin> bins;
};

// The cause of an overrun: the largest part of the tick's time; see attribute() in hil/realtime/executive_timing.h.
enum class OverrunCause : std::int32_t {
  kBacklog = 0,  // it began late because the tick before ended late
  kLateWakeup,   // the operating system woke the thread late
  kInputs,       // taking in messages
  kStep,         // the kernel's step
  kEvents,       // the same, and the step was split by events
  kOutputs,      // handing out states and events
  kPageFaults,   // any of the last four, and pages had to be read meanwhile
  kPreempted,    // any of them, and the thread lost its CPU to another meanwhile
  kWarmUp,       // it began late because its warm-up step was still going on
};
inline constexpr std::size_t kOverrunCauses = 9;
inline constexpr std::array<std::string_view, kOverrunCauses> kOverrunCauseNames{
    "backlog", "late_wakeup", "inputs", "step", "events", "outputs", "page_faults", "preempted", "rehearsal"};

// The reason why a tick began late, if it was not the operating system.
enum class HeldUpBy : std::int32_t { kNothing = 0, kTickBefore, kWarmUp };

// One tick's account, ns.
struct TickTiming {
  std::int64_t tick = 0;
  std::int64_t wakeup_ns = 0;  // from when it was due until it began; backlog included
  std::int64_t input_ns = 0;   // then: messages received and commands applied
  std::int64_t step_ns = 0;    // the kernel's step
  std::int64_t output_ns = 0;  // hash, states and events published
  std::int32_t substeps = 0;   // integrations of the step, 1 without events
  HeldUpBy held_up_by = HeldUpBy::kNothing;
};

struct Overrun {
  TickTiming timing;
  std::int64_t late_ns = 0;      // its end after the next tick was due
  std::int64_t page_faults = 0;  // of the thread, since the last overrun, two seconds ago at the earliest
  std::int64_t faults_read = 0;  // of these, with a page read from disk
  std::int64_t preemptions = 0;  // involuntary context switches, in the same time
  OverrunCause cause = OverrunCause::kStep;
};

struct TimingSummary {
  static constexpr std::size_t kWorst = 16;
  DurationSummary step, wakeup;
  DurationSummary turnaround;  // a command's arrival to the State of the step that it went into
  DurationSummary round_trip;  // State handed to the bridge to the last answer delivered by it
  std::int64_t overruns = 0;   // ticks whose work ended after the next was due; real time only
  std::array<std::int64_t, kOverrunCauses> overrun_causes{};
  std::vector<Overrun> worst_overruns;  // the kWorst latest, the worst first
  std::int64_t slipped_ns = 0;          // by which the policy `slip` has put off the ticks
  std::int64_t skipped_outputs = 0;     // States that the policy `skip_output` has left out
  std::int64_t late_commands = 0;       // applied a tick or more after the one they name
  std::int64_t dropped = 0;             // messages that found a ring full
  std::int64_t resent = 0;              // State messages sent again
  std::array<std::int64_t, kRejectReasons> rejected{};
};

// Each other's inverse; a summary that is not sane makes `from` incomplete.
void put(ByteWriter& to, const TimingSummary& timing);
void get(ByteReader& from, TimingSummary& timing);
// None if it is no HeldUpBy.
[[nodiscard]] std::optional<HeldUpBy> to_held_up_by(std::int32_t number) noexcept;

}  // namespace unlatch::hil
