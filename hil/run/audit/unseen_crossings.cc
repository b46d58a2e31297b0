#include "hil/run/audit/unseen_crossings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hil/run/motion/extreme.h"
#include "hil/scenario/base/index.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

using Kind = Condition::Kind;

constexpr double kYes = 1e100, kNo = -1e100;

ConditionCourse get_course(const Condition& condition) { return get_traits(condition.kind).course; }
bool combines(const Condition& condition) { return get_course(condition) == ConditionCourse::kParts; }

double calc_square(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

// What a condition compares, part by part.
struct Compared {
  bool may_return = false;    // some part, or two that go one way, may become true and false again between knots
  int one_way = 0;            // parts that go one way
  bool by_clearances = true;  // each of those parts has the search of unseen_clearances.h
  std::string missing;        // the first that no knot has, in words
};

void look_at(const Model& model, const Condition& condition, bool negated, Compared& compared) {
  negated = negated || condition.kind == Kind::kNot;
  for (const Condition& part : condition.parts) look_at(model, part, negated, compared);
  if (combines(condition)) return;
  const ConditionTraits& traits = get_traits(condition.kind);
  if (traits.at_knots == ConditionAtKnots::kNowhere && compared.missing.empty())
    compared.missing = describe(model, get_quantity(model, condition));
  if (traits.course == ConditionCourse::kOneWay && ++compared.one_way > 1) {
    compared.may_return = true;
    compared.by_clearances = false;
  }
  if (traits.course != ConditionCourse::kCurve) return;
  compared.may_return = true;
  if (condition.kind != Kind::kDistance || negated || !condition.below) compared.by_clearances = false;
}

}  // namespace

std::vector<UnsearchedEvent> list_unsearched(const Model& model) {
  std::vector<UnsearchedEvent> unsearched;
  for (std::size_t i = 0; i < model.events.size(); ++i) {
    if (model.events[i].when.kind == Kind::kReach) continue;  // unseen_engagements.h
    Compared compared;
    look_at(model, model.events[i].when, false, compared);
    if (compared.may_return && !compared.by_clearances && !compared.missing.empty())
      unsearched.push_back({static_cast<int>(i), compared.missing});
  }
  return unsearched;
}

UnseenCrossings::UnseenCrossings(const Model& model) : model_(model) {
  const Model placed = place_markers(model);
  for (std::size_t i = 0; i < model.events.size(); ++i) {
    Guard guard{.event = static_cast<int>(i), .repeats = model.events[i].repeat};
    if (!list_leaves(model, placed, model.events[i].when, guard.leaves)) continue;
    if (guard.repeats && model.events[i].delay > 0) delayed_.push_back({guard});
    const auto count_leaves = [&](ConditionCourse course) {
      return std::ranges::count_if(guard.leaves,
                                   [&](const Leaf& leaf) { return get_course(leaf.condition) == course; });
    };
    // What changes by events or at ticks is never missed alone, nor is one of what goes one way; two make a span.
    guard.spans = count_leaves(ConditionCourse::kCurve) == 0;
    if (!guard.spans || count_leaves(ConditionCourse::kOneWay) > 1) guards_.push_back(std::move(guard));
  }
}

bool UnseenCrossings::list_leaves(const Model& model, const Model& placed, const Condition& condition,
                                  std::vector<Leaf>& to) {
  if (combines(condition))
    return std::ranges::all_of(condition.parts,
                               [&](const Condition& part) { return list_leaves(model, placed, part, to); });
  const ConditionAtKnots where = get_traits(condition.kind).at_knots;
  if (where == ConditionAtKnots::kNowhere) return false;
  Leaf leaf{.condition = condition, .squared = is_size(get_quantity(model, condition))};
  if (where == ConditionAtKnots::kCoordinates || where == ConditionAtKnots::kSpeeds)
    leaf.joint.emplace(placed, condition.subject);
  to.push_back(std::move(leaf));
  return true;
}

double UnseenCrossings::read(const Leaf& leaf, const MotionKnot& knot, std::span<const double> commands) const {
  const Condition& own = leaf.condition;
  const std::size_t subject = at(own.subject);
  const auto body_at = [&](int body) { return body < 0 ? get_rest() : knot.state.bodies[at(body)]; };
  switch (get_traits(own.kind).at_knots) {
    case ConditionAtKnots::kTime:
      return knot.time;
    case ConditionAtKnots::kRow: {
      const Joint& joint = model_.joints[subject];
      if (!has_row(joint.modes[at(static_cast<int>(knot.state.joints[subject].mode))].rows, own.axis))
        return own.below ? kYes : kNo;
      return knot.multipliers[6 * subject + at(own.axis)];
    }
    case ConditionAtKnots::kForceRows:
      return calc_square(knot.multipliers.subspan(6 * subject, 3));
    case ConditionAtKnots::kMomentRows:
      return calc_square(knot.multipliers.subspan(6 * subject + 3, 3));
    case ConditionAtKnots::kCoordinates: {
      const double value =
          leaf.joint->calc_coordinate(body_at(leaf.joint->get_base()), body_at(leaf.joint->get_follower()), own.axis);
      constexpr double kTurn = 2 * std::numbers::pi;
      if (own.axis < kRotX) return value;
      const double counted = knot.state.joints[subject].angle[own.axis - kRotX];  // turns from the joint's beginning
      return value - kTurn * std::nearbyint((value - counted) / kTurn);
    }
    case ConditionAtKnots::kSpeeds:
      return leaf.joint->calc_speed(body_at(leaf.joint->get_base()), body_at(leaf.joint->get_follower()), own.axis);
    case ConditionAtKnots::kRates: {
      const Vec3& w = knot.state.bodies[subject].w;
      return dot(w, w);
    }
    case ConditionAtKnots::kQuantities:
      return leaf.squared ? knot.quantities[subject] * knot.quantities[subject] : knot.quantities[subject];
    case ConditionAtKnots::kSignals:
      return knot.state.signals[subject] != 0 ? kYes : kNo;
    case ConditionAtKnots::kModes:
      return knot.state.joints[subject].mode == own.axis ? kYes : kNo;
    case ConditionAtKnots::kEngaged:
      return knot.state.engaged[subject] != 0 ? kYes : kNo;
    case ConditionAtKnots::kCommands:
      return (own.below ? commands[subject] <= own.threshold : commands[subject] >= own.threshold) ? kYes : kNo;
    case ConditionAtKnots::kNowhere:  // no leaf
    case ConditionAtKnots::kInParts:
      break;
  }
  return kNo;
}

void UnseenCrossings::add(Guard& guard, const MotionKnot& knot, std::span<const double> commands, bool begins) const {
  for (Leaf& leaf : guard.leaves) {
    const double value = read(leaf, knot, commands);
    if (get_course(leaf.condition) == ConditionCourse::kSteps) {
      leaf.holds = value > 0;
      continue;
    }
    leaf.curve.add(knot.time, value, begins);
  }
  if (begins) guard.count = 0;
  if (guard.count == 3) {
    std::copy(guard.times + 1, guard.times + 3, guard.times);
    std::copy(guard.below + 1, guard.below + 3, guard.below);
    --guard.count;
  }
  guard.times[guard.count] = knot.time;
  guard.below[guard.count] = -calc(guard, std::nan(""));
  ++guard.count;
}

double UnseenCrossings::calc(const Condition& condition, std::span<const Leaf> leaves, double time, std::size_t& next) {
  if (condition.kind == Kind::kNot) return -calc(condition.parts[0], leaves, time, next);
  if (combines(condition)) {
    double value = calc(condition.parts[0], leaves, time, next);
    for (std::size_t i = 1; i < condition.parts.size(); ++i) {
      const double part = calc(condition.parts[i], leaves, time, next);
      value = condition.kind == Kind::kAll ? std::min(value, part) : std::max(value, part);
    }
    return value;
  }
  const Leaf& leaf = leaves[next++];
  if (get_course(condition) == ConditionCourse::kSteps) return leaf.holds ? kYes : kNo;
  double value = std::isnan(time) ? leaf.curve.get_values().back() : leaf.curve.calc(time);
  if (leaf.squared) value = std::sqrt(std::max(value, 0.0));
  return condition.below ? condition.threshold - value : value - condition.threshold;
}

double UnseenCrossings::calc(const Guard& guard, double time) const {
  std::size_t next = 0;
  return calc(model_.events[at(guard.event)].when, guard.leaves, time, next);
}

// Its third difference is small beside the second: no jump or corner lies between the latest four knots.
bool UnseenCrossings::is_smooth(const Leaf& leaf) {
  constexpr double kSmooth = 0.7;
  if (leaf.curve.get_values().size() < 4) return true;
  const auto t = leaf.curve.get_times().last<4>(), values = leaf.curve.get_values().last<4>();
  double first[3], second[2];
  for (std::size_t i = 0; i < 3; ++i) first[i] = (values[i + 1] - values[i]) / (t[i + 1] - t[i]);
  for (std::size_t i = 0; i < 2; ++i) second[i] = (first[i + 1] - first[i]) / (t[i + 2] - t[i]);
  const double greatest = std::max(std::abs(second[0]), std::abs(second[1]));
  constexpr double kRounding = 1e-12;  // of a line the differences are rounding
  const double size = std::abs(values[3]) + std::abs(values[2]);
  const double span = t[3] - t[1];
  return std::abs(second[1] - second[0]) <= kSmooth * greatest || greatest * span * span <= kRounding * size;
}

// Between the times that the guard compares, and the latest two knots, it has one sign.
void UnseenCrossings::find_span(const Guard& guard) {
  const double *const times = guard.times + guard.count - 2, *const values = guard.below + guard.count - 2;
  if (!(values[0] > 0 && values[1] > 0)) return;
  std::vector<double> ends{times[0], times[1]};
  for (const Leaf& leaf : guard.leaves) {
    const double end = leaf.condition.threshold;
    if (get_course(leaf.condition) == ConditionCourse::kOneWay && end > times[0] && end < times[1]) ends.push_back(end);
  }
  std::ranges::sort(ends);
  for (std::size_t i = 1; i < ends.size(); ++i)
    if (ends[i] > ends[i - 1] && calc(guard, 0.5 * (ends[i - 1] + ends[i])) > 0)
      found_.push_back({guard.event, ends[i - 1], ends[i]});
}

// Searches about the knot before the latest one, if the guard is greatest there of three.
void UnseenCrossings::find(const Guard& guard) {
  const auto function = [&](double time) { return -calc(guard, time); };
  const double *const times = guard.times, *const values = guard.below;
  if (guard.count < 3 || !(values[0] > 0 && values[1] > 0 && values[2] > 0)) return;
  Least least;
  least.take(times[1], values[1]);
  least.look_about(times, values, 0, function);
  constexpr double kNoise = 1e-6;  // of what the guard changes from knot to knot: as much is error of the polynomial
  if (!(least.get_value() < -kNoise * std::max(values[0] - values[1], values[2] - values[1]))) return;
  if (!std::ranges::all_of(guard.leaves, is_smooth)) return;
  const auto cross = [&](double outside) {
    double inside = least.get_time();
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (inside + outside);
      (function(middle) > 0 ? outside : inside) = middle;
    }
    return inside;
  };
  found_.push_back({guard.event, cross(least.get_time() < times[1] ? times[0] : times[1]),
                    cross(least.get_time() < times[1] ? times[1] : times[2])});
}

std::span<const UnseenCrossing> UnseenCrossings::find(const MotionWindow& window, const MotionKnot& from,
                                                      const MotionKnot& to, std::span<const double> commands) {
  found_.clear();
  for (Guard& guard : guards_) {
    const EventPhase phase = from.state.events[at(guard.event)].phase;
    const bool waits = phase == EventPhase::kArmed || (phase == EventPhase::kSpent && guard.repeats);
    if (!waits) {
      guard.rests = true;
      continue;
    }
    const bool begins = guard.rests || !window.has_smooth_readings();
    if (begins) add(guard, from, commands, true);
    add(guard, to, commands, false);
    guard.rests = false;
    guard.spans ? find_span(guard) : find(guard);
  }
  return found_;
}

std::span<const LostTrigger> UnseenCrossings::find_lost(const MotionKnot& from, const MotionKnot& to,
                                                        std::span<const double> commands) {
  lost_.clear();
  for (Delayed& own : delayed_) {
    const int event = own.guard.event;
    for (const MotionKnot* knot : {&from, &to}) {
      if (knot->state.events[at(event)].phase != EventPhase::kPending) {
        own.was_false = false;
        continue;
      }
      add(own.guard, *knot, commands, true);
      const bool holds = calc(own.guard, std::nan("")) >= 0;
      if (holds && own.was_false) lost_.push_back({event, knot->time});
      own.was_false = !holds;
    }
  }
  return lost_;
}

}  // namespace unlatch::hil
