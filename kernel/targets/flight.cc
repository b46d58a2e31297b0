// Flies every plan of plans.h with the commands that its channels have at the start, and prints, for tools/determinism
// to compare with tests/data/golden.json,
//   NAME TICK HASH       of the state, every 100 ticks and at the last one
//   NAME outputs HASH    of all sensor values and reactions of every tick
// and the memory and instructions that it took. No heap: state, workspace and plan are static.
#include <bit>
#include <cstring>

#include "kernel/targets/plans.h"
#include "kernel/targets/port.h"
#include "kernel/targets/text_line.h"
#include "unlatch/plan_image.h"
#include "unlatch/step.h"

namespace unlatch::target {
namespace {

constexpr std::int32_t kEvery = 100;  // ticks between hashes
constexpr std::byte kPaint{0xA5};     // of stack that nothing has used

alignas(8) std::byte state_memory[UNLATCH_STATE_BYTES];  // both from CMakeLists.txt
alignas(64) std::byte workspace_memory[UNLATCH_WORKSPACE_BYTES];
PlanMemory plan_memory;

// FNV-1a over 64-bit words, folded: as in tests/golden.
class OutputHash {
 public:
  template <class Values>
  void add(const Values& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      hash_ = (hash_ ^ std::bit_cast<std::uint64_t>(double{values[i]})) * 0x100000001b3u;
      hash_ ^= hash_ >> 32;
    }
  }
  std::uint64_t get() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

void paint_stack() {
  volatile std::byte here{};
  // Below this function's own frame.
  for (std::byte* at = target_stack_begin; at + 256 < &here; ++at) *const_cast<volatile std::byte*>(at) = kPaint;
}
std::size_t measure_stack() {
  const std::byte* at = target_stack_begin;
  while (at < target_stack_end && *at == kPaint) ++at;
  return static_cast<std::size_t>(target_stack_end - at);
}

bool fly(const Flight& flight) {
  const std::span image(flight.begin, flight.end);
  const OpenedPlan opened = open_plan(image, plan_memory);
  if (!opened.plan) {
    TextLine() << flight.name << ": " << get_status_text(opened.status) << "\n";
    return false;
  }
  const Plan& plan = *opened.plan;
  if (plan.get_state_bytes() > sizeof(state_memory) || plan.get_workspace_bytes() > sizeof(workspace_memory)) {
    TextLine() << flight.name << ": needs " << plan.get_state_bytes() << " bytes of state and "
               << plan.get_workspace_bytes() << " of workspace\n";
    return false;
  }
  State state(plan, state_memory);
  Workspace workspace(plan, workspace_memory);
  init_state(plan, state);
  const Inputs inputs{plan.get_initial_commands()};
  OutputHash outputs;
  std::uint64_t sum = 0, most = 0, events = 0;
  for (std::int32_t tick = 1; tick <= flight.ticks; ++tick) {
    const std::uint64_t begin = read_counter();
    const StepReport report = step(plan, inputs, state, workspace);
    const std::uint64_t count = read_counter() - begin;
    if (report.status != StepStatus::kOk) {
      TextLine() << flight.name << ": tick " << static_cast<std::uint64_t>(tick) << ": "
                 << get_status_text(report.status) << "\n";
      return false;
    }
    sum += count;
    if (count > most) most = count;
    events += report.events.size();
    outputs.add(workspace.sensors);
    outputs.add(workspace.multipliers);
    if (tick % kEvery == 0 || tick == flight.ticks)
      (TextLine() << flight.name << " " << static_cast<std::uint64_t>(tick) << " ").add_hash(calc_hash(state)) << "\n";
  }
  (TextLine() << flight.name << " outputs ").add_hash(outputs.get()) << "\n";
  TextLine() << flight.name << " events " << events << "\n";
  TextLine() << "# " << flight.name << ": image " << std::uint64_t{image.size()} << " bytes, state "
             << std::uint64_t{plan.get_state_bytes()} << ", workspace " << std::uint64_t{plan.get_workspace_bytes()}
             << "\n";
  if (most != 0)
    TextLine() << "# " << flight.name << ": instructions per step "
               << sum * kInstructionUnit / std::uint64_t(flight.ticks) << " on average, at most "
               << most * kInstructionUnit << "\n";
  return true;
}

}  // namespace
}  // namespace unlatch::target

int main() {
  using namespace unlatch::target;
  paint_stack();
  bool good = true;
  for (const Flight* flight = kFlights; flight->name != nullptr; ++flight) good = fly(*flight) && good;
  TextLine() << "# stack " << std::uint64_t{measure_stack()} << " bytes\n";
  finish(good ? 0 : 1);
}
