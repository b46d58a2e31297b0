// Minimum of a benchmark's repetitions, beside mean and median: other users of a shared machine can only increase a
// time.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

namespace unlatch::bench {

inline void keep_least(benchmark::internal::Benchmark* benchmark) {
  benchmark->ComputeStatistics(
      "least", [](const std::vector<double>& times) { return *std::min_element(times.begin(), times.end()); });
}

}  // namespace unlatch::bench
