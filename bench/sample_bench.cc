// Processor time of one sample of a campaign, and of its parts, in turns over the same samples:
//   sample_bench CAMPAIGN [SAMPLES [TURNS]]
// Prints ms of the fastest turn: settings to a scenario, scenario to a simulation, the steps alone, the whole sample;
// and side by side (unlatch/bundle.h) the steps alone and the whole sample.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <span>
#include <utility>
#include <vector>

#include "hil/run/run.h"
#include "hil/study/campaign/campaign.h"
#include "hil/study/evaluation/evaluation.h"

namespace {

using namespace unlatch;

double get_processor_time() {  // s
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Time per sample, ms.
template <typename Task>
double measure(const std::vector<hil::SampleTask>& samples, const Task& task) {
  const double begin = get_processor_time();
  for (const hil::SampleTask& sample : samples) task(sample);
  return 1e3 * (get_processor_time() - begin) / static_cast<double>(samples.size());
}

double measure_side_by_side(const hil::SampleEvaluator& evaluator, std::vector<hil::SampleTask> samples, bool judges) {
  const std::atomic<bool> never{false};
  for (hil::SampleTask& sample : samples) sample.run.judges = judges;
  const std::span<const hil::SampleTask> all = samples;
  const double begin = get_processor_time();
  for (std::size_t i = 0; i < all.size(); i += hil::SampleEvaluator::kSideBySide)
    (void)evaluator.evaluate(all.subspan(i, std::min(hil::SampleEvaluator::kSideBySide, all.size() - i)), never);
  return 1e3 * (get_processor_time() - begin) / static_cast<double>(samples.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const hil::Campaign campaign = hil::load_campaign(argv[1]);
  const hil::SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
  const int count = argc > 2 ? std::atoi(argv[2]) : 24, turns = argc > 3 ? std::atoi(argv[3]) : 7;
  std::vector<hil::SampleTask> samples;
  for (int i = 0; i < count; ++i) samples.push_back({make_settings(campaign, draw_inputs(campaign, i))});

  const std::atomic<bool> never{false};
  hil::SampleRun bare;
  bare.judges = false;
  std::array<double, 6> least;
  least.fill(1e300);
  for (int turn = 0; turn < turns; ++turn) {
    const std::array<double, 6> times{
        measure(samples, [&](const hil::SampleTask& sample) { (void)campaign.tree->read(sample.settings); }),
        measure(
            samples,
            [&](const hil::SampleTask& sample) { (void)hil::build_simulation(campaign.tree->read(sample.settings)); }),
        measure(samples,
                [&](const hil::SampleTask& sample) { (void)evaluator.evaluate(sample.settings, never, bare); }),
        measure(samples, [&](const hil::SampleTask& sample) { (void)evaluator.evaluate(sample.settings); }),
        measure_side_by_side(evaluator, samples, false),
        measure_side_by_side(evaluator, samples, true)};
    for (std::size_t i = 0; i < times.size(); ++i) least[i] = std::min(least[i], times[i]);
  }
  const double built = least[1];
  std::printf("%.3f %.3f %.3f %.3f %.3f %.3f\n", least[0], built - least[0], least[2] - built, least[3],
              least[4] - built, least[5]);
}
