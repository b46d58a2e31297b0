#include "kernel/events/corner_marks.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "kernel/events/corners.h"
#include "kernel/math/index.h"
#include "unlatch/model/law_places.h"

namespace unlatch {
namespace {

constexpr double kMargin = 2 * kNearCorner;  // part of the step: what counts as an end of a sub-step, and to spare

// Adds marks of the knots that are passed on the way from `a` to `b`. `margin`: part of that way.
class KnotMarker {
 public:
  KnotMarker(double margin, CornerEnds& marks) : margin_(margin), marks_(marks) {}

  void mark(double part) {
    if (part < -margin_ || part > 1 + margin_) return;
    marks_.at_begin = marks_.at_begin || part <= margin_ || part < 1 - margin_;  // a sub-step may be shorter than that
    marks_.at_end = marks_.at_end || part >= 1 - margin_ || part > margin_;
  }
  void mark_way(double a, double b, const double* first, std::ptrdiff_t count) {
    if (!(a < b || b < a)) return;  // at rest, or NaN
    const double reach = margin_ * std::abs(b - a);
    const double* const low = std::lower_bound(first, first + count, std::min(a, b) - reach);
    const double* const high = std::upper_bound(low, first + count, std::max(a, b) + reach);
    for (const double* knot = low; knot < std::min(high, low + kMostCorners + 1); ++knot) mark((*knot - a) / (b - a));
  }

 private:
  double margin_;
  CornerEnds& marks_;
};

void mark_table(const PlanLaws& laws, const PlanLawStep& step, const CornerCourse& course, KnotMarker& marker) {
  const PlanTable& table = laws.tables[at(step.subject)];
  for (std::int32_t i = 0; i < table.axis_count; ++i) {
    const PlanTableAxis& axis = laws.axes[at(table.first_axis + i)];
    const double* const knots = &laws.numbers[at(axis.knots)];
    const double a = course.at_begin.laws[at(step.place + i)], b = course.at_end.laws[at(step.place + i)];
    if (!table.smooth) {
      marker.mark_way(a, b, knots, axis.count);
    } else {
      marker.mark_way(a, b, knots, 1);
      marker.mark_way(a, b, knots + axis.count - 1, 1);
    }
  }
}

void add_times(const PlanData& plan, const State& state, double begin, double end, KnotMarker& marker) {
  const auto mark = [&](double time) { marker.mark((time - begin) / (end - begin)); };
  for (const ElementState& element : state.elements)
    if (element.duration > 0) mark(element.start + element.duration);
  for (const PlanVarying& mass : plan.varying)
    if (!mass.by_burnt)
      for (const MassKnot& knot : std::span(plan.mass_knots).subspan(at(mass.first), at(mass.count))) mark(knot.at);
  const double reach = kMargin * plan.options.dt;
  for (const PlanLoad& load : plan.loads) {
    const PlanProfile& profile = plan.profiles[at(load.profile)];
    const ElementState& element = state.elements[at(load.element)];
    if (load.law != kNone || profile.kind != Profile::Kind::kTable || (element.from == 0 && element.to == 0)) continue;
    const std::span<const Knot> knots = std::span(plan.knots).subspan(at(profile.first), at(profile.count));
    auto knot = std::lower_bound(knots.begin(), knots.end(), begin - reach - element.switched_on,
                                 [](const Knot& one, double s) { return one.time < s; });
    const double last = end + reach - element.switched_on;
    for (int i = 0; i <= kMostCorners && knot != knots.end() && knot->time <= last; ++i, ++knot)
      mark(knot->time + element.switched_on);
  }
}

double calc_margin(const PlanData& plan, double begin, double end) { return kMargin * plan.options.dt / (end - begin); }

// True if an `if_less` that this place decides changed at the end of the sub-step.
bool jumps_at_end(const PlanLawStep& step, double margin, const CornerCourse& course) {
  if (step.kind != LawStep::Kind::kIfLess) return false;
  const std::size_t i = at(step.place);
  if (course.from_begin[i] == course.decided[i]) return false;
  const double a = course.at_begin.laws[i], b = course.at_end.laws[i];
  return a == b || -a / (b - a) >= 1 - margin;
}

}  // namespace

CornerEnds mark_times(const PlanData& plan, const State& state, double begin, double end) noexcept {
  CornerEnds marks;
  if (!plan.time_corners) return marks;
  KnotMarker marker(calc_margin(plan, begin, end), marks);
  add_times(plan, state, begin, end, marker);
  return marks;
}

CornerMarks mark_corners(const PlanData& plan, const State& state, double begin, double end,
                         const CornerCourse& course) noexcept {
  CornerMarks marks{.motion = mark_times(plan, state, begin, end), .readings = {}};
  const double margin = calc_margin(plan, begin, end);
  KnotMarker motion(margin, marks.motion), readings(margin, marks.readings);
  constexpr double kZero = 0;
  for (std::size_t i = 0; i < plan.laws.order.size(); ++i) {
    const PlanLaw& law = plan.laws.list[at(plan.laws.order[i])];
    KnotMarker& marker = i < at(plan.law_numbers.driving) ? motion : readings;
    for (const PlanLawStep& step : std::span(plan.laws.steps).subspan(at(law.first), at(law.count))) {
      if (step.place == kNone) continue;
      if (step.kind == LawStep::Kind::kTable)
        mark_table(plan.laws, step, course, marker);
      else
        marker.mark_way(course.at_begin.laws[at(step.place)], course.at_end.laws[at(step.place)], &kZero, 1);
      marks.jumps = marks.jumps || jumps_at_end(step, margin, course);
    }
  }
  for (const PlanAirPlace& own : plan.laws.air_places)
    motion.mark_way(course.at_begin.laws[at(own.place)], course.at_end.laws[at(own.place)],
                    &plan.laws.numbers[at(own.knots)], own.count);
  for_each_travel_corner(plan, [&](const PlanOneSided& own, std::span<const double> knots) {
    motion.mark_way(course.at_begin.travels[at(own.number)], course.at_end.travels[at(own.number)], knots.data(),
                    own.count);
  });
  for (std::size_t i = 0; i < course.at_begin.altitudes.size(); ++i)
    motion.mark_way(course.at_begin.altitudes[i], course.at_end.altitudes[i], plan.air_corners.data(),
                    std::ssize(plan.air_corners));
  return marks;
}

void hold_branches(const PlanData& plan, double begin, double end, const CornerCourse& course,
                   std::span<std::int32_t> branches) noexcept {
  const double margin = calc_margin(plan, begin, end);
  for (const PlanLawStep& step : plan.laws.steps)
    if (step.place != kNone && jumps_at_end(step, margin, course))
      branches[at(step.place)] = course.from_begin[at(step.place)];
}

}  // namespace unlatch
