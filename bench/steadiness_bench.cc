// Variation of the step's time on an undisturbed core. Rounds of
//
//   sums, step, sums, as many sums as take the step's time, sums
//
// run back to back on one CPU. If the sums before and after took their least time, no other process was on the core: a
// longer step is caused by the step itself, or by an interruption in its middle. Sums in place of the step show the
// frequency of such interruptions. Prints one JSON object. bench/jitter.py runs it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <vector>

#include "hil/run/run.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/real_time.h"
#include "hil/session/realtime/yardsticks.h"

namespace unlatch::bench {
namespace {

constexpr double kQuiet = 1.05;  // relative to the least time of the sums
constexpr std::int64_t kTick_ns = 1'000'000,
                       kRest_ns = 100'000;  // of every ms: the system stops a real-time thread that never rests
constexpr int kStepSums = 7200;             // three times the sums around it

struct Options {
  double seconds = 10, spin_us = 0;
  int cpu = -1;
};

struct Round {
  std::int64_t before, step, between, sums, after;  // ns
};

template <class Work>
std::int64_t time(Work&& work) {
  const std::int64_t begin = hil::get_monotonic_ns();
  work();
  return hil::get_monotonic_ns() - begin;
}

Round run_round(hil::Simulation& simulation) {
  Round round{};
  round.before = time([] { hil::add_side_by_side(); });
  round.step = time([&] { (void)simulation.step(); });
  round.between = time([] { hil::add_side_by_side(); });
  round.sums = time([] { hil::add_side_by_side(kStepSums); });
  round.after = time([] { hil::add_side_by_side(); });
  return round;
}

// Runs rounds back to back, with pauses of kRest_ns; or, with a spin, once a millisecond as the executive would:
// asleep, a warm-up step, awake.
std::vector<Round> run_rounds(hil::Simulation& simulation, const Options& options) {
  const auto spin = static_cast<std::int64_t>(options.spin_us * 1e3);
  std::vector<Round> rounds;
  rounds.reserve(static_cast<std::size_t>(options.seconds * 1e5));
  const auto beginning = simulation.save();
  const std::int64_t start = hil::get_monotonic_ns();
  const auto end = start + static_cast<std::int64_t>(options.seconds * 1e9);
  for (std::int64_t tick = start + kTick_ns; tick < end; tick += kTick_ns) {
    hil::sleep_until_ns(spin > 0 ? tick - spin : tick);
    simulation.warm_up();
    while (hil::get_monotonic_ns() < tick) {
    }
    do {
      rounds.push_back(run_round(simulation));
      if (simulation.get_tick() >= 20'000) (void)simulation.restore(beginning);
    } while (spin == 0 && hil::get_monotonic_ns() < tick + kTick_ns - kRest_ns && rounds.size() < rounds.capacity());
  }
  return rounds;
}

void print(const char* name, std::vector<std::int64_t> times, const char* separator) {
  if (times.empty()) {
    std::printf("\"%s\": {\"count\": 0}%s", name, separator);
    return;
  }
  std::sort(times.begin(), times.end());
  const auto get = [&](double part) {
    return times[static_cast<std::size_t>(part * static_cast<double>(times.size()))];
  };
  const std::int64_t limit = get(0.5) + get(0.5) / 2;
  const auto longer = std::distance(std::upper_bound(times.begin(), times.end(), limit), times.end());
  std::printf(
      "\"%s\": {\"count\": %zu, \"min\": %lld, \"p50\": %lld, \"p99\": %lld, \"p999\": %lld, \"longer\": %.5f}%s", name,
      times.size(), static_cast<long long>(times[0]), static_cast<long long>(get(0.5)),
      static_cast<long long>(get(0.99)), static_cast<long long>(get(0.999)),
      static_cast<double>(longer) / static_cast<double>(times.size()), separator);
}

void report(const std::vector<Round>& rounds) {
  std::int64_t least = rounds.front().before;
  for (const Round& round : rounds) least = std::min({least, round.before, round.between, round.after});
  const auto is_quiet = [&](std::int64_t sums) {
    return static_cast<double>(sums) <= kQuiet * static_cast<double>(least);
  };
  std::vector<std::int64_t> step, sums, quiet_step, quiet_sums;
  for (const Round& round : rounds) {
    step.push_back(round.step);
    sums.push_back(round.sums);
    if (is_quiet(round.before) && is_quiet(round.between)) quiet_step.push_back(round.step);
    if (is_quiet(round.between) && is_quiet(round.after)) quiet_sums.push_back(round.sums);
  }
  std::printf("{");
  print("step", std::move(step), ", ");
  print("sums", std::move(sums), ", ");
  print("quiet_step", std::move(quiet_step), ", ");
  print("quiet_sums", std::move(quiet_sums), "}\n");
}

}  // namespace
}  // namespace unlatch::bench

int main(int argc, char** argv) {
  using namespace unlatch;
  bench::Options options;
  CLI::App app{
      "A step beside work of the same length that is the same each time. Run bench/jitter.py, which runs this."};
  bool list = false;
  std::string filter;
  app.add_flag("--benchmark_list_tests", list, "for tools/bench: lists nothing");
  app.add_option("--benchmark_filter", filter)->group("");
  app.add_option("--seconds", options.seconds)->check(CLI::Range(0.1, 1000.))->capture_default_str();
  app.add_option("--spin-us", options.spin_us, "a step a millisecond, this long after waking")->capture_default_str();
  app.add_option("--cpu", options.cpu)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (list) return 0;
  try {
    const auto simulation = hil::build_simulation(
        hil::load_scenario(UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/reference.yaml", {"step.until=20"}));
    const hil::ShallowIdle awake;
    for (const std::string& refused : hil::request_real_time({.priority = 80, .cpu = options.cpu})) {
      std::fprintf(stderr, "%s\n", refused.c_str());
    }
    bench::report(bench::run_rounds(*simulation, options));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
