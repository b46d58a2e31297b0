#include "hil/campaign/runner.h"

#include <chrono>

#include "hil/campaign/sample_pool.h"

namespace unlatch::hil {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kHere = 0;                               // the only worker
constexpr auto kTurn = std::chrono::milliseconds(20);  // longest wait; then `stop` is looked at

}  // namespace

SampleRecord run_sample(const Campaign& campaign, const SampleEvaluator& evaluator, const PlannedSample& sample,
                        const std::atomic<bool>& stop) {
  return {sample.sample, sample.inputs, evaluator.evaluate(make_settings(campaign, sample.inputs), stop)};
}

void run_samples(const Campaign& campaign, const SampleEvaluator& evaluator, std::int64_t first, std::int64_t last,
                 int jobs, ResultFile& results, const std::atomic<bool>& stop, const std::function<void()>& finished) {
  SampleSource source(campaign, first, last, results);
  source.join(kHere, jobs);
  SamplePool pool(campaign, evaluator, jobs);
  const auto begin = Clock::now();
  while (!stop && !source.is_finished()) {
    pool.add(source.give(kHere, std::chrono::duration<double>(Clock::now() - begin).count()));
    for (const SampleRecord& record : pool.take(kTurn)) {
      source.take(kHere, record);
      results.append(record);
      finished();
    }
  }
}

}  // namespace unlatch::hil
