#include "hil/run/extremes/law_curve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hil/run/extremes/straight_quantity.h"
#include "hil/scenario/base/index.h"
#include "unlatch/model/law_places.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

constexpr int kLastPart = 6, kMostEvaluations = 400;  // in an interval
constexpr double kOffLine = 1e-9;                     // of the value's size: rounding of a straight line
constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kGain = 1e-7;  // what bounds may promise below the known, relative to the law's size

bool is_alike(double value, double other) {
  return std::abs(value - other) <= kOffLine * std::max(1.0, std::abs(value));
}

// Whether a straight line goes on to this value.
bool goes_on(const SampledCurve& curve, double time, double value) {
  const std::span<const double> times = curve.get_times(), values = curve.get_values();
  if (times.empty()) return true;
  const std::size_t count = std::min<std::size_t>(times.size(), 2);
  const double expected = count == 1 ? value : interpolate(times.last(2), values.last(2), time);
  return is_alike(value, expected);
}

// Middle of the range of an angle that has come from one end to the other, rad; none for angles that have no such
// range.
std::optional<double> find_middle(double from, double to) {
  const double middle = std::min(from, to) < -0.5 * std::numbers::pi ? 0 : std::numbers::pi;
  const auto is_within = [&](double angle) { return std::abs(angle - middle) <= std::numbers::pi; };
  return is_within(from) && is_within(to) ? std::optional(middle) : std::nullopt;
}

}  // namespace

LawCurve::LawCurve(const Model& model, const Plan& plan, int law)
    : law_(law), behind_(list_laws_behind(model, law)), courses_(model, plan), quantities_(model.quantities.size()) {
  for (const int own : behind_)
    for (const LawStep& step : model.laws[at(own)].steps) {
      if (step.kind != LawStep::Kind::kQuantity) continue;
      const unlatch::Quantity& quantity = model.quantities[at(step.subject)];
      const bool is_known = std::ranges::any_of(read_, [&](const Read& read) { return read.quantity == step.subject; });
      if (quantity.kind == unlatch::Quantity::Kind::kLaw || is_known) continue;
      read_.push_back({.quantity = step.subject,
                       .curve = {},
                       .is_angle = get_unit(model, quantity) == "rad",
                       .traits = &get_traits(quantity.kind),
                       .middle = {}});
    }
}

bool LawCurve::begins_anew(std::span<const double> now, double next_time, std::span<const double> next) const {
  return std::ranges::any_of(read_, [&](const Read& read) {
    const double value = now[at(read.quantity)];
    if (read.traits->holds) return value != read.latest;
    return is_straight(*read.traits) &&
           (!is_alike(value, read.latest) || !goes_on(read.curve, next_time, next[at(read.quantity)]));
  });
}

void LawCurve::add(double time, std::span<const double> quantities, std::span<const double> commands, bool begins) {
  const auto is_jump = [&](const Read& read) {
    return read.is_angle && std::abs(quantities[at(read.quantity)] - read.latest) > std::numbers::pi;
  };
  begins = begins || std::ranges::any_of(read_, [&](const Read& read) {
             return is_jump(read) && !find_middle(read.latest, quantities[at(read.quantity)]);
           });
  for (Read& read : read_) {
    const double value = quantities[at(read.quantity)];
    if (!begins && is_jump(read)) {
      read.turned += kTurn * std::nearbyint((read.latest - value) / kTurn);
      read.middle = find_middle(read.latest, value);
    }
    if (begins) read.turned = 0;
    read.latest = value;
    read.curve.add(time, value + read.turned, begins);
  }
  knots_ = begins ? 1 : std::min(knots_ + 1, kCurvePoints);
  std::swap(before_, latest_);
  latest_.from = before_.to;
  latest_.to = time;
  latest_.commands.assign(commands.begin(), commands.end());
}

void LawCurve::search(Smallest* low, Smallest* high) {
  if (knots_ < 3) return;
  if (low != nullptr) search(before_, 1, *low);
  if (high != nullptr) search(before_, -1, *high);
}

void LawCurve::finish(Smallest* low, Smallest* high) {
  if (knots_ < 2) return;
  if (low != nullptr) search(latest_, 1, *low);
  if (high != nullptr) search(latest_, -1, *high);
}

// Of an angle, within its range: where it goes on at the other end in between, it may be anything there.
Course LawCurve::Read::calc_course(double from, double to) const {
  const Course whole = Course::of_parabola(curve.calc(from), curve.calc(0.5 * (from + to)), curve.calc(to));
  if (!middle) return whole;
  const auto count_turns = [&](double angle) { return std::nearbyint((angle - *middle) / kTurn); };
  const auto wrap = [&](double angle) { return angle - kTurn * count_turns(angle); };
  Course course{wrap(whole.begin), wrap(whole.middle), wrap(whole.end), *middle - 0.5 * kTurn, *middle + 0.5 * kTurn};
  if (count_turns(whole.low) == count_turns(whole.high)) course.low = wrap(whole.low), course.high = wrap(whole.high);
  return course;
}

// The law and its bounds from one time to another, what it reads being a parabola through the three instants.
void LawCurve::update(const Interval& interval, double from, double to) {
  for (const Read& read : read_) quantities_[at(read.quantity)] = read.calc_course(from, to);
  courses_.update(behind_, interval.commands, quantities_);
}

double LawCurve::calc(const Interval& interval, double time) {
  update(interval, time, time);
  return courses_.get(law_).middle;
}

// Where the bounds still admit a smaller value at the last bisection, the part is searched by golden section.
void LawCurve::look(const Interval& interval, double from, double to, double sign, int depth, Smallest& found) {
  update(interval, from, to);
  --left_;
  const Course course = courses_.get(law_);
  const double middle = 0.5 * (from + to);
  found.take(middle, sign * course.middle);
  const double bound = sign > 0 ? course.low : -course.high;
  const double size = std::max({std::abs(course.begin), std::abs(course.middle), std::abs(course.end)});
  if (bound >= found.get_value() - kGain * size || left_ <= 0) return;
  if (depth == kLastPart) {
    found.search(from, to, [&](double time) {
      --left_;
      return sign * calc(interval, time);
    });
    return;
  }
  look(interval, from, middle, sign, depth + 1, found);
  look(interval, middle, to, sign, depth + 1, found);
}

void LawCurve::search(const Interval& interval, double sign, Smallest& found) {
  left_ = kMostEvaluations;
  look(interval, interval.from, interval.to, sign, 0, found);
}

}  // namespace unlatch::hil
