#include "hil/run/extremes/law_curve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hil/scenario/base/index.h"
#include "unlatch/model/law_places.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

constexpr int kLastPart = 6, kMostEvaluations = 400;  // in an interval
constexpr double kSlow = 0.1;                         // ratio of a stencil whose differences fall too slowly for a dip
constexpr double kCorner = 0.5;                       // likewise of what is no distance: of a corner
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

// Of what is smooth of a quantity, its own; each part rises with the quantity.
Course from_smooth(SmoothPart part, const Course& smooth) {
  return {hil::from_smooth(part, smooth.begin), hil::from_smooth(part, smooth.middle),
          hil::from_smooth(part, smooth.end), hil::from_smooth(part, smooth.low), hil::from_smooth(part, smooth.high)};
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
                       .is_angle = get_unit(model, quantity) == "rad",
                       .part = find_smooth_part(quantity),
                       .traits = &get_traits(quantity.kind)});
    }
}

bool LawCurve::begins_anew(std::span<const double> now, double next_time, std::span<const double> next) const {
  return std::ranges::any_of(read_, [&](const Read& read) {
    const double value = now[at(read.quantity)];
    if (read.traits->holds) return value != read.latest;
    return is_straight(*read.traits) &&
           (!is_alike(value, read.latest) ||
            !goes_on(read.curve, next_time, to_smooth(read.part, next[at(read.quantity)])));
  });
}

void LawCurve::add(double time, std::span<const double> quantities, std::span<const double> commands, bool begins) {
  const auto is_jump = [&](const Read& read) {
    return read.is_angle && std::abs(quantities[at(read.quantity)] - read.latest) > std::numbers::pi;
  };
  begins = begins || std::ranges::any_of(read_, [&](const Read& read) {
             return is_jump(read) && !find_middle(read.latest, quantities[at(read.quantity)]);
           });
  // Of knots that are very near to each other one counts.
  const double h = time - latest_.to, last = latest_.to - latest_.from;
  const bool skips = !begins && (knots_ > 1 ? h < ValueStencil::kOneKnot * last : !(h > 0));
  const bool replaces = !begins && !skips && knots_ > 1 && last < ValueStencil::kOneKnot * h;
  for (Read& read : read_) {
    const double value = quantities[at(read.quantity)];
    if (!begins && is_jump(read)) {
      read.turned += kTurn * std::nearbyint((read.latest - value) / kTurn);
      read.middle = find_middle(read.latest, value);
    }
    if (begins) read.turned = 0;
    read.latest = value;
    if (skips) continue;
    if (replaces) read.curve.drop_latest();
    read.curve.add(time, to_smooth(read.part, value + read.turned), begins);
    if (!begins) read.usual.add(read.curve.get_times(), read.curve.get_values());
  }
  if (skips) return;
  if (!replaces) {
    knots_ = begins ? 1 : std::min(knots_ + 1, kCurvePoints);
    std::swap(before_, latest_);
    latest_.from = before_.to;
  }
  latest_.to = time;
  latest_.commands.assign(commands.begin(), commands.end());
}

void LawCurve::search(Extreme extreme, Found& found) {
  if (knots_ > 2) search(before_, at(knots_ - 3), extreme == Extreme::kLow ? 1 : -1, found);
}

void LawCurve::finish(Extreme extreme, Found& found) {
  if (knots_ > 1) search(latest_, at(knots_ - 2), extreme == Extreme::kLow ? 1 : -1, found);
}

void LawCurve::learn_from(const LawCurve& other) {
  for (std::size_t i = 0; i < read_.size(); ++i) read_[i].usual = other.read_[i].usual;
}

void LawCurve::follow(const LawCurve& other) {
  learn_from(other);
  size_ = other.size_;
  follows_ = true;
}

Course LawCurve::Read::calc_smooth_course(double from, double to, double off) const {
  const auto calc = [&](double time) { return stencil->calc(time).value + off * calc_uncertainty(time); };
  return Course::of_parabola(calc(from), calc(0.5 * (from + to)), calc(to));
}

// Of an angle, within its range: where it goes on at the other end in between, it may be anything there.
Course LawCurve::Read::calc_course(double from, double to, double off) const {
  const Course whole = from_smooth(part, calc_smooth_course(from, to, off));
  if (!middle) return whole;
  const auto count_turns = [&](double angle) { return std::nearbyint((angle - *middle) / kTurn); };
  const auto wrap = [&](double angle) { return angle - kTurn * count_turns(angle); };
  Course course{wrap(whole.begin), wrap(whole.middle), wrap(whole.end), *middle - 0.5 * kTurn, *middle + 0.5 * kTurn};
  if (count_turns(whole.low) == count_turns(whole.high)) course.low = wrap(whole.low), course.high = wrap(whole.high);
  return course;
}

double LawCurve::Read::calc_uncertainty(double time) const {
  if (is_exact()) return 0;
  const double passed = (time - stencil->get_from()) / (stencil->get_to() - stencil->get_from());
  if (bulge > 0) return bulge * 4 * passed * (1 - passed);
  const auto [smooth, uncertainty] = stencil->calc(time);
  if (secants)
    return std::max(uncertainty, secants->are_below() ? smooth - secants->calc(time) : secants->calc(time) - smooth);
  // A square below zero is wrong by as much, and may be by twice that.
  return part == SmoothPart::kItself ? uncertainty : std::max(uncertainty, -2 * smooth);
}

void LawCurve::Read::draw_secants(std::size_t number) {
  const std::span<const double> times = curve.get_times(), values = curve.get_values();
  secants.reset();
  const bool is_distance = traits == &get_traits(unlatch::Quantity::Kind::kClearance);
  if (number == 0 || number + 2 >= times.size() || !(stencil->get_ratio() > (is_distance ? kSlow : kCorner))) return;
  const auto calc_slope = [&](std::size_t k) { return (values[k + 1] - values[k]) / (times[k + 1] - times[k]); };
  const double before = calc_slope(number - 1), behind = calc_slope(number + 1);
  const double own = calc_slope(number);
  if ((before < own && own < behind) || (before > own && own > behind))
    secants = {times[number], values[number], before, times[number + 1], values[number + 1], behind};
}

// The law and its bounds from one time to another, what it reads being a parabola through the three instants.
void LawCurve::update(const Interval& interval, double from, double to) {
  for (const Read& read : read_) quantities_[at(read.quantity)] = read.calc_course(from, to, 0);
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

// The law and its bounds in an interval, if each that it reads is anything within its uncertainty; whether that is a
// part of the way of some that matters.
LawCurve::Wide LawCurve::calc_wide(const Interval& interval) {
  constexpr double kAside = 1.2;  // the largest uncertainty is beside the middle
  constexpr double kPart = 1e-5;
  const double middle = 0.5 * (interval.from + interval.to);
  bool is_off = false;
  for (const Read& read : read_) {
    Course& course = quantities_[at(read.quantity)];
    course = read.calc_course(interval.from, interval.to, 0);
    double off = kAside * read.calc_uncertainty(middle);
    if (read.secants) off = std::max(off, read.calc_uncertainty(read.secants->calc_meeting()));
    const double low = to_smooth(read.part, course.low), high = to_smooth(read.part, course.high);
    is_off = is_off || off > kPart * (high - low);
    course.low = std::min(course.low, from_smooth(read.part, low - off));
    course.high = std::max(course.high, from_smooth(read.part, high + off));
  }
  courses_.update(behind_, interval.commands, quantities_);
  return {courses_.get(law_), is_off};
}

// What the law may be at most below what was found, and what was found above the smallest value, by the uncertainties
// of what it reads.
void LawCurve::doubt(const Interval& interval, double sign, Found& found) {
  constexpr int kLooks = 8;
  const double length = interval.to - interval.from, room = calc_room(found.value.get_value());
  const auto look_at = [&](double time) {
    const double value = sign * calc(interval, time);
    double below = 0, above = 0;
    bool is_pair = false;
    for (const Read& read : read_) {
      if (read.calc_uncertainty(time) == 0) continue;
      Course& course = quantities_[at(read.quantity)];
      const Course own = course;
      double lower = 0;
      for (const double off : {-1.0, 1.0}) {
        course = read.calc_course(time, time, off);
        courses_.update(behind_, interval.commands, quantities_);
        const double change = sign * courses_.get(law_).middle - value;
        lower = std::max(lower, -change);
        above += std::max(0.0, change);
      }
      course = own;
      below += lower;
      is_pair = is_pair || (read.bulge > 0 && lower > 0.5 * room);
    }
    if (is_pair && !follows_)
      found.unsearched = std::min(found.unsearched, value - below);
    else
      found.least = std::min(found.least, value - below);
    found.most = std::min(found.most, value + above);
  };
  for (int i = 1; i < kLooks; ++i) look_at(interval.from + i * length / kLooks);
  for (const Read& read : read_)
    if (read.secants) look_at(read.secants->calc_meeting());
  const double best = found.value.get_time();
  if (best > interval.from && best < interval.to) look_at(best);
}

// `number`: of the knot at which the interval begins, among those that are kept.
void LawCurve::search(const Interval& interval, std::size_t number, double sign, Found& found) {
  for (Read& read : read_) {
    const std::span<const double> times = read.curve.get_times(), values = read.curve.get_values();
    read.stencil.emplace(times, values, number);
    read.draw_secants(number);
    const double from = values[number], to = values[number + 1], h = times[number + 1] - times[number];
    read.bulge = 0;
    if (times.size() == 2)
      read.bulge = follows_ ? read.usual.calc_bulge(from, to, h) : read.usual.calc_change(from, to, h);
    found.is_unknown =
        found.is_unknown || (times.size() == 2 && !follows_ && !read.is_exact() && !read.usual.is_known());
  }
  const auto [wide, is_off] = calc_wide(interval);
  const double middle = sign * wide.middle, before = found.value.get_value(), known = std::min(before, middle);
  const auto get_bound = [sign](const Course& course) { return sign > 0 ? course.low : -course.high; };
  const double size = std::max({std::abs(wide.begin), std::abs(wide.middle), std::abs(wide.end)});
  size_ = std::max(size_, size);
  const bool may_be_wrong = is_off && middle < before;
  if (get_bound(wide) >= known - kGain * size && !may_be_wrong)
    return found.take(0.5 * (interval.from + interval.to), middle);
  left_ = kMostEvaluations;
  look(interval, interval.from, interval.to, sign, 0, found.value);
  const double value = found.value.get_value();
  if (is_off && get_bound(wide) < before - calc_room(value))
    doubt(interval, sign, found);
  else
    found.most = std::min(found.most, value);
}

}  // namespace unlatch::hil
