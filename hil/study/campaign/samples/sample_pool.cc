#include "hil/study/campaign/samples/sample_pool.h"

#include <algorithm>
#include <utility>

#include "hil/study/campaign/samples/runner.h"

namespace unlatch::hil {

SamplePool::SamplePool(const Campaign& campaign, const SampleEvaluator& evaluator, int jobs)
    : campaign_(campaign), evaluator_(evaluator), jobs_(static_cast<std::size_t>(jobs)) {
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

// Takes waiting samples: as many as a thread runs side by side, or its share if that is less.
std::vector<PlannedSample> SamplePool::take_share() {
  const std::size_t share = (samples_.size() + jobs_ - 1) / jobs_;
  std::vector<PlannedSample> taken;
  for (std::size_t i = std::min(share, SampleEvaluator::kSideBySide); i > 0; --i) {
    taken.push_back(std::move(samples_.front()));
    samples_.pop_front();
  }
  return taken;
}

void SamplePool::work() {
  std::unique_lock lock(mutex_);
  try {
    while (true) {
      has_samples_.wait(lock, [&] { return stop_ || !samples_.empty(); });
      if (stop_) return;
      std::vector<PlannedSample> samples = take_share();
      lock.unlock();
      std::vector<SampleRecord> records = run_together(campaign_, evaluator_, std::move(samples), stop_);
      lock.lock();
      for (SampleRecord& record : records)
        if (record.result.status != SampleStatus::kInterrupted) records_.push_back(std::move(record));
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
