#include "hil/study/campaign/samples/runner.h"

#include <chrono>
#include <utility>

#include "hil/study/campaign/samples/campaign_step.h"
#include "hil/study/campaign/samples/sample_pool.h"

namespace unlatch::hil {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kHere = 0;                               // number of the only worker
constexpr auto kTurn = std::chrono::milliseconds(20);  // longest wait; `stop` is checked after it

}  // namespace

std::vector<SampleRecord> run_together(const Campaign& campaign, const SampleEvaluator& evaluator,
                                       std::vector<PlannedSample> samples, const std::atomic<bool>& stop) {
  std::vector<SampleTask> tasks;
  for (const PlannedSample& sample : samples) tasks.push_back({make_settings(campaign, sample.inputs)});
  std::vector<SampleResult> results = evaluator.evaluate(tasks, stop);
  std::vector<SampleRecord> records;
  for (std::size_t i = 0; i < samples.size(); ++i)
    records.push_back({samples[i].sample, std::move(samples[i].inputs), std::move(results[i])});
  if (campaign.tolerance > 0)
    for (SampleRecord& record : records) check_step(campaign, evaluator, stop, record);
  return records;
}

void run_samples(const Campaign& campaign, const SampleEvaluator& evaluator, std::int64_t first, std::int64_t last,
                 int jobs, ResultFile& results, const std::atomic<bool>& stop, const std::function<void()>& finished) {
  SampleSource source(campaign, first, last, results);
  source.join(kHere, jobs);
  SamplePool pool(campaign, evaluator, jobs);
  const auto begin = Clock::now();
  while (!stop && !source.is_finished()) {
    pool.add(source.assign(kHere, std::chrono::duration<double>(Clock::now() - begin).count()));
    for (const SampleRecord& record : pool.take(kTurn)) {
      source.take(kHere, record);
      results.append(record);
      finished();
    }
  }
}

}  // namespace unlatch::hil
