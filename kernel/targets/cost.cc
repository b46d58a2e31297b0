// Steps every plan of plans.h for tools/cost, with the commands that were recorded for it; without any, with those that
// its channels have at the start, or next to nothing instead of 0, so that what they size is not left out. Prints
//   p NAME PRIMITIVE CALLS MOST     instructions of one call, where cost_primitives.cc is linked
//   s NAME COUNTS... STEPS MOST     instructions of one step that has done so much: integrations, rounds of events,
//                                   rounds in which events began to wait, and in which velocities may have jumped;
//                                   splits at known times
#include "kernel/targets/cost.h"

#include <algorithm>
#include <array>

#include "kernel/cost/step_counts.h"
#include "kernel/plan/plan_data.h"
#include "kernel/targets/plans.h"
#include "kernel/targets/port.h"
#include "kernel/targets/text_line.h"
#include "unlatch/plan_image.h"
#include "unlatch/step.h"

namespace unlatch::target {
namespace {

alignas(8) std::byte state_memory[UNLATCH_STATE_BYTES];
alignas(64) std::byte workspace_memory[UNLATCH_WORKSPACE_BYTES];
PlanMemory plan_memory;
constexpr std::uint64_t kMostInstructions =
    UNLATCH_COST_INSTRUCTIONS;  // of one plan: contacts may cut a step into hundreds of parts

using Counts = std::array<std::int64_t, 5>;  // as they are printed

// The largest step that has done so much.
struct Largest {
  Counts counts;
  std::uint64_t steps, most;
};
std::array<Largest, 1024> largest;
std::size_t largest_count;

void note_step(const Counts& counts, std::uint64_t instructions) {
  std::size_t i = 0;
  while (i < largest_count && largest[i].counts != counts) ++i;
  if (i == largest.size()) return;  // neither counted nor compared
  if (i == largest_count) largest[largest_count++] = {counts, 0, 0};
  ++largest[i].steps;
  largest[i].most = std::max(largest[i].most, instructions);
}

// Events as they were before a step.
std::array<EventState, 1024> events_before;
std::span<const EventState> keep_events(const State& state) {
  if (state.events.size() > events_before.size()) return {};
  std::copy(state.events.begin(), state.events.end(), events_before.begin());
  return std::span<const EventState>(events_before).first(state.events.size());
}

Counts count(const PlanData& plan, const StepReport& report, std::span<const EventState> before, const State& state) {
  const std::int64_t waits = cost::count_waits(plan, before, state.events, report.events);
  return {report.substeps, static_cast<std::int64_t>(report.audits.size()), waits,
          cost::count_jumps(plan, report.events), cost::count_timed(plan, report.events, waits)};
}

std::array<double, 1024> commands;
// Those of the start; returns their number.
std::size_t init_commands(const Plan& plan, bool recorded) {
  constexpr double kNextToNothing = 1e-9;
  const std::span<const double> initial = plan.get_initial_commands();
  const std::size_t count = std::min(initial.size(), commands.size());
  for (std::size_t i = 0; i < count; ++i) commands[i] = initial[i] == 0 && !recorded ? kNextToNothing : initial[i];
  return count;
}

void fly(const Flight& flight) {
  const OpenedPlan opened = open_plan({flight.begin, flight.end}, plan_memory);
  if (!opened.plan || opened.plan->get_state_bytes() > sizeof(state_memory) ||
      opened.plan->get_workspace_bytes() > sizeof(workspace_memory) ||
      get_data(*opened.plan).events.size() > events_before.size()) {
    TextLine() << "# " << flight.name << ": left out, " << (opened.plan ? "too large" : get_status_text(opened.status))
               << "\n";
    return;
  }
  const Plan& plan = *opened.plan;
  State state(plan, state_memory);
  Workspace workspace(plan, workspace_memory);
  init_state(plan, state);
  largest_count = 0;
  begin_primitives(get_data(plan));
  const std::size_t channels = init_commands(plan, flight.first_change != nullptr);
  const CommandChange* change = flight.first_change;
  std::uint64_t sum = 0;
  for (std::int32_t tick = 1; tick <= flight.ticks && sum * kInstructionUnit < kMostInstructions; ++tick) {
    for (; change != flight.end_change && change->tick < tick; ++change)
      if (at(change->channel) < channels) commands[at(change->channel)] = change->value;
    const std::span<const EventState> before = keep_events(state);
    const std::uint64_t begin = begin_step();
    const StepReport report = step(plan, {{commands.data(), channels}}, state, workspace);
    const std::uint64_t instructions = end_step(begin);
    sum += instructions;
    if (report.status != StepStatus::kOk) break;
    if (tick > 1)  // the first one begins without an evaluation of its state
      note_step(count(get_data(plan), report, before, state), instructions);
  }
  print_primitives(flight.name);
  for (std::size_t i = 0; i < largest_count; ++i) {
    TextLine line;
    line << "s " << flight.name;
    for (const std::int64_t own : largest[i].counts) line << " " << static_cast<std::uint64_t>(own);
    line << " " << largest[i].steps << " " << largest[i].most * kInstructionUnit << "\n";
  }
}

}  // namespace
}  // namespace unlatch::target

int main() {
  using namespace unlatch::target;
#if defined(__x86_64__)
  __builtin_cpu_init();  // before a plan chooses its instruction set; nothing runs constructors
#endif
  for (const Flight* flight = kFlights; flight->name != nullptr; ++flight) fly(*flight);
  write("end\n");  // an emulator that stops at a fault may not say so
  finish(0);
}
