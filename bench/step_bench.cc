// Full steps: forces, four stages, both projections, event checks, outputs. `step/<scenario>` is a whole run's mean;
// `step/<scenario>/<phase>` steps again and again from one state in the middle of a phase.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"

namespace unlatch::test {
namespace {

Simulation build_boosters() { return Simulation(build_soyuz(load_reference("soyuz_nominal"))); }
Simulation build_array() { return Simulation(build_solar(load_reference("solar_elastic"))); }

void repeat_step(benchmark::State& bench, Simulation simulation, int tick) {
  for (int i = 0; i < tick; ++i) (void)simulation.advance();
  const std::span<std::byte> state = simulation.state.get_bytes();
  const std::vector<std::byte> saved(state.begin(), state.end());
  for (auto _ : bench) {
    std::copy(saved.begin(), saved.end(), state.begin());
    benchmark::DoNotOptimize(simulation.advance());
  }
}

void run_whole(benchmark::State& bench, Simulation simulation, int ticks) {
  for (auto _ : bench) {
    if (simulation.state.header->tick >= ticks) init_state(simulation.plan, simulation.state);
    benchmark::DoNotOptimize(simulation.advance());
  }
}

// Reference events at 0.66581 (hinge → slider), 0.76905 (contact), 0.78879 s (slider → free).
BENCHMARK_CAPTURE(repeat_step, hinge, build_boosters(), 300)->Name("step/boosters/hinge");
BENCHMARK_CAPTURE(repeat_step, slider, build_boosters(), 700)->Name("step/boosters/slider");
BENCHMARK_CAPTURE(repeat_step, free, build_boosters(), 1000)->Name("step/boosters/free");
BENCHMARK_CAPTURE(repeat_step, event, build_boosters(), 665)->Name("step/boosters/event");
BENCHMARK_CAPTURE(run_whole, boosters, build_boosters(), 2000)->Name("step/boosters");
BENCHMARK_CAPTURE(repeat_step, drive, build_array(), 3000)->Name("step/array/drive");
BENCHMARK_CAPTURE(repeat_step, latched, build_array(), 9500)->Name("step/array/latched");
BENCHMARK_CAPTURE(run_whole, array, build_array(), 20000)->Name("step/array");

}  // namespace
}  // namespace unlatch::test
