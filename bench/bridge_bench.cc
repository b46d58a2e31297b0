// Round trips of the protocol. bridge/<transport>/<bodies>: a round trip of the executive in lockstep: a state out, its
// acknowledgement back. bridge/bare_<transport>/<bodies>: messages of the same sizes over the same middleware without
// the protocol. bridge/bare_one_<transport>/<bodies>: the same bytes in one message. bridge/<transport>_paced/<bodies>:
// as in real time, through the rings and their threads. Time is wall time per round trip, the average; p50_us is its
// median, min_us its minimum.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "bench/pingpong/pingpong.h"

namespace unlatch::bench {
namespace {

// Opens each ping-pong once: repetitions of all of them are interleaved.
PingPong& find_pingpong(const std::string& who) {
  static std::map<std::string, std::unique_ptr<PingPong>> open;
  auto& pingpong = open[who];
  if (!pingpong) pingpong = open_pingpong(who);
  return *pingpong;
}

void run(benchmark::State& state, const std::string& who, int bodies) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times_us;
  try {
    PingPong& pingpong = find_pingpong(who);
    for (auto _ : state) {
      const auto begin = Clock::now();
      pingpong.run(bodies);
      times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    }
  } catch (const std::runtime_error& error) {
    return state.SkipWithError(error.what());
  }
  const auto middle = times_us.begin() + static_cast<std::ptrdiff_t>(times_us.size() / 2);
  std::nth_element(times_us.begin(), middle, times_us.end());
  state.counters["p50_us"] = *middle;
  state.counters["min_us"] = *std::min_element(times_us.begin(), times_us.end());
}

}  // namespace
}  // namespace unlatch::bench

int main(int count, char** arguments) {
  using namespace unlatch::bench;
  if (is_echo(count, arguments)) return run_echo(arguments);
  std::vector<char*> with_defaults(arguments, arguments + count);
  std::string min_time = "--benchmark_min_time=0.02";  // of the calling thread, the smaller part
  with_defaults.insert(with_defaults.begin() + 1, min_time.data());
  int with_defaults_count = static_cast<int>(with_defaults.size());
  benchmark::Initialize(&with_defaults_count, with_defaults.data());
  for (const std::string transport : {"inproc", "lcm", "dds"}) {
    for (const int bodies : {kFew, kMany}) {
      for (const std::string& who : {transport, "bare_" + transport, "bare_one_" + transport, transport + "_paced"}) {
        if (bodies == kFew && who.starts_with("bare_one")) continue;  // it is a single message already
        benchmark::RegisterBenchmark(("bridge/" + who + "/" + std::to_string(bodies)).c_str(),
                                     [who, bodies](benchmark::State& state) { run(state, who, bodies); });
      }
    }
  }
  benchmark::RunSpecifiedBenchmarks();
}
