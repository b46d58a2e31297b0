#include "hil/campaign/runner.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace unlatch::hil {

SampleRecord run_sample(const Campaign& campaign, const SampleEvaluator& evaluator, std::int64_t sample,
                        const std::atomic<bool>& stop) {
  SampleRecord record;
  record.sample = sample;
  record.inputs = draw_inputs(campaign, sample);
  record.result = evaluator.evaluate(make_settings(campaign, record.inputs), stop);
  return record;
}

void run_samples(const Campaign& campaign, const SampleEvaluator& evaluator, std::int64_t first, std::int64_t last,
                 int jobs, ResultFile& results, const std::atomic<bool>& stop, const std::function<void()>& finished) {
  std::vector<bool> done(static_cast<std::size_t>(std::max<std::int64_t>(0, last - first)), false);
  for (const std::int64_t sample : results.samples())
    if (sample >= first && sample < last) done[static_cast<std::size_t>(sample - first)] = true;
  std::atomic<std::int64_t> next{first};
  std::atomic<bool> end{false};  // `stop`, or an error
  std::mutex mutex;              // of the file, `finished` and `error`
  std::exception_ptr error;
  const auto work = [&] {
    try {
      while (!end && !stop) {
        const std::int64_t sample = next++;
        if (sample >= last) return;
        if (done[static_cast<std::size_t>(sample - first)]) continue;
        const SampleRecord record = run_sample(campaign, evaluator, sample, stop);
        if (record.result.status == SampleStatus::kInterrupted) return;
        const std::scoped_lock lock(mutex);
        if (end) return;
        results.append(record);
        finished();
      }
    } catch (...) {
      const std::scoped_lock lock(mutex);
      if (!error) error = std::current_exception();
      end = true;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 1; i < jobs; ++i) threads.emplace_back(work);
    work();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace unlatch::hil
