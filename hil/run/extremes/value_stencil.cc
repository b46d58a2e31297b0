#include "hil/run/extremes/value_stencil.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {
namespace {

constexpr double kLeastFall = 1e-14;  // of values: rounding of a difference

}  // namespace

ValueTerms::ValueTerms(std::span<const double> times, std::span<const double> values, std::size_t interval)
    : count_(times.size()),
      from_(times[interval]),
      to_(times[interval + 1]),
      at_from_(values[interval]),
      at_to_(values[interval + 1]) {
  std::copy(values.begin(), values.end(), differences_[0]);
  for (std::size_t k = 1; k < count_; ++k)
    for (std::size_t i = 0; i + k < count_; ++i)
      differences_[k][i] = (differences_[k - 1][i + 1] - differences_[k - 1][i]) / (times[i + k] - times[i]);
  // From the interval outwards, to either side in turn as far as there are knots.
  std::size_t first = interval, last = interval + 1;
  order_[0] = times[first];
  order_[1] = times[last];
  terms_[0] = differences_[0][first];
  terms_[1] = differences_[1][first];
  for (std::size_t k = 2; k < count_; ++k) {
    const bool to_left = first > 0 && (last + 1 == count_ || interval - first <= last - interval - 1);
    order_[k] = to_left ? times[--first] : times[++last];
    terms_[k] = differences_[k][first];
  }
  spacing_ = (times[count_ - 1] - times[0]) / static_cast<double>(count_ - 1);
  if (interval < 2 || interval + 4 > count_) return;
  const auto& d = differences_;
  const std::size_t i = interval, k = interval + 1;
  before_ = {times[i], times[i - 1], {d[0][i], d[1][i - 1], d[2][i - 2]}};
  behind_ = {times[k], times[k + 1], {d[0][k], d[1][k], d[2][k]}};
}

double ValueTerms::calc_most_departure() const {
  constexpr double kRounding = 1e-12;  // of calc(), of the largest number in it; some thousand times what it is
  const double h = to_ - from_;
  double curve = 0, way = 0.25 * (h * h), last = 0, before = 0;
  for (std::size_t k = 2; k < count_; ++k) {
    before = last;
    last = way * std::abs(terms_[k]);
    curve += last;
    way *= std::max(std::abs(from_ - order_[k]), std::abs(to_ - order_[k]));
  }
  double aside = 0;  // of the nearer parabola from the chord
  if (before_) {
    const auto calc_aside = [&](const Side& side, double far) {
      return h * (std::abs(terms_[1] - side.terms[1]) + std::abs(far - side.next) * std::abs(side.terms[2]));
    };
    aside = std::min(calc_aside(*before_, to_), calc_aside(*behind_, from_));
  }
  const double most = curve + std::max({last, before, curve + aside});
  const double size = std::max(std::abs(at_from_), std::abs(at_to_)) + (most + h * std::abs(terms_[1]));
  return most + kRounding * size;
}

ValueStencil::ValueStencil(const ValueTerms& terms) : ValueTerms(terms) {
  // The largest difference of each order, as of knots of equal spacing.
  double sizes[kMost] = {}, scale = 1;
  for (std::size_t k = 0; k < count_; ++k) {
    if (k > 0) scale *= static_cast<double>(k) * spacing_;
    for (std::size_t i = 0; i + k < count_; ++i) sizes[k] = std::max(sizes[k], scale * std::abs(differences_[k][i]));
  }
  const auto fall = [&](std::size_t k, std::size_t by) {
    return sizes[k] > kLeastFall * sizes[0] ? std::min(1.0, sizes[k] / sizes[k - by]) : 0;
  };
  if (count_ == 3) ratio_ = fall(2, 1);
  if (count_ == 4) ratio_ = std::sqrt(fall(3, 2));
  // One difference may vanish by chance, at a corner too: of two falls the slower one.
  if (count_ == 5) ratio_ = std::sqrt(std::max(fall(4, 2), fall(3, 2)));
  if (count_ > 5) ratio_ = std::sqrt(std::max(fall(4, 2), fall(5, 2)));
  doubt_ = ratio_ * ratio_ * ratio_ * ratio_;
  if (count_ > 2 && count_ < kMost)
    next_ = std::max(sizes[count_ - 1], sizes[count_ - 2]) / (scale * static_cast<double>(count_) * spacing_);
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
