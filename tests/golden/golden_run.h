// Code shared by the golden programs: --lanes, and a run that prints hashes, one on each line, for tools/determinism to
// compare:
//   NAME TICK HASH       of the state, every 100 ticks and at the last one
//   NAME outputs HASH    of all sensor values and reactions of every tick
//   NAME events COUNT    how many acted
#pragma once

#include <bit>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/support/simulation.h"

namespace unlatch::test {

constexpr InstructionSet kEverySet[] = {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256,
                                        InstructionSet::k512};

// Reads `--lanes NAME` at the front of the arguments, and moves `first` behind it; kAuto without. `--list-lanes` prints
// all names with yes or no and ends the program; so does an unknown name, or one that this processor lacks.
inline InstructionSet read_instruction_set(int argc, char** argv, int& first) {
  const std::string_view option = argc > 1 ? argv[1] : "", wanted = argc > 2 ? argv[2] : "";
  first = 1;
  if (option == "--list-lanes") {
    for (const InstructionSet set : kEverySet) std::printf("%s %s\n", get_name(set), is_supported(set) ? "yes" : "no");
    std::exit(0);
  }
  if (option != "--lanes") return InstructionSet::kAuto;
  first = 3;
  for (const InstructionSet set : kEverySet) {
    if (wanted == get_name(set) && is_supported(set)) return set;
  }
  std::fprintf(stderr, "--lanes '%s': not here; --list-lanes says which are\n", argc > 2 ? argv[2] : "");
  std::exit(2);
}

// Prints the hashes of a run. `advance()`: a step's report. False, with the reason on standard error, if a step fails.
template <class Advance>
bool print_golden_hashes(const char* name, const Advance& advance, const State& state, const Workspace& workspace,
                         std::int64_t ticks) {
  constexpr std::int64_t kEvery = 100;
  std::uint64_t outputs = 0xcbf29ce484222325u;  // FNV-1a over 64-bit words, folded
  std::size_t events = 0;
  const auto add_outputs = [&outputs](const auto& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      outputs = (outputs ^ std::bit_cast<std::uint64_t>(double{values[i]})) * 0x100000001b3u;
      outputs ^= outputs >> 32;
    }
  };
  for (std::int64_t tick = 1; tick <= ticks; ++tick) {
    const StepReport report = advance();
    if (report.status != StepStatus::kOk) {
      std::fprintf(stderr, "%s: tick %" PRId64 ": %s\n", name, tick, get_status_text(report.status));
      return false;
    }
    events += report.events.size();
    add_outputs(workspace.sensors);
    add_outputs(workspace.multipliers);
    if (tick % kEvery == 0 || tick == ticks) {
      std::printf("%s %" PRId64 " %016" PRIx64 "\n", name, tick, calc_hash(state));
    }
  }
  std::printf("%s outputs %016" PRIx64 "\n%s events %zu\n", name, outputs, name, events);
  return true;
}
inline bool print_golden_hashes(const char* name, const Model& model, double dt, std::int64_t ticks,
                                InstructionSet set) {
  PlanOptions options;
  options.dt = dt;
  options.instruction_set = set;
  Simulation simulation(model, options);
  return print_golden_hashes(
      name, [&] { return simulation.advance(); }, simulation.state, simulation.workspace, ticks);
}

}  // namespace unlatch::test
