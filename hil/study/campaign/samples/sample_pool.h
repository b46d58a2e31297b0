// Threads that run given samples, for a caller that does something else meanwhile: one that distributes samples to
// other processes, or receives them from another.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "hil/study/campaign/samples/sample_source.h"

namespace unlatch::hil {

class SamplePool {
 public:
  // Keeps references to campaign and evaluator.
  SamplePool(const Campaign& campaign, const SampleEvaluator& evaluator, int jobs);
  // Abandons samples that run or wait.
  ~SamplePool();
  SamplePool(const SamplePool&) = delete;
  SamplePool& operator=(const SamplePool&) = delete;

  void add(std::span<const PlannedSample> samples);
  // Results since the last call; waits for one at most `longest`. Rethrows an exception of a sample.
  std::vector<SampleRecord> take(std::chrono::milliseconds longest);

 private:
  std::vector<PlannedSample> take_share();
  void work();

  const Campaign& campaign_;
  const SampleEvaluator& evaluator_;
  const std::size_t jobs_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;  // guards all members below
  std::condition_variable has_samples_, has_records_;
  std::deque<PlannedSample> samples_;  // not begun
  std::vector<SampleRecord> records_;  // not taken
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;  // last member: the threads end before the others are destroyed
};

}  // namespace unlatch::hil
