// Threads that run the samples which they are given, for a caller that meanwhile does something else: one that hands
// out samples to other processes, or gets them from another.
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

#include "hil/campaign/sample_source.h"

namespace unlatch::hil {

class SamplePool {
 public:
  // Refers to campaign and evaluator.
  SamplePool(const Campaign& campaign, const SampleEvaluator& evaluator, int jobs);
  // Samples that are running or wait are left.
  ~SamplePool();
  SamplePool(const SamplePool&) = delete;
  SamplePool& operator=(const SamplePool&) = delete;

  void add(std::span<const PlannedSample> samples);
  // Results since the last call; if nothing has, waits for it no longer than that. Throws what a sample threw.
  std::vector<SampleRecord> take(std::chrono::milliseconds longest);

 private:
  std::vector<PlannedSample> take_share();
  void work();

  const Campaign& campaign_;
  const SampleEvaluator& evaluator_;
  const std::size_t jobs_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;  // of all below
  std::condition_variable has_samples_, has_records_;
  std::deque<PlannedSample> samples_;  // not begun
  std::vector<SampleRecord> records_;  // not taken
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;  // last: they end before the rest does
};

}  // namespace unlatch::hil
