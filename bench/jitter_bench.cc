// The cyclic executive in real time, without flight software: wake-up latency and time of its steps. Beside it, on the
// same CPU, run the yardsticks of hil/session/realtime/yardsticks.h and a read of 128 KiB, once after other programs
// have used the caches, and once again. Prints one JSON object. bench/jitter.py runs it beside cyclictest, with and
// without load.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "bench/panel_array.h"
#include "hil/run/run.h"
#include "hil/session/executive/executive.h"
#include "hil/session/participants/ring_connection.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/histogram.h"
#include "hil/session/realtime/real_time.h"
#include "hil/session/realtime/yardsticks.h"

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

// Read of 128 KiB, a number of each cache line in an order that no prefetcher predicts: part of a core's second-level
// cache.
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
  hil::Histogram multiplications, sums, first_reading, second_reading;
};

// Runs the yardsticks once a tick, but at most a thousand times a second: at 10 kHz they would take a tenth of the CPU.
void run_yardsticks(const Options& options, const std::stop_token& stopping, Yardsticks& yardsticks) {
  (void)hil::request_real_time({.priority = 80, .cpu = options.cpu});
  Reading reading;
  const auto period = static_cast<std::int64_t>(std::max(options.period_us, 1000.) * 1e3);
  for (std::int64_t next = hil::get_monotonic_ns(); !stopping.stop_requested(); next += period) {
    hil::sleep_until_ns(next);
    std::int64_t last = hil::get_monotonic_ns();
    const auto lap = [&last](hil::Histogram& histogram) {
      const std::int64_t now = hil::get_monotonic_ns();
      histogram.record(now - last);
      last = hil::get_monotonic_ns();
    };
    hil::multiply_in_turn();
    lap(yardsticks.multiplications);
    hil::add_side_by_side();
    lap(yardsticks.sums);
    reading.read();
    lap(yardsticks.first_reading);
    reading.read();
    lap(yardsticks.second_reading);
  }
}

int run(const Options& options) {
  const hil::Scenario scenario = load(options);
  const auto simulation = hil::build_simulation(scenario);
  hil::ExecutiveOptions executive_options;
  executive_options.pace = hil::Pace::kRealtime;
  executive_options.last_tick = std::llround(scenario.until / scenario.dt);
  executive_options.timing.spin = options.spin_us * 1e-6;
  hil::RingConnection connection;
  hil::Recorder recorder(
      "", hil::build_log_header(scenario, *simulation, executive_options.pace, 1, executive_options.last_tick));
  hil::Executive executive(*simulation, connection, recorder, scenario.name, executive_options);
  // Replaces the bridge: receives all messages and sends none.
  std::jthread listener([&connection](const std::stop_token& stopping) {
    hil::Message message;
    while (!stopping.stop_requested()) {
      while (connection.take(message)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  const auto yardsticks = std::make_unique<Yardsticks>();
  std::jthread measure([&](const std::stop_token& stopping) { run_yardsticks(options, stopping, *yardsticks); });
  const hil::ShallowIdle awake;  // as in cyclictest and `unlatch hil`
  if (!awake.get_refusal().empty()) std::fprintf(stderr, "%s\n", awake.get_refusal().c_str());
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
  print("multiplications_ns", yardsticks->multiplications.summarize());
  print("sums_ns", yardsticks->sums.summarize());
  print("first_reading_ns", yardsticks->first_reading.summarize());
  print("second_reading_ns", yardsticks->second_reading.summarize());
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
