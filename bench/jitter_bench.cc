// The cyclic executive in real time, without flight software: how late it is woken, how long its steps take, and beside
// it yardsticks, as often and on the same CPU, whose tails are the machine's: fixed arithmetic in registers, and
// reading as much as a core's second cache holds in part, once when others have had the caches and once again. Prints
// one JSON object. bench/jitter.py runs it beside cyclictest, with and without load.
#include <time.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "bench/panel_array.h"
#include "hil/executive.h"
#include "hil/histogram.h"
#include "hil/link.h"
#include "hil/real_time.h"
#include "hil/run.h"

namespace unlatch::bench {
namespace {

constexpr int kPanels = 64;

struct Options {
  std::string scenario = "boosters";
  double period_us = 1000, seconds = 10, spin_us = 0;
  int cpu = -1;
};

hil::Scenario load(const Options& options) {
  const double dt = options.period_us * 1e-6;
  if (options.scenario == "array64") {
    hil::Scenario scenario;
    scenario.name = "array64";
    scenario.dt = dt;
    scenario.until = options.seconds;
    scenario.model = build_panel_array(kPanels);
    return scenario;
  }
  return hil::load_scenario(UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/reference.yaml",
                            {"step.dt=" + std::to_string(dt), "step.until=" + std::to_string(options.seconds)});
}

void print(const char* name, const hil::DurationSummary& s) {
  std::printf(
      "\"%s\": {\"count\": %lld, \"min\": %lld, \"p50\": %lld, \"p99\": %lld, \"p999\": %lld, \"p9999\": %lld, "
      "\"max\": %lld}, ",
      name, static_cast<long long>(s.count), static_cast<long long>(s.min), static_cast<long long>(s.p50),
      static_cast<long long>(s.p99), static_cast<long long>(s.p999), static_cast<long long>(s.p9999),
      static_cast<long long>(s.max));
}

std::int64_t read_clock() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

// Some 5 us on a processor of 2.5 GHz: no memory, no branch but the loop's.
void compute() {
  std::uint64_t x = 1;
  for (int i = 0; i < 3000; ++i) {
    x = x * 6364136223846793005u + 1442695040888963407u;
    asm volatile("" : "+r"(x));  // as long a chain as it looks
  }
}

// 128 KiB, a number of each cache line in an order that no prefetcher guesses.
class Reading {
 public:
  void read() {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kLines; ++i) sum += numbers_[i * kScatter % kLines * kNumbersPerLine];
    asm volatile("" : : "r"(sum));
  }

 private:
  static constexpr std::size_t kLines = 2048, kScatter = 769, kNumbersPerLine = 8;
  std::vector<std::uint64_t> numbers_ = std::vector<std::uint64_t>(kLines * kNumbersPerLine, 1);
};

struct Yardsticks {
  hil::DurationSummary arithmetic, first_reading, second_reading;
};

Yardsticks run_yardsticks(const Options& options, const std::stop_token& stopping) {
  (void)hil::request_real_time({.priority = 80, .cpu = options.cpu});
  Reading reading;
  hil::Histogram arithmetic, first_reading, second_reading;
  const auto period = static_cast<std::int64_t>(options.period_us * 1e3);
  for (std::int64_t next = read_clock(); !stopping.stop_requested(); next += period) {
    const timespec deadline{next / 1'000'000'000, next % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
    const std::int64_t start = read_clock();
    compute();
    const std::int64_t computed = read_clock();
    reading.read();
    const std::int64_t read_once = read_clock();
    reading.read();
    second_reading.record(read_clock() - read_once);
    first_reading.record(read_once - computed);
    arithmetic.record(computed - start);
  }
  return {arithmetic.summarize(), first_reading.summarize(), second_reading.summarize()};
}

int run(const Options& options) {
  const hil::Scenario scenario = load(options);
  const auto simulation = hil::build_simulation(scenario);
  hil::ExecutiveOptions executive_options;
  executive_options.pace = hil::Pace::kRealtime;
  executive_options.last_tick = std::llround(scenario.until / scenario.dt);
  executive_options.timing.spin = options.spin_us * 1e-6;
  hil::Link link;
  hil::Recorder recorder(
      "", hil::build_log_header(scenario, *simulation, executive_options.pace, 1, executive_options.last_tick));
  hil::Executive executive(*simulation, link, recorder, scenario.name, executive_options);
  // Stands for the bridge: takes what is said, and says nothing.
  std::jthread listener([&link](const std::stop_token& stopping) {
    hil::Message message;
    while (!stopping.stop_requested()) {
      while (link.take(message)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  Yardsticks yardsticks;
  std::jthread measure([&](const std::stop_token& stopping) { yardsticks = run_yardsticks(options, stopping); });
  hil::LogEnd end;
  std::jthread([&] {
    for (const std::string& refused : hil::request_real_time({.priority = 80, .cpu = options.cpu})) {
      std::fprintf(stderr, "%s\n", refused.c_str());
    }
    end = executive.run();
  }).join();
  measure.request_stop();
  measure.join();
  recorder.close(end);
  std::printf("{\"status\": %d, ", static_cast<int>(end.status));
  print("step_ns", end.timing.step);
  print("wakeup_ns", end.timing.wakeup);
  print("yardstick_ns", yardsticks.arithmetic);
  print("first_reading_ns", yardsticks.first_reading);
  print("second_reading_ns", yardsticks.second_reading);
  std::printf("\"overruns\": %lld, \"causes\": {", static_cast<long long>(end.timing.overruns));
  for (std::size_t i = 0; i < hil::kOverrunCauses; ++i) {
    std::printf("%s\"%s\": %lld", i == 0 ? "" : ", ", hil::kOverrunCauseNames[i].data(),
                static_cast<long long>(end.timing.overrun_causes[i]));
  }
  std::printf("}}\n");
  return end.status == hil::RunStatus::kDone ? 0 : 1;
}

}  // namespace
}  // namespace unlatch::bench

int main(int argc, char** argv) {
  unlatch::bench::Options options;
  CLI::App app{"The cyclic executive by the clock. Run bench/jitter.py, which runs this."};
  bool list = false;
  std::string filter;
  app.add_flag("--benchmark_list_tests", list, "for tools/bench: lists nothing");
  app.add_option("--benchmark_filter", filter)->group("");
  app.add_option("--scenario", options.scenario)->check(CLI::IsMember({"boosters", "array64"}))->capture_default_str();
  app.add_option("--period-us", options.period_us)->capture_default_str();
  app.add_option("--seconds", options.seconds)->capture_default_str();
  app.add_option("--spin-us", options.spin_us)->capture_default_str();
  app.add_option("--cpu", options.cpu)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (list) return 0;
  try {
    return unlatch::bench::run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
