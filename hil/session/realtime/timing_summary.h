// Timing of a run: distributions, overruns and their causes, counts. Kept in a recording's last record.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "hil/session/messages/bytes.h"
#include "hil/session/messages/messages.h"

namespace unlatch::hil {

// Histogram in a few numbers, ns, and its buckets that are not empty.
struct DurationSummary {
  struct Bin {
    std::int64_t upper_ns = 0, count = 0;  // durations up to and including upper_ns, above the bin before
  };
  std::int64_t count = 0, min = 0, p50 = 0, p90 = 0, p99 = 0, p999 = 0, p9999 = 0, p99999 = 0, max = 0;
  std::vector<Bin> bins;
};

// Cause of an overrun: the largest part of the tick's time; see attribute() in hil/session/realtime/executive_timing.h.
enum class OverrunCause : std::int32_t {
  kBacklog = 0,  // late begin: the tick before ended late
  kLateWakeup,   // late begin: the operating system woke the thread late
  kInputs,       // messages received, commands applied
  kStep,         // the kernel's step
  kEvents,       // the kernel's step, split by events
  kOutputs,      // states and events published
  kPageFaults,   // inputs, step, events or outputs, with pages read meanwhile
  kPreempted,    // inputs, step, events or outputs, with the CPU lost to another thread meanwhile
  kWarmUp,       // late begin: its warm-up step was still going on
};
inline constexpr std::size_t kOverrunCauses = 9;
inline constexpr std::array<std::string_view, kOverrunCauses> kOverrunCauseNames{
    "backlog", "late_wakeup", "inputs", "step", "events", "outputs", "page_faults", "preempted", "rehearsal"};

// Reason for a late begin of a tick, other than the operating system.
enum class HeldUpBy : std::int32_t { kNothing = 0, kTickBefore, kWarmUp };

// Account of one tick, ns.
struct TickTiming {
  std::int64_t tick = 0;
  std::int64_t wakeup_ns = 0;  // due to begun; backlog included
  std::int64_t input_ns = 0;   // messages received and commands applied
  std::int64_t step_ns = 0;    // the kernel's step
  std::int64_t output_ns = 0;  // hash, states and events published
  std::int32_t substeps = 0;   // integrations of the step, 1 without events
  HeldUpBy held_up_by = HeldUpBy::kNothing;
};

struct Overrun {
  TickTiming timing;
  std::int64_t late_ns = 0;      // end of the tick, after the next was due
  std::int64_t page_faults = 0;  // count of the thread since the last overrun, two seconds ago at the earliest
  std::int64_t faults_read = 0;  // page faults with a page read from disk
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
  std::int64_t slipped_ns = 0;          // delay of the ticks by the policy `slip`
  std::int64_t skipped_outputs = 0;     // States left out by the policy `skip_output`
  std::int64_t late_commands = 0;       // commands applied a tick or more after the one they name
  std::int64_t late_answers = 0;        // States whose last answer came after the next State; in `round_trip` too
  std::int64_t unanswered = 0;          // States whose answer never came, while a later one was sent
  std::int64_t dropped = 0;             // messages that found a ring full
  std::int64_t resent = 0;              // State messages sent again
  std::int64_t unused_commands = 0;     // accepted for ticks after the end
  std::array<std::int64_t, kRejectReasons> rejected{};
};

// Each other's inverse; a summary that is not sane makes `from` incomplete.
void put(ByteWriter& to, const TimingSummary& timing);
void get(ByteReader& from, TimingSummary& timing);
// Empty if the number is no HeldUpBy.
[[nodiscard]] std::optional<HeldUpBy> to_held_up_by(std::int32_t number) noexcept;

}  // namespace unlatch::hil
