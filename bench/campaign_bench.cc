// campaign/<scenario>/<lanes>: samples of a shipped campaign, <lanes> of them side by side (unlatch/bundle.h; 1: one by
// one), and campaign/<scenario>/<lanes>/steps without clearances, requirements and analysis. An iteration is eight
// samples, the same for every number of lanes; `samples` and `steps` are per second of processor time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "hil/study/campaign/campaign.h"
#include "hil/study/evaluation/evaluation.h"

namespace unlatch::bench {
namespace {

constexpr int kSamples = 8;

// A campaign with its first samples; loaded once for all of its benchmarks.
struct Flown {
  explicit Flown(const std::string& file)
      : campaign(hil::load_campaign(file)), evaluator(*campaign.tree, campaign.chosen) {
    for (int i = 0; i < kSamples; ++i) samples.push_back({make_settings(campaign, draw_inputs(campaign, i))});
  }
  hil::Campaign campaign;
  hil::SampleEvaluator evaluator;
  std::vector<hil::SampleTask> samples;
};

const Flown& get_campaign(const std::string& name) {
  static std::map<std::string, Flown> loaded;
  return loaded.try_emplace(name, UNLATCH_SOURCE_DIR "/hil/scenarios/" + name + "/campaign.yaml").first->second;
}

enum class Part { kWhole, kSteps };

void fly(benchmark::State& bench, const char* name, std::size_t lanes, Part part) {
  const Flown& flown = get_campaign(name);
  std::vector<hil::SampleTask> samples = flown.samples;
  for (hil::SampleTask& sample : samples) sample.run.judges = part == Part::kWhole;
  const std::atomic<bool> never{false};
  std::int64_t ticks = 0;
  for (auto _ : bench) {
    const std::span<const hil::SampleTask> all = samples;
    for (std::size_t i = 0; i < all.size(); i += lanes)
      for (const hil::SampleResult& result :
           flown.evaluator.evaluate(all.subspan(i, std::min(lanes, all.size() - i)), never)) {
        if (result.status != hil::SampleStatus::kDone) bench.SkipWithError(result.message.c_str());
        ticks += result.ticks;
      }
  }
  bench.counters["samples"] =
      benchmark::Counter(static_cast<double>(bench.iterations()) * kSamples, benchmark::Counter::kIsRate);
  bench.counters["steps"] = benchmark::Counter(static_cast<double>(ticks), benchmark::Counter::kIsRate);
}

const bool registered = [] {
  for (const char* name : {"boosters", "array", "interstage"})
    for (const std::size_t lanes : {1, 4, 8})
      for (const Part part : {Part::kWhole, Part::kSteps}) {
        const std::string suffix = part == Part::kSteps ? "/steps" : "";
        benchmark::RegisterBenchmark(("campaign/" + std::string(name) + "/" + std::to_string(lanes) + suffix).c_str(),
                                     fly, name, lanes, part)
            ->Unit(benchmark::kMillisecond);
      }
  return true;
}();

}  // namespace
}  // namespace unlatch::bench
