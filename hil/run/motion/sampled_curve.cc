#include "hil/run/motion/sampled_curve.h"

#include <algorithm>

namespace unlatch::hil {

double interpolate(std::span<const double> times, std::span<const double> values, double time) {
  double p[kCurvePoints];
  std::copy(values.begin(), values.end(), p);
  const std::size_t count = values.size();
  for (std::size_t k = 1; k < count; ++k)
    for (std::size_t i = 0; i + k < count; ++i)
      p[i] = ((time - times[i + k]) * p[i] + (times[i] - time) * p[i + 1]) / (times[i] - times[i + k]);
  return p[0];
}

void SampledCurve::add(double time, double value, bool begins) {
  if (begins) count_ = 0;
  if (count_ == kCurvePoints) {
    std::copy(times_ + 1, times_ + kCurvePoints, times_);
    std::copy(values_ + 1, values_ + kCurvePoints, values_);
    --count_;
  }
  times_[count_] = time;
  values_[count_++] = value;
}

}  // namespace unlatch::hil
