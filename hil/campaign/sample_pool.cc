#include "hil/campaign/sample_pool.h"

#include <utility>

#include "hil/campaign/runner.h"

namespace unlatch::hil {

SamplePool::SamplePool(const Campaign& campaign, const SampleEvaluator& evaluator, int jobs)
    : campaign_(campaign), evaluator_(evaluator) {
  for (int i = 0; i < jobs; ++i) threads_.emplace_back([this] { work(); });
}

SamplePool::~SamplePool() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  has_samples_.notify_all();
}

void SamplePool::add(std::span<const PlannedSample> samples) {
  {
    const std::scoped_lock lock(mutex_);
    samples_.insert(samples_.end(), samples.begin(), samples.end());
  }
  has_samples_.notify_all();
}

std::vector<SampleRecord> SamplePool::take(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  has_records_.wait_for(lock, longest, [&] { return !records_.empty() || error_ != nullptr; });
  if (error_) std::rethrow_exception(error_);
  return std::exchange(records_, {});
}

void SamplePool::work() {
  std::unique_lock lock(mutex_);
  try {
    while (true) {
      has_samples_.wait(lock, [&] { return stop_ || !samples_.empty(); });
      if (stop_) return;
      const PlannedSample sample = std::move(samples_.front());
      samples_.pop_front();
      lock.unlock();
      SampleRecord record = run_sample(campaign_, evaluator_, sample, stop_);
      lock.lock();
      if (record.result.status == SampleStatus::kInterrupted) return;
      records_.push_back(std::move(record));
      has_records_.notify_one();
    }
  } catch (...) {
    if (!lock.owns_lock()) lock.lock();
    if (!error_) error_ = std::current_exception();
    stop_ = true;
    has_samples_.notify_all();
    has_records_.notify_one();
  }
}

}  // namespace unlatch::hil
