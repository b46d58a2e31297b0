#include "hil/run/extremes/extreme_bounds.h"

#include <algorithm>
#include <cmath>

#include "hil/run/extremes/value_stencil.h"
#include "hil/run/motion/extreme.h"

namespace unlatch::hil {
namespace {

// Knots from which the error of a polynomial through them is hardly known; by how many times their usual change it may
// be, for that a step is taken again.
constexpr std::size_t kFewKnots = 4;
constexpr double kSure = 2;
constexpr int kLooks = 8;      // of an interval, at whose ends the polynomial is evaluated
constexpr double kBeyond = 8;  // times what six knots span: a polynomial through them goes no farther between them
// Part of an extreme to which it is to be known; one that is small counts as this part of the largest value.
constexpr double kFine = 1e-4, kFloor = 1e-4;
// Ratio of a stencil's differences from which they do not fall: a dip is shorter than what lies between the knots.
constexpr double kRough = 0.5;

void take_smallest(ExtremeBounds::Bound& bound, double time, double value) {
  bound.least = std::min(bound.least, value);
  bound.most = std::min(bound.most, value);
  if (value < bound.value) bound.value = value, bound.found = time;
}

void merge(const ExtremeBounds::Bound& from, ExtremeBounds::Bound& to) {
  if (from.least < to.least) {
    to.least = from.least;
    to.time = from.time;
    to.spacing = from.spacing;
    to.ratio = from.ratio;
  }
  to.most = std::min(to.most, from.most);
  if (from.value < to.value) to.value = from.value, to.found = from.found;
}

}  // namespace

void ExtremeBounds::take(double time, double value) {
  take_smallest(low_, time, value);
  take_smallest(high_, time, -value);
}

// Between two times a knot counts as the end of a piece that is there: at these times there may be others, on the other
// side of a jump.
void ExtremeBounds::take(const ValueKnot& knot) {
  const auto take_within = [this](const ValueKnot& own) {
    if (own.time >= from_ && own.time <= to_) take(own.time, own.value);
  };
  if (!is_within_) {
    take(knot.time, knot.value);
  } else if (!knot.begins && is_here(0.5 * (latest_.time + knot.time))) {
    take_within(latest_);
    take_within(knot);
  }
  latest_ = knot;
}

void ExtremeBounds::add(const ValueKnot& knot, FinerValues* finer) {
  if (knot.begins) {
    finish(finer);
    count_ = searched_ = 0;
  }
  take(knot);
  size_ = std::max(size_, std::abs(knot.value));
  if (count_ == 1 && !(knot.time > times_[0])) return;
  if (count_ > 1 && knot.time - times_[count_ - 1] <
                        ValueStencil::kOneKnot * (times_[count_ - 1] - times_[0]) / static_cast<double>(count_ - 1))
    return;
  if (count_ > 1 && times_[count_ - 1] - times_[count_ - 2] < ValueStencil::kOneKnot * (knot.time - times_[count_ - 1]))
    --count_;
  if (count_ == kPoints) {
    std::copy(times_ + 1, times_ + kPoints, times_);
    std::copy(values_ + 1, values_ + kPoints, values_);
    --count_;
    searched_ -= searched_ > 0 ? 1 : 0;
  }
  times_[count_] = knot.time;
  values_[count_++] = knot.value;
  if (count_ > 1) usual_.add({times_, count_}, {values_, count_});
  if (count_ == kPoints)
    while (searched_ < kPoints / 2) search(searched_++, finer);
}

void ExtremeBounds::finish(FinerValues* finer) {
  if (count_ < 2) return;
  if (count_ == 2) {
    if (searched_++ > 0 || leaves_out(0)) return;
    search_pair(finer, {1, &low_});
    search_pair(finer, {-1, &high_});
    return;
  }
  while (searched_ + 1 < count_) search(searched_++, finer);
}

bool ExtremeBounds::leaves_out(std::size_t interval) const {
  return !is_here(0.5 * (times_[interval] + times_[interval + 1]));
}

// Of what is between the two it is known only how the quantity has changed elsewhere. Within a step that was taken
// again, that is how its rate has.
void ExtremeBounds::search_pair(FinerValues* finer, Side side) const {
  const double h = times_[1] - times_[0];
  const double at_from = side.sign * values_[0], at_to = side.sign * values_[1], end = std::min(at_from, at_to);
  if (is_within_) {
    const double bulge = std::max(usual_.calc_bulge(values_[0], values_[1], h), std::abs(at_to - at_from));
    merge({.least = end - bulge, .most = end, .time = 0.5 * (times_[0] + times_[1]), .spacing = h, .ratio = 1},
          *side.bound);
    return;
  }
  const double change = usual_.calc_change(values_[0], values_[1], h), least = end - change;
  const bool may_be_beyond = may_matter(end, change, side);
  if (!may_be_beyond && usual_.is_known()) return;
  if (refine(times_[0], times_[1], finer, side)) return;
  if (may_be_beyond && least < side.bound->value) side.bound->unsearched = std::min(side.bound->unsearched, least);
}

// Whether what is beyond the smaller end by kSure times so much would be an extreme that matters.
bool ExtremeBounds::may_matter(double end, double change, Side side) const {
  return end - kSure * change < side.bound->value && change > kFine * std::max(std::abs(end), kFloor * size_);
}

namespace {

// What is not smaller than this changes nothing of a bound.
double get_greatest(const ExtremeBounds::Bound& bound) { return std::max({bound.least, bound.most, bound.value}); }

}  // namespace

void ExtremeBounds::search(std::size_t interval, FinerValues* finer) {
  const auto [least, most] = std::minmax_element(values_, values_ + count_);
  const double beyond = kBeyond * (*most - *least);
  const double low = std::min(values_[interval], values_[interval + 1]);
  const double high = std::max(values_[interval], values_[interval + 1]);
  const bool may_be_low = low - beyond < low_.value, may_be_high = -high - beyond < high_.value;
  if (!(beyond > 0) || !(may_be_low || may_be_high) || leaves_out(interval)) return;
  const ValueTerms terms({times_, count_}, {values_, count_}, interval);
  bool changes_low = may_be_low, changes_high = may_be_high;
  if (count_ == kPoints) {  // of fewer knots the polynomial's error is hardly known
    const double departure = terms.calc_most_departure();
    changes_low = may_be_low && !(low - departure >= get_greatest(low_));
    changes_high = may_be_high && !(-high - departure >= get_greatest(high_));
    if (!changes_low && !changes_high) return;
  }
  const ValueStencil stencil(terms);
  if (changes_low) search(stencil, finer, {1, &low_});
  if (changes_high) search(stencil, finer, {-1, &high_});
}

void ExtremeBounds::search(const ValueStencil& stencil, FinerValues* finer, Side side) const {
  // Of few knots the polynomial's error is hardly known.
  if (count_ <= kFewKnots && !is_within_) {
    const double from = stencil.get_at_from(), to = stencil.get_at_to(), h = stencil.get_to() - stencil.get_from();
    const double end = std::min(side.sign * from, side.sign * to);
    if (may_matter(end, usual_.calc_change(from, to, h), side) &&
        refine(stencil.get_from(), stencil.get_to(), finer, side))
      return;
  }
  Bound own = look(stencil, side);
  if (is_within_ && !is_known(own) && own.ratio > kRough) {
    own.least = std::min(own.least, calc_least_by_secants(stencil.get_from(), side));
    own.most = std::max(own.most, std::min(side.sign * stencil.get_at_from(), side.sign * stencil.get_at_to()));
  }
  if (own.least < side.bound->value && !is_known(own) && refine(stencil.get_from(), stencil.get_to(), finer, side))
    return;
  merge(own, *side.bound);
}

bool ExtremeBounds::is_known(const Bound& bound) const {
  return bound.most - bound.least <= kFine * std::max(std::abs(bound.value), kFloor * size_);
}

// Where the secant of the interval before this one and that of the interval behind it meet within it: a convex dip does
// not go below. Infinity if there is no such point.
double ExtremeBounds::calc_least_by_secants(double from, Side side) const {
  const auto i = static_cast<std::size_t>(std::find(times_, times_ + count_, from) - times_);
  if (i == 0 || i + 2 >= count_) return std::numeric_limits<double>::infinity();
  const auto calc_slope = [&](std::size_t k) {
    return side.sign * (values_[k + 1] - values_[k]) / (times_[k + 1] - times_[k]);
  };
  const double before = calc_slope(i - 1), behind = calc_slope(i + 1), h = times_[i + 1] - times_[i];
  const double at_from = side.sign * values_[i], at_to = side.sign * values_[i + 1];
  if (!(before < 0 && behind > 0)) return std::numeric_limits<double>::infinity();
  const double s = (at_to - at_from - behind * h) / (before - behind);
  return s > 0 && s < h ? at_from + before * s : std::numeric_limits<double>::infinity();
}

// False if nothing finer is known there.
bool ExtremeBounds::refine(double from, double to, FinerValues* finer, Side side) const {
  const std::span<const ValueKnot> knots = finer != nullptr ? finer->list(from, to) : std::span<const ValueKnot>{};
  if (knots.empty()) return false;
  ExtremeBounds learning;  // how the quantity changes there, before any pair of knots is judged by that
  learning.is_within_ = true;
  learning.from_ = learning.to_ = std::numeric_limits<double>::infinity();
  learning.usual_ = usual_;
  for (const ValueKnot& knot : knots) learning.add(knot);
  ExtremeBounds bounds;
  bounds.size_ = size_;
  bounds.is_within_ = true;
  bounds.from_ = from;
  bounds.to_ = to;
  bounds.usual_ = learning.usual_;
  for (const ValueKnot& knot : knots) bounds.add(knot);
  bounds.finish();
  const Bound& found = side.sign > 0 ? bounds.low_ : bounds.high_;
  merge(found, *side.bound);
  side.bound->unsearched = std::min(side.bound->unsearched, found.unsearched);
  return true;
}

// The smallest of the polynomial give or take its uncertainty: at the ends of parts, and where a parabola through three
// of these is least.
ExtremeBounds::Bound ExtremeBounds::look(const ValueStencil& stencil, Side side) const {
  const double part = (stencil.get_to() - stencil.get_from()) / kLooks;
  const auto at = [&](int i) { return stencil.get_from() + i * part; };
  const auto calc = [&](double time, double off) {
    const ValueStencil::Value value = stencil.calc(time);
    return side.sign * value.value + off * value.uncertainty;
  };
  Bound found;
  found.spacing = stencil.get_spacing();
  found.ratio = stencil.get_ratio();
  for (const double off : {-1.0, 1.0, 0.0}) {
    double values[kLooks + 1] = {side.sign * stencil.get_at_from()};
    values[kLooks] = side.sign * stencil.get_at_to();
    for (int i = 1; i < kLooks; ++i) values[i] = calc(at(i), off);
    const auto lowest = static_cast<int>(std::min_element(values, values + kLooks + 1) - values);
    double value = values[lowest], time = at(lowest);
    const int middle = std::clamp(lowest, 1, kLooks - 1);
    const double left = values[middle - 1] - values[middle], right = values[middle + 1] - values[middle];
    const double shift = left + right > 0 ? 0.5 * (left - right) / (left + right) : 0;
    if (shift != 0 && std::abs(shift) < 1) {
      const double there = at(middle) + shift * part, vertex = calc(there, off);
      if (vertex < value) value = vertex, time = there;
      if (off == 0 && value < side.bound->value) {
        Least least;
        least.search(at(middle - 1), at(middle + 1), [&](double t) { return calc(t, 0); });
        if (least.get_value() < value) value = least.get_value(), time = least.get_time();
      }
    }
    if (off > 0) found.most = value;
    if (off < 0) found.least = value, found.time = time;
    if (off == 0) found.value = value, found.found = time;
  }
  if (found.found > stencil.get_from() && found.found < stencil.get_to())
    found.most = std::min(found.most, calc(found.found, 1));
  found.least = std::min(found.least, found.value);
  found.most = std::max(found.most, found.value);
  return found;
}

}  // namespace unlatch::hil
