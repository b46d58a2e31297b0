#include "hil/run/extremes/extreme_bounds.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace unlatch::hil {
namespace {

constexpr int kLooks = 8;          // of an interval, at whose ends the polynomial is evaluated
constexpr double kOneKnot = 1e-6;  // of the spacing: of knots that are nearer to each other one counts
constexpr double kBeyond = 8;      // times what six knots span: a polynomial through them goes no farther between them
constexpr double kLeastFall = 1e-14;  // of values: rounding of a difference

}  // namespace

// Newton's form about one interval, its knots taken from the middle outwards.
struct ExtremeBounds::Stencil {
  Stencil(std::span<const double> times, std::span<const double> values, std::size_t interval);
  // The polynomial at a time in the interval, and by how much it may be off.
  struct Value {
    double value, uncertainty;
  };
  [[nodiscard]] Value calc(double time) const;

  std::size_t count;
  double from, to, at_from, at_to;
  double order[kPoints] = {}, terms[kPoints] = {};
  double spacing = 0, ratio = 0, doubt = 0;

 private:
  // A parabola through three knots on one side of the interval, from the nearest outwards.
  struct Side {
    double nearest, next, terms[3];
    [[nodiscard]] double calc(double time) const {
      return terms[0] + (time - nearest) * (terms[1] + (time - next) * terms[2]);
    }
  };
  std::optional<Side> before_, behind_;
};

ExtremeBounds::Stencil::Stencil(std::span<const double> times, std::span<const double> values, std::size_t interval)
    : count(times.size()),
      from(times[interval]),
      to(times[interval + 1]),
      at_from(values[interval]),
      at_to(values[interval + 1]) {
  // Divided differences: of order k from knot i on.
  double differences[kPoints][kPoints] = {};
  std::copy(values.begin(), values.end(), differences[0]);
  for (std::size_t k = 1; k < count; ++k)
    for (std::size_t i = 0; i + k < count; ++i)
      differences[k][i] = (differences[k - 1][i + 1] - differences[k - 1][i]) / (times[i + k] - times[i]);
  // From the interval outwards, to either side in turn as far as there are knots.
  std::size_t first = interval, last = interval + 1;
  order[0] = times[first];
  order[1] = times[last];
  terms[0] = differences[0][first];
  terms[1] = differences[1][first];
  for (std::size_t k = 2; k < count; ++k) {
    const bool to_left = first > 0 && (last + 1 == count || interval - first <= last - interval - 1);
    order[k] = to_left ? times[--first] : times[++last];
    terms[k] = differences[k][first];
  }
  spacing = (times[count - 1] - times[0]) / static_cast<double>(count - 1);
  // The largest difference of each order, as of knots of equal spacing.
  double sizes[kPoints] = {}, scale = 1, size = 0;
  for (const double value : values) size = std::max(size, std::abs(value));
  for (std::size_t k = 0; k < count; ++k) {
    if (k > 0) scale *= static_cast<double>(k) * spacing;
    for (std::size_t i = 0; i + k < count; ++i) sizes[k] = std::max(sizes[k], scale * std::abs(differences[k][i]));
  }
  const auto fall = [&](std::size_t k, std::size_t by) {
    return sizes[k] > kLeastFall * size ? std::min(1.0, sizes[k] / sizes[k - by]) : 0;
  };
  if (count == 3) ratio = fall(2, 1);
  if (count == 4) ratio = std::sqrt(fall(3, 2));
  if (count > 4) ratio = std::sqrt(fall(4, 2));
  if (count > 5) ratio = std::max(ratio, std::sqrt(fall(5, 2)));
  doubt = ratio * ratio * ratio * ratio;
  if (interval < 2 || interval + 4 > count) return;
  const std::size_t i = interval, k = interval + 1;
  before_ = {times[i], times[i - 1], {differences[0][i], differences[1][i - 1], differences[2][i - 2]}};
  behind_ = {times[k], times[k + 1], {differences[0][k], differences[1][k], differences[2][k]}};
}

ExtremeBounds::Stencil::Value ExtremeBounds::Stencil::calc(double time) const {
  double sum = terms[0], way = 1, last = 0, before = 0, chord = terms[0];
  for (std::size_t k = 1; k < count; ++k) {
    way *= time - order[k - 1];
    before = last;
    last = terms[k] * way;
    if (k == 1) chord += last;
    sum += last;
  }
  last = std::abs(last);
  before = std::abs(before);
  if (count == 3) return {sum, ratio * last};
  const double aside = before_ ? std::min(std::abs(sum - before_->calc(time)), std::abs(sum - behind_->calc(time)))
                               : std::abs(sum - chord);
  const double high = count == kPoints ? std::max(last, ratio * before) : ratio * std::max(last, ratio * before);
  return {sum, std::max(high, doubt * aside)};
}

double to_smooth(SmoothPart part, double value) {
  if (part == SmoothPart::kSquare) return value * value;
  const double sine = std::sin(0.5 * value);
  return part == SmoothPart::kOfAngle ? 2 * sine * sine : value;
}

double from_smooth(SmoothPart part, double smooth) {
  if (part == SmoothPart::kItself) return smooth;
  const double positive = std::max(smooth, 0.0);
  return part == SmoothPart::kSquare ? std::sqrt(positive) : 2 * std::asin(std::min(1.0, std::sqrt(0.5 * positive)));
}

void ExtremeBounds::take(double value) {
  low_.least = std::min(low_.least, value);
  low_.most = std::min(low_.most, value);
  high_.least = std::min(high_.least, -value);
  high_.most = std::min(high_.most, -value);
}

void ExtremeBounds::add(double time, double value, bool begins) {
  if (begins) {
    finish();
    count_ = searched_ = 0;
  }
  take(value);
  if (count_ > 1 &&
      time - times_[count_ - 1] < kOneKnot * (times_[count_ - 1] - times_[0]) / static_cast<double>(count_ - 1))
    return;
  if (count_ == kPoints) {
    std::copy(times_ + 1, times_ + kPoints, times_);
    std::copy(values_ + 1, values_ + kPoints, values_);
    --count_;
    searched_ -= searched_ > 0 ? 1 : 0;
  }
  times_[count_] = time;
  values_[count_++] = value;
  if (count_ == kPoints)
    while (searched_ < kPoints / 2) search(searched_++);
}

void ExtremeBounds::finish() {
  if (count_ < 3) return;
  while (searched_ + 1 < count_) search(searched_++);
}

void ExtremeBounds::search(std::size_t interval) {
  const auto [least, most] = std::minmax_element(values_, values_ + count_);
  const double beyond = kBeyond * (*most - *least);
  const double low = std::min(values_[interval], values_[interval + 1]);
  const double high = std::max(values_[interval], values_[interval + 1]);
  const bool may_be_low = low - beyond < low_.least, may_be_high = -high - beyond < high_.least;
  if (!(beyond > 0) || !(may_be_low || may_be_high)) return;
  const Stencil stencil({times_, count_}, {values_, count_}, interval);
  if (may_be_low) look(stencil, 1, low_);
  if (may_be_high) look(stencil, -1, high_);
}

// The smallest of the polynomial give or take its uncertainty: at the ends of parts, and where a parabola through three
// of these is least.
void ExtremeBounds::look(const Stencil& stencil, double sign, Bound& bound) const {
  const double part = (stencil.to - stencil.from) / kLooks;
  const auto at = [&](int i) { return stencil.from + i * part; };
  const auto calc = [&](double time, double side) {
    const Stencil::Value value = stencil.calc(time);
    return sign * value.value + side * value.uncertainty;
  };
  for (const double side : {-1.0, 1.0}) {
    double values[kLooks + 1] = {sign * stencil.at_from};
    values[kLooks] = sign * stencil.at_to;
    for (int i = 1; i < kLooks; ++i) values[i] = calc(at(i), side);
    const auto lowest = static_cast<int>(std::min_element(values, values + kLooks + 1) - values);
    double value = values[lowest], time = at(lowest);
    const int middle = std::clamp(lowest, 1, kLooks - 1);
    const double left = values[middle - 1] - values[middle], right = values[middle + 1] - values[middle];
    const double shift = left + right > 0 ? 0.5 * (left - right) / (left + right) : 0;
    if (shift != 0 && std::abs(shift) < 1) {
      const double there = at(middle) + shift * part, vertex = calc(there, side);
      if (vertex < value) value = vertex, time = there;
    }
    if (side > 0) {
      bound.most = std::min(bound.most, value);
    } else if (value < bound.least) {
      bound.least = value;
      bound.time = time;
      bound.spacing = stencil.spacing;
      bound.ratio = stencil.ratio;
    }
  }
}

}  // namespace unlatch::hil
