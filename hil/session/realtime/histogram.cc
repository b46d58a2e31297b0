#include "hil/session/realtime/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace unlatch::hil {

// The first 64 buckets hold one nanosecond each; after them the octave [2^e, 2^(e+1)) is cut into 64 equal parts.
std::size_t Histogram::calc_bucket(std::int64_t ns) noexcept {
  const auto value = static_cast<std::uint64_t>(ns);
  if (value < (1u << kSubBits)) return static_cast<std::size_t>(value);
  const int shift = static_cast<int>(std::bit_width(value)) - 1 - kSubBits;
  const std::size_t part = static_cast<std::size_t>(value >> shift) & ((1u << kSubBits) - 1);
  return std::min((static_cast<std::size_t>(shift + 1) << kSubBits) + part, kBuckets - 1);
}

std::int64_t Histogram::calc_upper_bound(std::size_t bucket) noexcept {
  if (bucket < (1u << kSubBits)) return static_cast<std::int64_t>(bucket);
  const int shift = static_cast<int>(bucket >> kSubBits) - 1;
  const std::uint64_t part = (bucket & ((1u << kSubBits) - 1)) + (1u << kSubBits);
  return static_cast<std::int64_t>(((part + 1) << shift) - 1);
}

void Histogram::record(std::int64_t ns) noexcept {
  ns = std::max<std::int64_t>(ns, 0);
  ++buckets_[calc_bucket(ns)];
  ++count_;
  min_ = std::min(min_, ns);
  max_ = std::max(max_, ns);
}

std::int64_t Histogram::calc_percentile(double fraction) const noexcept {
  if (count_ == 0) return 0;
  const auto wanted = static_cast<std::int64_t>(std::ceil(fraction * static_cast<double>(count_)));
  std::int64_t seen = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    seen += buckets_[i];
    if (seen >= wanted) return i + 1 == kBuckets ? max_ : std::min(calc_upper_bound(i), max_);
  }
  return max_;
}

DurationSummary Histogram::summarize() const {
  DurationSummary summary{.count = count_,
                          .min = get_min(),
                          .p50 = calc_percentile(0.5),
                          .p90 = calc_percentile(0.9),
                          .p99 = calc_percentile(0.99),
                          .p999 = calc_percentile(0.999),
                          .p9999 = calc_percentile(0.9999),
                          .p99999 = calc_percentile(0.99999),
                          .max = max_,
                          .bins = {}};
  summary.bins.reserve(kBuckets);
  for (std::size_t i = 0; i < kBuckets; ++i) {
    if (buckets_[i] > 0) summary.bins.push_back({std::min(calc_upper_bound(i), max_), buckets_[i]});
  }
  return summary;
}

}  // namespace unlatch::hil
