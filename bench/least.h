// Beside mean and median, the least of a benchmark's repetitions: what other users of a shared machine do to a time
// only adds to it.
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
