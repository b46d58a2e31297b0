// Full steps: forces, four stages, both projections, event checks, outputs. `step/<scenario>` is a whole run's mean;
// `step/<scenario>/<phase>` some ticks in the middle of a phase, repeated; `…_bare` without loads, guards and outputs,
// `…_cold` with caches that other programs have used; `step/random/<n>` the first step of a random tree of n bodies on
// joints of every kind.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <vector>

#include "bench/least.h"
#include "bench/panel_array.h"
#include "bench/solve_model.h"
#include "tests/support/contact_models.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"

namespace unlatch::test {
namespace {

constexpr int kWindow = 80;  // ticks

Simulation build_boosters() { return Simulation(build_soyuz(load_reference("soyuz_nominal"))); }
// Builds the boosters with a command for every thrust, so that each step begins by solving for its forces again.
Simulation build_throttled_boosters() {
  Model model = build_soyuz(load_reference("soyuz_nominal"));
  model.channels.push_back({.name = "throttle", .initial = 1});
  for (Load& load : model.loads) load.channel = 0;
  return Simulation(model);
}
Simulation build_array() { return Simulation(build_solar(load_reference("solar_elastic"))); }

void step_or_skip(benchmark::State& bench, Simulation& simulation) {
  const StepReport report = simulation.advance();
  benchmark::DoNotOptimize(report);
  if (report.status != StepStatus::kOk) bench.SkipWithError(get_status_text(report.status));
}

// Repeats `window` ticks from `tick` on.
void repeat_steps(benchmark::State& bench, Simulation simulation, int tick, int window) {
  for (int i = 0; i < tick; ++i) (void)simulation.advance();
  const std::span<std::byte> state = simulation.state.get_bytes();
  const std::vector<std::byte> saved(state.begin(), state.end());
  for (auto _ : bench) {
    if (simulation.state.header->tick >= tick + window) std::copy(saved.begin(), saved.end(), state.begin());
    step_or_skip(bench, simulation);
  }
}

void run_whole(benchmark::State& bench, Simulation simulation, int ticks) {
  for (auto _ : bench) {
    if (simulation.state.header->tick >= ticks) init_state(simulation.plan, simulation.state);
    step_or_skip(bench, simulation);
  }
}

// Repeats four stages, both projections and the evaluation of the end, for the bodies and joints alone in the modes of
// `tick`: without loads, springs, guards, events and outputs.
void repeat_bare_steps(benchmark::State& bench, const Model& model, int tick) {
  Simulation full(model);
  for (int i = 0; i < tick; ++i) (void)full.advance();
  Model skeleton;
  skeleton.bodies = model.bodies;
  skeleton.joints = model.joints;
  skeleton.gravity = model.gravity;
  Simulation bare(skeleton);
  std::copy(full.state.bodies.begin(), full.state.bodies.end(), bare.state.bodies.begin());
  std::copy(full.state.joints.begin(), full.state.joints.end(), bare.state.joints.begin());
  const Inputs inputs{bare.commands};
  const double h = bare.plan.get_options().dt;
  int steps = kWindow;
  for (auto _ : bench) {
    int node = steps < kWindow ? kNone : evaluate_state(bare);
    steps = steps < kWindow ? steps + 1 : 1;
    const SubstepStart start =
        begin_substep({bare.data(), inputs, bare.state, 0}, Contacts::kExplicit, bare.evaluation());
    if (node == kNone) node = integrate({bare.data(), inputs, bare.state, 0}, start, h, bare.evaluation());
    if (node == kNone) node = evaluate({bare.data(), inputs, bare.state, h}, Changed::kVelocities, bare.evaluation());
    if (node != kNone) bench.SkipWithError("a pivot vanished");
  }
}

// Makes one step at a time, after reading memory of twice the second-level cache's size, as other programs do while the
// thread rests.
void repeat_cold_steps(benchmark::State& bench, Simulation simulation, int tick) {
  using Clock = std::chrono::steady_clock;
  for (int i = 0; i < tick; ++i) (void)simulation.advance();
  const std::span<std::byte> state = simulation.state.get_bytes();
  const std::vector<std::byte> saved(state.begin(), state.end());
  const std::vector<long> others((2 << 20) / sizeof(long), 1);
  for (auto _ : bench) {
    if (simulation.state.header->tick >= tick + kWindow) std::copy(saved.begin(), saved.end(), state.begin());
    benchmark::DoNotOptimize(std::accumulate(others.begin(), others.end(), 0L));
    const Clock::time_point begin = Clock::now();
    step_or_skip(bench, simulation);
    bench.SetIterationTime(std::chrono::duration<double>(Clock::now() - begin).count());
  }
}

// Reference events at 0.66581 (hinge → slider), 0.76905 (contact), 0.78879 s (slider → free).
BENCHMARK_CAPTURE(repeat_steps, hinge, build_boosters(), 300, kWindow)
    ->Name("step/boosters/hinge")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_steps, slider, build_boosters(), 680, kWindow)
    ->Name("step/boosters/slider")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_steps, free, build_boosters(), 1000, kWindow)
    ->Name("step/boosters/free")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_steps, throttled, build_throttled_boosters(), 300, kWindow)
    ->Name("step/boosters/hinge_throttled")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_steps, event, build_boosters(), 665, 1)->Name("step/boosters/event")->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_cold_steps, hinge, build_boosters(), 300)
    ->Name("step/boosters/hinge_cold")
    ->Apply(bench::keep_least)
    ->UseManualTime();
BENCHMARK_CAPTURE(repeat_bare_steps, hinge, build_soyuz(load_reference("soyuz_nominal")), 300)
    ->Name("step/boosters/hinge_bare")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_bare_steps, slider, build_soyuz(load_reference("soyuz_nominal")), 680)
    ->Name("step/boosters/slider_bare")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_bare_steps, free, build_soyuz(load_reference("soyuz_nominal")), 1000)
    ->Name("step/boosters/free_bare")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(run_whole, boosters, build_boosters(), 2000)->Name("step/boosters")->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_steps, drive, build_array(), 3000, kWindow)
    ->Name("step/array/drive")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_steps, latched, build_array(), 9500, kWindow)
    ->Name("step/array/latched")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(run_whole, array, build_array(), 20000)->Name("step/array")->Apply(bench::keep_least);

// Builds sixteen pairs of shapes of which four are closed, and the same with the step cut into four parts; 1 kHz, so
// that 50 µs are 5 % of the period.
Simulation build_pairs(int parts) {
  Model model = build_sixteen_pairs();
  model.contact_substeps = parts;
  return Simulation(model);
}
BENCHMARK_CAPTURE(repeat_steps, pairs, build_pairs(1), 1, kWindow)->Name("step/contacts/16")->Apply(bench::keep_least);
BENCHMARK_CAPTURE(repeat_steps, pairs_in_parts, build_pairs(4), 1, kWindow)
    ->Name("step/contacts/16/substeps4")
    ->Apply(bench::keep_least);

// 64 panels unfold on springs, a guard at each hinge that closes its elastic latch.
BENCHMARK_CAPTURE(repeat_steps, drive, Simulation(bench::build_panel_array(64)), 100, kWindow)
    ->Name("step/array64/drive")
    ->Apply(bench::keep_least);
BENCHMARK_CAPTURE(run_whole, array64, Simulation(bench::build_panel_array(64)), 10000)
    ->Name("step/array64")
    ->Apply(bench::keep_least);

void repeat_random(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  repeat_steps(state, Simulation(bench::build_solve_model(bench::Shape::kRandom, n)), 1, 1);
}
BENCHMARK(repeat_random)->Name("step/random")->Arg(5)->Arg(20)->Arg(64)->Arg(256)->Arg(1000)->Apply(bench::keep_least);

}  // namespace
}  // namespace unlatch::test
