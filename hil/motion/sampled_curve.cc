#include "hil/motion/sampled_curve.h"

#include <algorithm>

namespace unlatch::hil {

void SampledCurve::add(double time, double value, bool begins) {
  if (begins) count_ = 0;
  if (count_ == kPoints) {
    std::copy(times_ + 1, times_ + kPoints, times_);
    std::copy(values_ + 1, values_ + kPoints, values_);
    --count_;
  }
  times_[count_] = time;
  values_[count_++] = value;
}

// Neville's scheme.
double SampledCurve::calc(double time) const {
  double p[kPoints];
  std::copy(values_, values_ + count_, p);
  for (int k = 1; k < count_; ++k)
    for (int i = 0; i + k < count_; ++i)
      p[i] = ((time - times_[i + k]) * p[i] + (times_[i] - time) * p[i + 1]) / (times_[i] - times_[i + k]);
  return p[0];
}

}  // namespace unlatch::hil
