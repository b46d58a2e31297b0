// Steps every plan of plans.h for tools/cost, with the commands that its channels have at the start, or next to nothing
// instead of 0, so that what they size is not left out, and prints
//   p NAME PRIMITIVE CALLS MOST         instructions of one call, where cost_primitives.cc is linked
//   s NAME SUBSTEPS ROUNDS STEPS MOST   instructions of one step with so many integrations and rounds of events
#include "kernel/targets/cost.h"

#include <array>

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

// The largest step with so many integrations and rounds.
struct Largest {
  std::int32_t substeps, rounds;
  std::uint64_t steps, most;
};
std::array<Largest, 256> largest;
std::size_t largest_count;

void note_step(const StepReport& report, std::uint64_t instructions) {
  const auto rounds = static_cast<std::int32_t>(report.audits.size());
  std::size_t i = 0;
  while (i < largest_count && (largest[i].substeps != report.substeps || largest[i].rounds != rounds)) ++i;
  if (i == largest.size()) i = largest.size() - 1;  // never above what is compared: it keeps its own counts
  if (i == largest_count) largest[largest_count++] = {report.substeps, rounds, 0, 0};
  if (largest[i].substeps != report.substeps || largest[i].rounds != rounds) return;
  ++largest[i].steps;
  if (instructions > largest[i].most) largest[i].most = instructions;
}

std::array<double, 1024> commands;
// Returns their number.
std::size_t set_commands(const Plan& plan) {
  constexpr double kNextToNothing = 1e-9;
  const std::span<const double> initial = plan.get_initial_commands();
  const std::size_t count = initial.size() < commands.size() ? initial.size() : commands.size();
  for (std::size_t i = 0; i < count; ++i) commands[i] = initial[i] == 0 ? kNextToNothing : initial[i];
  return count;
}

void fly(const Flight& flight) {
  const OpenedPlan opened = open_plan({flight.begin, flight.end}, plan_memory);
  if (!opened.plan || opened.plan->get_state_bytes() > sizeof(state_memory) ||
      opened.plan->get_workspace_bytes() > sizeof(workspace_memory)) {
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
  const std::size_t count = set_commands(plan);
  std::uint64_t sum = 0;
  for (std::int32_t tick = 1; tick <= flight.ticks && sum * kInstructionUnit < kMostInstructions; ++tick) {
    const std::uint64_t begin = begin_step();
    const StepReport report = step(plan, {{commands.data(), count}}, state, workspace);
    const std::uint64_t count = end_step(begin);
    sum += count;
    if (report.status != StepStatus::kOk) break;
    if (tick > 1) note_step(report, count);  // the first one begins without an evaluation of its state
  }
  print_primitives(flight.name);
  for (std::size_t i = 0; i < largest_count; ++i)
    TextLine() << "s " << flight.name << " " << static_cast<std::uint64_t>(largest[i].substeps) << " "
               << static_cast<std::uint64_t>(largest[i].rounds) << " " << largest[i].steps << " "
               << largest[i].most * kInstructionUnit << "\n";
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
