#include "hil/run/extremes/value_stencil.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {
namespace {

constexpr double kLeastFall = 1e-14;  // of values: rounding of a difference

}  // namespace

ValueStencil::ValueStencil(std::span<const double> times, std::span<const double> values, std::size_t interval)
    : count_(times.size()),
      from_(times[interval]),
      to_(times[interval + 1]),
      at_from_(values[interval]),
      at_to_(values[interval + 1]) {
  // Divided differences: of order k from knot i on.
  double differences[kMost][kMost] = {};
  std::copy(values.begin(), values.end(), differences[0]);
  for (std::size_t k = 1; k < count_; ++k)
    for (std::size_t i = 0; i + k < count_; ++i)
      differences[k][i] = (differences[k - 1][i + 1] - differences[k - 1][i]) / (times[i + k] - times[i]);
  // From the interval outwards, to either side in turn as far as there are knots.
  std::size_t first = interval, last = interval + 1;
  order_[0] = times[first];
  order_[1] = times[last];
  terms_[0] = differences[0][first];
  terms_[1] = differences[1][first];
  for (std::size_t k = 2; k < count_; ++k) {
    const bool to_left = first > 0 && (last + 1 == count_ || interval - first <= last - interval - 1);
    order_[k] = to_left ? times[--first] : times[++last];
    terms_[k] = differences[k][first];
  }
  spacing_ = (times[count_ - 1] - times[0]) / static_cast<double>(count_ - 1);
  // The largest difference of each order, as of knots of equal spacing.
  double sizes[kMost] = {}, scale = 1, size = 0;
  for (const double value : values) size = std::max(size, std::abs(value));
  for (std::size_t k = 0; k < count_; ++k) {
    if (k > 0) scale *= static_cast<double>(k) * spacing_;
    for (std::size_t i = 0; i + k < count_; ++i) sizes[k] = std::max(sizes[k], scale * std::abs(differences[k][i]));
  }
  const auto fall = [&](std::size_t k, std::size_t by) {
    return sizes[k] > kLeastFall * size ? std::min(1.0, sizes[k] / sizes[k - by]) : 0;
  };
  if (count_ == 3) ratio_ = fall(2, 1);
  if (count_ == 4) ratio_ = std::sqrt(fall(3, 2));
  if (count_ > 4) ratio_ = std::sqrt(fall(4, 2));
  if (count_ > 5) ratio_ = std::max(ratio_, std::sqrt(fall(5, 2)));
  doubt_ = ratio_ * ratio_ * ratio_ * ratio_;
  if (count_ > 2 && count_ < kMost)
    next_ = std::max(sizes[count_ - 1], sizes[count_ - 2]) / (scale * static_cast<double>(count_) * spacing_);
  if (interval < 2 || interval + 4 > count_) return;
  const std::size_t i = interval, k = interval + 1;
  before_ = {times[i], times[i - 1], {differences[0][i], differences[1][i - 1], differences[2][i - 2]}};
  behind_ = {times[k], times[k + 1], {differences[0][k], differences[1][k], differences[2][k]}};
}

ValueStencil::Value ValueStencil::calc(double time) const {
  double sum = terms_[0], way = 1, last = 0, before = 0, chord = terms_[0];
  for (std::size_t k = 1; k < count_; ++k) {
    way *= time - order_[k - 1];
    before = last;
    last = terms_[k] * way;
    if (k == 1) chord += last;
    sum += last;
  }
  last = std::abs(last);
  before = std::abs(before);
  const double next = next_ * std::abs(way * (time - order_[count_ - 1]));
  if (count_ == 3) return {sum, std::max(ratio_ * last, next)};
  const double aside = before_ ? std::min(std::abs(sum - before_->calc(time)), std::abs(sum - behind_->calc(time)))
                               : std::abs(sum - chord);
  return {sum, std::max({last, ratio_ * before, doubt_ * aside, next})};
}

}  // namespace unlatch::hil
