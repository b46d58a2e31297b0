#include "hil/run/extremes/extreme_bounds.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "hil/run/motion/extreme.h"

namespace unlatch::hil {
namespace {

constexpr int kLooks = 8;          // of an interval, at whose ends the polynomial is evaluated
constexpr double kOneKnot = 1e-6;  // of the spacing: of knots that are nearer to each other one counts
constexpr double kBeyond = 8;      // times what six knots span: a polynomial through them goes no farther between them
constexpr double kLeastFall = 1e-14;  // of values: rounding of a difference
// Part of an extreme to which it is to be known; one that is small counts as this part of the largest value.
constexpr double kFine = 1e-4, kFloor = 1e-4;

}  // namespace

// Newton's form about one interval, its knots taken from the middle outwards.
struct ExtremeBounds::Stencil {
  Stencil(std::span<const double> times, std::span<const double> values, std::size_t interval);
  // How far the polynomial, give or take what it may be off, is at most from the chord between the interval's ends:
  // by its terms and its parabolas, whatever the ratio is, and beyond the rounding of calc().
  [[nodiscard]] double calc_most_departure() const;
  // Before calc(): by how much it may be off depends on all differences.
  void measure_ratio();
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
  double differences_[kPoints][kPoints] = {};  // divided: of order k from knot i on
  std::optional<Side> before_, behind_;
};

ExtremeBounds::Stencil::Stencil(std::span<const double> times, std::span<const double> values, std::size_t interval)
    : count(times.size()),
      from(times[interval]),
      to(times[interval + 1]),
      at_from(values[interval]),
      at_to(values[interval + 1]) {
  std::copy(values.begin(), values.end(), differences_[0]);
  for (std::size_t k = 1; k < count; ++k)
    for (std::size_t i = 0; i + k < count; ++i)
      differences_[k][i] = (differences_[k - 1][i + 1] - differences_[k - 1][i]) / (times[i + k] - times[i]);
  // From the interval outwards, to either side in turn as far as there are knots.
  std::size_t first = interval, last = interval + 1;
  order[0] = times[first];
  order[1] = times[last];
  terms[0] = differences_[0][first];
  terms[1] = differences_[1][first];
  for (std::size_t k = 2; k < count; ++k) {
    const bool to_left = first > 0 && (last + 1 == count || interval - first <= last - interval - 1);
    order[k] = to_left ? times[--first] : times[++last];
    terms[k] = differences_[k][first];
  }
  spacing = (times[count - 1] - times[0]) / static_cast<double>(count - 1);
  if (interval < 2 || interval + 4 > count) return;
  const auto& d = differences_;
  const std::size_t i = interval, k = interval + 1;
  before_ = {times[i], times[i - 1], {d[0][i], d[1][i - 1], d[2][i - 2]}};
  behind_ = {times[k], times[k + 1], {d[0][k], d[1][k], d[2][k]}};
}

double ExtremeBounds::Stencil::calc_most_departure() const {
  constexpr double kRounding = 1e-12;  // of calc(), of the largest number in it; some thousand times what it is
  const double h = to - from;
  double curve = 0, way = 0.25 * (h * h), last = 0, before = 0;
  for (std::size_t k = 2; k < count; ++k) {
    before = last;
    last = way * std::abs(terms[k]);
    curve += last;
    way *= std::max(std::abs(from - order[k]), std::abs(to - order[k]));
  }
  double aside = 0;  // of the nearer parabola from the chord
  if (before_) {
    const auto calc_aside = [&](const Side& side, double far) {
      return h * (std::abs(terms[1] - side.terms[1]) + std::abs(far - side.next) * std::abs(side.terms[2]));
    };
    aside = std::min(calc_aside(*before_, to), calc_aside(*behind_, from));
  }
  const double most = curve + std::max({last, before, curve + aside});
  const double size = std::max(std::abs(at_from), std::abs(at_to)) + (most + h * std::abs(terms[1]));
  return most + kRounding * size;
}

void ExtremeBounds::Stencil::measure_ratio() {
  // The largest difference of each order, as of knots of equal spacing.
  double sizes[kPoints] = {}, scale = 1;
  for (std::size_t k = 0; k < count; ++k) {
    if (k > 0) scale *= static_cast<double>(k) * spacing;
    for (std::size_t i = 0; i + k < count; ++i) sizes[k] = std::max(sizes[k], scale * std::abs(differences_[k][i]));
  }
  const auto fall = [&](std::size_t k, std::size_t by) {
    return sizes[k] > kLeastFall * sizes[0] ? std::min(1.0, sizes[k] / sizes[k - by]) : 0;
  };
  if (count == 3) ratio = fall(2, 1);
  if (count == 4) ratio = std::sqrt(fall(3, 2));
  if (count > 4) ratio = std::sqrt(fall(4, 2));
  if (count > 5) ratio = std::max(ratio, std::sqrt(fall(5, 2)));
  doubt = ratio * ratio * ratio * ratio;
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

namespace {

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

void ExtremeBounds::add(const ValueKnot& knot, FinerValues* finer) {
  if (knot.begins) {
    finish(finer);
    count_ = searched_ = 0;
  }
  if (knot.time >= from_ && knot.time <= to_) take(knot.time, knot.value);
  size_ = std::max(size_, std::abs(knot.value));
  if (count_ == 1 && !(knot.time > times_[0])) return;
  if (count_ > 1 &&
      knot.time - times_[count_ - 1] < kOneKnot * (times_[count_ - 1] - times_[0]) / static_cast<double>(count_ - 1))
    return;
  if (count_ == kPoints) {
    std::copy(times_ + 1, times_ + kPoints, times_);
    std::copy(values_ + 1, values_ + kPoints, values_);
    --count_;
    searched_ -= searched_ > 0 ? 1 : 0;
  }
  times_[count_] = knot.time;
  values_[count_++] = knot.value;
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
  const double middle = 0.5 * (times_[interval] + times_[interval + 1]);
  return middle < from_ || middle > to_;
}

// Nothing is known of what is between the two.
void ExtremeBounds::search_pair(FinerValues* finer, Side side) const {
  const double at_from = side.sign * values_[0], at_to = side.sign * values_[1], change = std::abs(at_from - at_to);
  const double least = std::min(at_from, at_to) - change;
  if (!(least < side.bound->value) || change <= kFine * std::max(std::abs(at_from), kFloor * size_)) return;
  if (!refine(times_[0], times_[1], finer, side)) side.bound->unsearched = std::min(side.bound->unsearched, least);
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
  Stencil stencil({times_, count_}, {values_, count_}, interval);
  const double departure = stencil.calc_most_departure();
  const bool changes_low = may_be_low && !(low - departure >= get_greatest(low_));
  const bool changes_high = may_be_high && !(-high - departure >= get_greatest(high_));
  if (!changes_low && !changes_high) return;
  stencil.measure_ratio();
  if (changes_low) search(stencil, finer, {1, &low_});
  if (changes_high) search(stencil, finer, {-1, &high_});
}

void ExtremeBounds::search(const Stencil& stencil, FinerValues* finer, Side side) const {
  const Bound own = look(stencil, side);
  if (own.least < side.bound->value && !is_known(own) && refine(stencil.from, stencil.to, finer, side)) return;
  merge(own, *side.bound);
}

bool ExtremeBounds::is_known(const Bound& bound) const {
  return bound.most - bound.least <= kFine * std::max(std::abs(bound.value), kFloor * size_);
}

// False if nothing finer is known there.
bool ExtremeBounds::refine(double from, double to, FinerValues* finer, Side side) const {
  const std::span<const ValueKnot> knots = finer != nullptr ? finer->list(from, to) : std::span<const ValueKnot>{};
  if (knots.empty()) return false;
  ExtremeBounds bounds;
  bounds.size_ = size_;
  bounds.from_ = from;
  bounds.to_ = to;
  for (const ValueKnot& knot : knots) bounds.add(knot);
  bounds.finish();
  const Bound& found = side.sign > 0 ? bounds.low_ : bounds.high_;
  merge(found, *side.bound);
  side.bound->unsearched = std::min(side.bound->unsearched, found.unsearched);
  return true;
}

// The smallest of the polynomial give or take its uncertainty: at the ends of parts, and where a parabola through three
// of these is least.
ExtremeBounds::Bound ExtremeBounds::look(const Stencil& stencil, Side side) const {
  const double part = (stencil.to - stencil.from) / kLooks;
  const auto at = [&](int i) { return stencil.from + i * part; };
  const auto calc = [&](double time, double off) {
    const Stencil::Value value = stencil.calc(time);
    return side.sign * value.value + off * value.uncertainty;
  };
  Bound found;
  found.spacing = stencil.spacing;
  found.ratio = stencil.ratio;
  for (const double off : {-1.0, 1.0, 0.0}) {
    double values[kLooks + 1] = {side.sign * stencil.at_from};
    values[kLooks] = side.sign * stencil.at_to;
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
  if (found.found > stencil.from && found.found < stencil.to) found.most = std::min(found.most, calc(found.found, 1));
  found.least = std::min(found.least, found.value);
  found.most = std::max(found.most, found.value);
  return found;
}

}  // namespace unlatch::hil
