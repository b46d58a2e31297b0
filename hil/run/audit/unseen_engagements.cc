#include "hil/run/audit/unseen_engagements.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hil/run/motion/extreme.h"
#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

bool is_on(const ElementState& element, double time) { return element.to != 0 || calc_scale(element, time) != 0; }

BodyState get_body(const MotionKnot& knot, int body) { return body < 0 ? get_rest() : knot.state.bodies[at(body)]; }

}  // namespace

UnseenEngagements::UnseenEngagements(const Model& model) {
  const Model placed = place_markers(model);
  std::size_t drums = 0;
  for (std::size_t i = 0; i < model.one_sided.size(); ++i) {
    const OneSided& own = placed.one_sided[i];
    Force force{.own = own, .number = static_cast<int>(i), .begin = kNone, .end = kNone};
    if (own.drum) force.drum_number = drums++;
    for (std::size_t e = 0; e < model.events.size(); ++e) {
      const Condition& when = model.events[e].when;
      if (when.kind != Condition::Kind::kReach || when.subject != force.number) continue;
      (when.below ? force.end : force.begin) = static_cast<int>(e);
    }
    if (force.begin == kNone || force.end == kNone) continue;
    force.element = at(get_first_one_sided(model)) + i;
    force.limit = calc_limit(placed, own);
    if (own.joint != kNone) force.joint.emplace(placed, own.joint);
    if (own.drum) force.drum = place_drum(placed, own);
    forces_.push_back(std::move(force));
  }
}

UnseenEngagements::Depth UnseenEngagements::calc(const Force& force, const MotionKnot& near, const BodyState& base,
                                                 const BodyState& follower) {
  const OneSided& own = force.own;
  if (!force.joint) {
    const double bearing = force.drum ? near.state.bearings[force.drum_number] : 0;
    const OneSidedForce now =
        calc_one_sided_force(own, force.limit, force.drum ? &*force.drum : nullptr, bearing, base, follower);
    return {now.depth, now.depth_rate};
  }
  double x = force.joint->calc_coordinate(base, follower, own.axis);
  if (own.axis >= kRotX) {
    constexpr double kTurn = 2 * std::numbers::pi;
    const double counted = near.state.joints[at(own.joint)].angle[own.axis - kRotX];
    x -= kTurn * std::nearbyint((x - counted) / kTurn);
  }
  const double sign = own.pulls ? -1 : 1;
  return {sign * (force.limit - x), -sign * force.joint->calc_speed(base, follower, own.axis)};
}

void UnseenEngagements::find(const Force& force, const MotionWindow& window, const MotionKnot& from,
                             const MotionKnot& to) {
  const bool engaged = from.state.engaged[at(force.number)] != 0;
  if ((to.state.engaged[at(force.number)] != 0) != engaged) return;
  if (!is_on(from.state.elements[force.element], from.time)) return;
  const int base = force.joint ? force.joint->get_base() : force.own.base;
  const int follower = force.joint ? force.joint->get_follower() : force.own.follower;
  // By how much it lacks the depth at which the next of its events is due.
  const double sign = engaged ? 1 : -1;
  const Depth first = calc(force, from, get_body(from, base), get_body(from, follower));
  if (!(sign * first.value > 0 && sign * first.rate < 0)) return;
  const Depth last = calc(force, to, get_body(to, base), get_body(to, follower));
  if (!(sign * last.value > 0 && sign * last.rate > 0)) return;
  // A cubic with these ends and slopes h r falls below its lower end by at most 4/27 h (|r0| + |r1|). Pushers that rest
  // on what bolts still hold vibrate by rounding alone.
  const double most = (to.time - from.time) * (std::abs(first.rate) + std::abs(last.rate));
  if (std::min(sign * first.value, sign * last.value) > most) return;
  const auto lack = [&](double time) {
    return sign * calc(force, from, window.calc_body(base, time), window.calc_body(follower, time)).value;
  };
  // As much may be error of the interpolation, or rounding of places.
  constexpr double kNoise = 1e-6, kRounding = 1e-12;
  const double noise =
      kNoise * std::max(sign * first.value, sign * last.value) + kRounding * (1 + std::abs(force.limit));
  // It may be due more than once: it is searched about each place that is the least of its neighbours.
  constexpr int kLooks = 8;
  double times[kLooks + 1], values[kLooks + 1];
  for (int i = 0; i <= kLooks; ++i) {
    times[i] = i == kLooks ? to.time : from.time + (to.time - from.time) * i / kLooks;
    values[i] = i == 0 ? sign * first.value : i == kLooks ? sign * last.value : lack(times[i]);
  }
  const auto cross = [&](double inside, double outside) {
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (inside + outside);
      (lack(middle) > 0 ? outside : inside) = middle;
    }
    return inside;
  };
  for (int i = 0; i <= kLooks; ++i) {
    const int left = std::max(i - 1, 0), right = std::min(i + 1, kLooks);
    if (values[i] > values[left] || values[i] > values[right]) continue;
    Least least;
    least.search(times[left], times[right], lack);
    if (!(least.get_value() < -noise)) continue;
    int before = least.get_time() < times[i] ? i - 1 : i, behind = before + 1;
    while (!(values[before] > 0)) --before;
    while (!(values[behind] > 0)) ++behind;
    found_.push_back({engaged ? force.end : force.begin, force.number, cross(least.get_time(), times[before]),
                      cross(least.get_time(), times[behind])});
    i = std::max(i, behind - 1);
  }
}

std::span<const UnseenEngagement> UnseenEngagements::find(const MotionWindow& window, const MotionKnot& from,
                                                          const MotionKnot& to) {
  found_.clear();
  for (const Force& force : forces_) find(force, window, from, to);
  return found_;
}

}  // namespace unlatch::hil
