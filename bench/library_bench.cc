// Benchmark library/step/<scenario>: a tick through the C library compared with the kernel's own step of the same
// state, in alternating blocks of some ticks, so that disturbances by the machine affect both. `overhead` is the median
// over all blocks of library / kernel − 1; the times are medians, ns for each tick. Both sides run one copy of the
// kernel's code: with two copies (one in the shared library) their addresses alone caused −1 to +3 %.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "hil/run/run.h"
#include "tests/support/simulation.h"
#include "unlatch.h"

namespace unlatch::bench {
namespace {

constexpr int kBlock = 40;    // ticks
constexpr int kWindow = 120;  // ticks after which the state is restored
constexpr const char* kFolder = UNLATCH_SOURCE_DIR "/hil/scenarios/";

double get_ns() {
  return static_cast<double>(std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
}

double calc_median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

void step_by_turns(benchmark::State& bench, const char* name, int first_tick) {
  const std::string path = std::string(kFolder) + name;
  const hil::Scenario scenario = hil::load_scenario(path);
  test::Simulation kernel(scenario.model, {.dt = scenario.dt});
  std::vector<double> commands;
  for (const Channel& channel : scenario.model.channels) commands.push_back(channel.initial);
  unlatch_simulation* library = nullptr;
  if (unlatch_load(path.c_str(), nullptr, &library) != UNLATCH_OK) {
    bench.SkipWithError(unlatch_get_error(0)->text);
    return;
  }
  const auto step_kernel = [&] {
    return unlatch::step(kernel.plan, Inputs{commands}, kernel.state, kernel.workspace).status == StepStatus::kOk;
  };
  bool good = unlatch_advance(library, static_cast<std::uint64_t>(first_tick), 0, nullptr) == UNLATCH_OK;
  for (int i = 0; i < first_tick; ++i) good &= step_kernel();
  const std::vector<std::byte> kernel_saved(kernel.state.get_bytes().begin(), kernel.state.get_bytes().end());
  std::size_t needed = 0;
  unlatch_save(library, nullptr, 0, &needed);
  std::vector<std::byte> library_saved(needed);
  good &= unlatch_save(library, library_saved.data(), needed, &needed) == UNLATCH_OK;

  std::vector<double> ratios, kernel_ns, library_ns;
  int tick = 0;
  for (auto _ : bench) {
    if (tick >= kWindow) {
      std::copy(kernel_saved.begin(), kernel_saved.end(), kernel.state.get_bytes().begin());
      good &= unlatch_restore(library, library_saved.data(), needed) == UNLATCH_OK;
      good &= step_kernel() && unlatch_step(library) == UNLATCH_OK;  // both have their final evaluation again
      tick = 1;
    }
    double times[2];
    for (const int which : {bench.iterations() % 2 == 0 ? 0 : 1, bench.iterations() % 2 == 0 ? 1 : 0}) {
      const double begin = get_ns();
      for (int i = 0; i < kBlock; ++i) good &= which == 0 ? step_kernel() : unlatch_step(library) == UNLATCH_OK;
      times[which] = (get_ns() - begin) / kBlock;
    }
    tick += kBlock;
    kernel_ns.push_back(times[0]);
    library_ns.push_back(times[1]);
    ratios.push_back(times[1] / times[0]);
  }
  std::uint64_t hash = 0;
  good &= unlatch_get_hash(library, &hash) == UNLATCH_OK && hash == calc_hash(kernel.state);
  if (!good) bench.SkipWithError("the library's steps are not the kernel's");
  unlatch_close(library);
  bench.counters["kernel_ns"] = calc_median(kernel_ns);
  bench.counters["library_ns"] = calc_median(library_ns);
  bench.counters["overhead"] = calc_median(ratios) - 1;
}

BENCHMARK_CAPTURE(step_by_turns, hinge, "boosters/reference.yaml", 300)->Name("library/step/boosters");
BENCHMARK_CAPTURE(step_by_turns, commanded, "boosters/scenario.yaml", 300)->Name("library/step/boosters_commanded");
BENCHMARK_CAPTURE(step_by_turns, array, "array/reference.yaml", 3000)->Name("library/step/array");
BENCHMARK_CAPTURE(step_by_turns, tree20, "tree20/reference.yaml", 100)->Name("library/step/tree20");

}  // namespace
}  // namespace unlatch::bench
