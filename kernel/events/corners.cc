#include "kernel/events/corners.h"

#include <algorithm>

#include "kernel/math/index.h"
#include "unlatch/model/law_places.h"

namespace unlatch {
namespace {

constexpr double kNearJump = 1e-12;  // part of the sub-step, from its end: rounding of times

}  // namespace

namespace {

// Calls use(a corner at a place, its knots, how many) with each of them.
void for_each_corner(const PlanData& plan, const auto& use) {
  for (const PlanCorner& corner : plan.laws.corners)
    use(PassedCorner{.place = corner.place, .jumps = corner.jumps}, &plan.laws.numbers[at(corner.knots)], corner.count);
  for_each_travel_corner(plan, [&](const PlanOneSided& own, std::span<const double> knots) {
    use(PassedCorner{.place = own.number, .of = CornerOf::kTravel}, knots.data(), own.count);
  });
  if (plan.air_corners.empty()) return;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(plan.aerodynamics.size()); ++i)
    use(PassedCorner{.place = i, .of = CornerOf::kAir}, plan.air_corners.data(),
        static_cast<std::int32_t>(plan.air_corners.size()));
}

}  // namespace

PassedCorner find_corner(const PlanData& plan, double begin, double end, const CornerPlaces& at_begin,
                         const CornerPlaces& at_end, const PassedCorner& ended) noexcept {
  PassedCorner found;
  const double margin = kNearCorner * plan.options.dt / (end - begin);
  double first = 1;
  for_each_corner(plan, [&](PassedCorner corner, const double* knots, std::int32_t count) {
    const double a = at_begin.get(corner), b = at_end.get(corner);
    if (!(a < b || b < a)) return;  // at rest, or NaN
    const double* const low = std::upper_bound(knots, knots + count, std::min(a, b));
    const double* const high = std::upper_bound(low, knots + count, std::max(a, b));
    if (high - low > kMostCorners) return;
    for (std::ptrdiff_t i = 0; i < high - low; ++i) {
      corner.knot = a < b ? low[i] : high[-1 - i];
      const double part = (corner.knot - a) / (b - a);
      if (part <= margin && !corner.jumps) continue;
      const bool again = corner.place == ended.place && corner.of == ended.of && corner.knot == ended.knot;
      if (part < first && part < 1 - (corner.jumps && !again ? kNearJump : margin)) {
        first = part;
        found = corner;
      }
      return;
    }
  });
  return found;
}

namespace {

// True if the way from a to b passes a knot at a part of it between `from` and `to`.
bool passes(const double* knots, std::int32_t count, double a, double b, double from, double to) {
  const double* const low = std::upper_bound(knots, knots + count, std::min(a, b));
  const double* const high = std::upper_bound(low, knots + count, std::max(a, b));
  return std::any_of(low, high, [&](double knot) {
    const double part = (knot - a) / (b - a);
    return part > from && part < to;
  });
}

}  // namespace

bool passes_and_returns(const PlanData& plan, double begin, double end, const PassedPlaces& places) noexcept {
  const double margin =
      4 * kNearCorner * plan.options.dt / (end - begin);  // of a half: twice that of the whole, and to spare
  bool found = false;
  for_each_corner(plan, [&](const PassedCorner& corner, const double* knots, std::int32_t count) {
    const double a = places.at_begin.get(corner), b = places.at_end.get(corner), m = places.in_middle.get(corner);
    const double* const low = std::upper_bound(knots, knots + count, std::min(a, b));
    if (found || std::upper_bound(low, knots + count, std::max(a, b)) - low > kMostCorners) return;
    found = passes(knots, count, a, m, margin, 1) || passes(knots, count, m, b, 0, 1 - margin);
  });
  return found;
}

namespace {

// The first of `knots` between `begin` and `end`, or `end`. `get_time(knot)`: when it is passed, s, rising.
template <class Knots, class GetTime>
double find_first_knot(const Knots& knots, double begin, double end, const GetTime& get_time) {
  const auto lies_before = [&](const auto& knot, double time) { return get_time(knot) < time; };
  const auto low = std::lower_bound(knots.begin(), knots.end(), begin, lies_before);
  const auto high = std::lower_bound(low, knots.end(), end, lies_before);
  return low != high && high - low <= kMostCorners ? get_time(*low) : end;
}

std::span<const MassKnot> get_knots(const PlanData& plan, const PlanVarying& mass) {
  return std::span(plan.mass_knots).subspan(at(mass.first), at(mass.count));
}

}  // namespace

double find_time_corner(const PlanData& plan, const State& state, double begin, double end) noexcept {
  const double slack = plan.get_slack(), low = begin + slack, high = end - slack;
  double first = high;
  for (const PlanLoad& load : plan.loads) {
    const ElementState& element = state.elements[at(load.element)];
    if (load.law != kNone || (element.from == 0 && element.to == 0)) continue;
    const PlanProfile& profile = plan.profiles[at(load.profile)];
    if (profile.kind != Profile::Kind::kTable) continue;
    const std::span<const Knot> knots = std::span(plan.knots).subspan(at(profile.first), at(profile.count));
    first = std::min(
        first, find_first_knot(knots, low, high, [&](const Knot& knot) { return knot.time + element.switched_on; }));
  }
  for (const ElementState& element : state.elements) {
    const double stop = element.start + element.duration;
    if (element.duration > 0 && stop >= low) first = std::min(first, stop);
  }
  for (const PlanVarying& mass : plan.varying)
    if (!mass.by_burnt)
      first =
          std::min(first, find_first_knot(get_knots(plan, mass), low, high, [](const MassKnot& k) { return k.at; }));
  return first < high ? first : end;
}

PassedKnot find_burnt_knot(const PlanData& plan, double begin, double end, std::span<const double> at_begin,
                           std::span<const double> at_end) noexcept {
  const double margin = kNearCorner * plan.options.dt / (end - begin);
  PassedKnot first;
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const double a = at_begin[i], b = at_end[i];
    if (!plan.varying[i].by_burnt || !(a < b)) continue;
    const double none = a + (1 - margin) * (b - a);
    const double knot = find_first_knot(get_knots(plan, plan.varying[i]), a + margin * (b - a), none,
                                        [](const MassKnot& k) { return k.at; });
    if (knot < none && (knot - a) / (b - a) < first.part)
      first = {static_cast<std::int32_t>(i), knot, (knot - a) / (b - a)};
  }
  return first;
}

bool is_at_burnt_knot(const PlanData& plan, const Evaluation& ev) noexcept {
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const double burnt = ev.auxiliary.now[i], reach = 2 * kNearCorner * plan.options.dt * ev.auxiliary.rate[i];
    if (!plan.varying[i].by_burnt || !(reach > 0)) continue;
    const double none = burnt + reach;
    if (find_first_knot(get_knots(plan, plan.varying[i]), burnt - reach, none, [](const MassKnot& k) { return k.at; }) <
        none)
      return true;
  }
  return false;
}

}  // namespace unlatch
