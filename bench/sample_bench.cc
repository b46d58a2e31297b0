// Processor time of one sample of a campaign, and of its parts, by turns over the same samples:
//   sample_bench CAMPAIGN [SAMPLES [TURNS]]
// Prints ms of the fastest turn: settings to a scenario, scenario to a simulation, the bare steps, the whole sample.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "hil/campaign/campaign.h"
#include "hil/evaluation/evaluation.h"
#include "hil/run/run.h"

namespace {

using namespace unlatch;

double get_processor_time() {  // s
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Per sample, ms.
template <typename Task>
double measure(const std::vector<std::vector<hil::Setting>>& samples, const Task& task) {
  const double begin = get_processor_time();
  for (const auto& settings : samples) task(settings);
  return 1e3 * (get_processor_time() - begin) / static_cast<double>(samples.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const hil::Campaign campaign = hil::load_campaign(argv[1]);
  const hil::SampleEvaluator evaluator(*campaign.tree);
  const int count = argc > 2 ? std::atoi(argv[2]) : 20, turns = argc > 3 ? std::atoi(argv[3]) : 7;
  std::vector<std::vector<hil::Setting>> samples;
  for (int i = 0; i < count; ++i) samples.push_back(make_settings(campaign, draw_inputs(campaign, i)));

  const std::atomic<bool> never{false};
  hil::SampleRun bare;
  bare.judges = false;
  std::array<double, 4> least;
  least.fill(1e300);
  for (int turn = 0; turn < turns; ++turn) {
    const std::array<double, 4> times{
        measure(samples, [&](const auto& settings) { (void)campaign.tree->read(settings); }),
        measure(samples, [&](const auto& settings) { (void)hil::build_simulation(campaign.tree->read(settings)); }),
        measure(samples, [&](const auto& settings) { (void)evaluator.evaluate(settings, never, bare); }),
        measure(samples, [&](const auto& settings) { (void)evaluator.evaluate(settings); })};
    for (std::size_t i = 0; i < times.size(); ++i) least[i] = std::min(least[i], times[i]);
  }
  std::printf("%.3f %.3f %.3f %.3f\n", least[0], least[1] - least[0], least[2] - least[1], least[3]);
}
