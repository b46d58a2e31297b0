#include "unlatch/model/law_courses.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/laws/law_steps.h"
#include "kernel/laws/tables.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/model/law_places.h"

namespace unlatch {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = 3.14159265358979323846;

// Ways of arguments beyond which a function may rise and fall between the beginning, the middle and the end.
constexpr double kLongAngle = 1;    // rad, of sin, cos, tan
constexpr double kLongPower = 1;    // of exp: a factor of e
constexpr double kLongRatio = 1.5;  // of what is divided by, and of the arguments of sqrt and log
constexpr double kLongTurn = 0.5;   // rad, of the result of atan, atan2, asin and acos

using Marks = LawCourses::Marks;

double get_least(const Course& x) { return std::min({x.begin, x.middle, x.end}); }
double get_greatest(const Course& x) { return std::max({x.begin, x.middle, x.end}); }

// Bounds that are no numbers are none.
Course bound(double begin, double middle, double end, double low, double high) {
  const double least = std::min({begin, middle, end}), greatest = std::max({begin, middle, end});
  return {begin, middle, end, std::isnan(low) ? -kInfinity : std::min(low, least),
          std::isnan(high) ? kInfinity : std::max(high, greatest)};
}

// Of a function that only rises, or only falls, from the least argument to the greatest.
Course bound_by_ends(const Course& values, double at_low, double at_high) {
  return bound(values.begin, values.middle, values.end, std::min(at_low, at_high), std::max(at_low, at_high));
}

bool is_at_rest(const Course& x) { return x.low == x.high; }
bool straddles(const Course& x) { return x.low < 0 && x.high > 0; }
// Of what decides a branch: sharp where it passes zero, but not at the three instants.
void mark_branch(const Course& x, Marks& marks) {
  const bool seen = get_least(x) < 0 && get_greatest(x) > 0;
  marks.sharp = straddles(x) && !seen;
  marks.split = seen;
}

// A step's arguments at each of the three instants.
template <class... Arguments>
Course apply_at_all(const PlanLawStep& step, const Arguments&... x) {
  return {apply(step, x.begin...), apply(step, x.middle...), apply(step, x.end...), 0, 0};
}

Course multiply(const Course& values, const Course& a, const Course& b) {
  const double products[] = {a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high};
  double low = products[0], high = products[0];
  for (const double p : products) {
    if (std::isnan(p)) return bound(values.begin, values.middle, values.end, p, p);  // 0 · ∞
    low = std::min(low, p), high = std::max(high, p);
  }
  return bound(values.begin, values.middle, values.end, low, high);
}

// Of 1 / x; sharp where x passes zero, or changes by much.
Course invert(const Course& x, Marks& marks) {
  const Course values{1 / x.begin, 1 / x.middle, 1 / x.end, 0, 0};
  if (is_at_rest(x)) return bound(values.begin, values.middle, values.end, values.begin, values.end);
  if (!(x.low > 0) && !(x.high < 0)) {
    marks.sharp = true;
    return bound(values.begin, values.middle, values.end, -kInfinity, kInfinity);
  }
  marks.sharp = std::max(x.high / x.low, x.low / x.high) > kLongRatio;
  return bound_by_ends(values, 1 / x.low, 1 / x.high);
}

Course raise(const Course& x, std::int32_t exponent, Marks& marks) {
  const std::int32_t n = std::abs(exponent);
  const auto power = [&](double value) { return calc_power(value, n); };
  Course raised = bound_by_ends({power(x.begin), power(x.middle), power(x.end), 0, 0}, power(x.low), power(x.high));
  if (n % 2 == 0 && n > 0 && straddles(x)) raised.low = 0;
  return exponent < 0 ? invert(raised, marks) : raised;
}

// Of sine or cosine: off its three values by at most an eighth of its curvature times the way squared.
Course bound_wave(const Course& values, const Course& x, Marks& marks) {
  const double way = x.high - x.low, bulge = way * way / 8;
  marks.sharp = !(way <= kLongAngle);
  if (marks.sharp) return bound(values.begin, values.middle, values.end, -1, 1);
  return bound(values.begin, values.middle, values.end, std::max(-1.0, get_least(values) - way - bulge),
               std::min(1.0, get_greatest(values) + way + bulge));
}

Course bound_tangent(const Course& values, const Course& x, Marks& marks) {
  const auto count_poles = [](double angle) { return std::floor(angle / kPi + 0.5); };
  marks.sharp = !(x.high - x.low <= kLongAngle) || count_poles(x.low) != count_poles(x.high);
  if (count_poles(x.low) != count_poles(x.high))
    return bound(values.begin, values.middle, values.end, -kInfinity, kInfinity);
  return bound_by_ends(values, calc_tan(x.low), calc_tan(x.high));
}

// Of the angle of (x, y): all of them about the origin, and where y changes sign behind it.
Course bound_angle(const Course& values, const Course& y, const Course& x, Marks& marks) {
  if (is_at_rest(x) && is_at_rest(y)) return bound(values.begin, values.middle, values.end, values.begin, values.end);
  marks.sharp = true;
  if (!(x.low > 0) && !(y.low > 0) && !(y.high < 0)) return bound(values.begin, values.middle, values.end, -kPi, kPi);
  double low = kPi, high = -kPi;
  for (const double to_y : {y.low, y.high})
    for (const double to_x : {x.low, x.high}) {
      const double angle = elementary::atan2(to_y, to_x);
      low = std::min(low, angle), high = std::max(high, angle);
    }
  marks.sharp = !(high - low <= kLongTurn);
  return bound(values.begin, values.middle, values.end, low, high);
}

// A function of one argument that rises from one bound to the other, or falls.
Course bound_monotone(const PlanLawStep& step, const Course& values, const Course& x, Marks& marks) {
  using Kind = LawStep::Kind;
  const double domain_low = step.kind == Kind::kSqrt || step.kind == Kind::kLog    ? 0
                            : step.kind == Kind::kAsin || step.kind == Kind::kAcos ? -1
                                                                                   : -kInfinity;
  const double domain_high = step.kind == Kind::kAsin || step.kind == Kind::kAcos ? 1 : kInfinity;
  const double low = std::clamp(x.low, domain_low, domain_high), high = std::clamp(x.high, domain_low, domain_high);
  const Course result = bound_by_ends(values, apply(step, low), apply(step, high));
  if (step.kind == Kind::kExp)
    marks.sharp = !(high - low <= kLongPower);
  else if (step.kind == Kind::kSqrt || step.kind == Kind::kLog)
    marks.sharp = !(high <= kLongRatio * low) && high > low;
  else
    marks.sharp = !(result.high - result.low <= kLongTurn);
  return result;
}

Course bound_one(const PlanLawStep& step, const Course& x, Marks& marks) {
  using Kind = LawStep::Kind;
  const Course values = apply_at_all(step, x);
  switch (step.kind) {
    case Kind::kPower:
      return raise(x, step.subject, marks);
    case Kind::kNegate:
      return bound_by_ends(values, -x.low, -x.high);
    case Kind::kAbs: {
      mark_branch(x, marks);
      Course result = bound_by_ends(values, std::abs(x.low), std::abs(x.high));
      if (straddles(x)) result.low = 0;
      return result;
    }
    case Kind::kSin:
    case Kind::kCos:
      return bound_wave(values, x, marks);
    case Kind::kTan:
      return bound_tangent(values, x, marks);
    default:
      return bound_monotone(step, values, x, marks);
  }
}

Course bound_two(const PlanLawStep& step, const Course& a, const Course& b, Marks& marks) {
  using Kind = LawStep::Kind;
  const Course values = apply_at_all(step, a, b);
  const auto within = [&](double low, double high) {
    return bound(values.begin, values.middle, values.end, low, high);
  };
  switch (step.kind) {
    case Kind::kAdd:
      return within(a.low + b.low, a.high + b.high);
    case Kind::kSubtract:
      return within(a.low - b.high, a.high - b.low);
    case Kind::kMultiply:
      return multiply(values, a, b);
    case Kind::kDivide: {
      const Course inverse = invert(b, marks);
      return multiply(values, a, inverse);
    }
    case Kind::kAtan2:
      return bound_angle(values, a, b, marks);
    default: {
      mark_branch({a.begin - b.begin, a.middle - b.middle, a.end - b.end, a.low - b.high, a.high - b.low}, marks);
      const bool least = step.kind == Kind::kMin;
      return least ? within(std::min(a.low, b.low), std::min(a.high, b.high))
                   : within(std::max(a.low, b.low), std::max(a.high, b.high));
    }
  }
}

// a < b ? c : d; `side` of the middle: 1 if it is less. `held`: that side everywhere.
Course bound_if(const Course* x, bool held, std::int8_t& side, Marks& marks) {
  const Course &a = x[0], &b = x[1], &less = x[2], &other = x[3];
  if (held) return side != 0 ? less : other;
  side = a.middle < b.middle ? 1 : 0;
  const auto choose = [&](double Course::*instant) {
    if (std::isnan(a.*instant) || std::isnan(b.*instant)) return a.*instant + b.*instant;
    return a.*instant < b.*instant ? less.*instant : other.*instant;
  };
  const Course decides{a.begin - b.begin, a.middle - b.middle, a.end - b.end, a.low - b.high, a.high - b.low};
  const bool may_be_less = !(decides.low >= 0), may_be_other = !(decides.high < 0);
  mark_branch(decides, marks);
  return bound(choose(&Course::begin), choose(&Course::middle), choose(&Course::end),
               std::min(may_be_less ? less.low : kInfinity, may_be_other ? other.low : kInfinity),
               std::max(may_be_less ? less.high : -kInfinity, may_be_other ? other.high : -kInfinity));
}

Course rescale_all(const auto& own, const Inputs& inputs, const Course& x) {
  const auto scale = [&](double value) { return rescale(own, inputs, value); };
  return bound_by_ends({scale(x.begin), scale(x.middle), scale(x.end), 0, 0}, scale(x.low), scale(x.high));
}

// Knots of an axis between two places.
std::ptrdiff_t count_knots(const double* knots, std::int32_t count, double low, double high) {
  const double* const first = std::lower_bound(knots, knots + count, low);
  return std::upper_bound(first, knots + count, high) - first;
}

}  // namespace

struct LawCourses::Context {
  const PlanData& plan;
  Inputs inputs;
  std::span<const Course> quantities;
  bool held;
};

Course Course::of_parabola(double begin, double middle, double end) noexcept {
  Course course{begin, middle, end, std::min({begin, middle, end}), std::max({begin, middle, end})};
  const double bend = 2 * (begin - 2 * middle + end), rise = end - begin;
  const double top = bend == 0 ? 0 : 0.5 * (1 - rise / bend);  // where it turns
  if (!(top > 0 && top < 1)) return course;
  const double value = begin + top * (rise + bend * (top - 1));
  course.low = std::min(course.low, value);
  course.high = std::max(course.high, value);
  return course;
}

LawCourses::LawCourses(const Model& model, const Plan& plan)
    : plan_(plan),
      seen_(model.laws.size()),
      sides_(at(get_data(plan).law_numbers.places)),
      coordinates_(sides_.size(), Course{kNan, kNan, kNan, kNan, kNan}),
      found_(sides_.size()) {
  for (const Table& table : model.tables) {
    const auto [low, high] = std::ranges::minmax(table.values);
    // A spline swings about its values by some tenths of a jump.
    const double swing = table.interpolation == Table::Interpolation::kSmooth ? 0.5 * (high - low) : 0;
    of_tables_.emplace_back(low - swing, high + swing);
  }
}

void LawCourses::update(std::span<const int> laws, std::span<const double> commands, std::span<const Course> quantities,
                        Sides sides) {
  const Context context{get_data(plan_), {commands}, quantities, sides == Sides::kHold};
  for (const int law : laws) {
    Seen& own = seen_[at(law)];
    own.marks = {};
    own.whole = own.plain = calc(context, law, Bounds::kWhole, own.marks);
    own.hidden = 0;
    if (!own.marks.sharp) continue;
    Marks unused;
    own.plain = calc(context, law, Bounds::kPlain, unused);
    own.hidden = std::max(own.whole.high - own.plain.high, own.plain.low - own.whole.low);
    if (std::isnan(own.hidden)) own.hidden = kInfinity;
  }
}

// The table's numbers at the three instants. Those of the latest look-up at the same place are taken again: one course
// begins where another has ended.
Course LawCourses::find(const Context& context, const PlanLawStep& step, const Course* coordinates) {
  const PlanLaws& laws = context.plan.laws;
  const PlanTable& own = laws.tables[at(step.subject)];
  Course* const known = &coordinates_[at(step.place)];
  const auto is_known = [&](double Course::*instant, double Course::*then) {
    for (std::int32_t i = 0; i < own.axis_count; ++i)
      if (!(known[i].*then == coordinates[i].*instant)) return false;
    return true;
  };
  Course& latest = found_[at(step.place)];
  const auto find_at = [&](double Course::*instant) {
    for (double Course::*const then : {instant, &Course::end, &Course::begin, &Course::middle})
      if (is_known(instant, then)) return latest.*then;
    double places[kMostTableAxes];
    for (std::int32_t i = 0; i < own.axis_count; ++i) places[i] = coordinates[i].*instant;
    TableExit unused;
    return calc_table(laws, own, places, unused);
  };
  const Course values{find_at(&Course::begin), find_at(&Course::middle), find_at(&Course::end), 0, 0};
  std::copy_n(coordinates, own.axis_count, known);
  latest = values;
  return values;
}

Course LawCourses::look_up(const Context& context, const PlanLawStep& step, const Course* coordinates, Bounds bounds,
                           Marks& marks) {
  const PlanLaws& laws = context.plan.laws;
  const PlanTable& own = laws.tables[at(step.subject)];
  const Course values = find(context, step, coordinates);
  for (std::int32_t i = 0; i < own.axis_count; ++i) {
    const PlanTableAxis& axis = laws.axes[at(own.first_axis + i)];
    const double* const knots = &laws.numbers[at(axis.knots)];
    const Course& x = coordinates[i];
    if (x.low >= get_least(x) && x.high <= get_greatest(x)) continue;
    if (count_knots(knots, axis.count, x.low, x.high) <= count_knots(knots, axis.count, get_least(x), get_greatest(x)))
      continue;
    marks.sharp = true;
    if (bounds == Bounds::kWhole)
      return rescale_all(own, context.inputs,
                         bound(values.begin, values.middle, values.end, of_tables_[at(step.subject)].first,
                               of_tables_[at(step.subject)].second));
  }
  // Within a cell it is off its three values by little more than its middle is off the chord.
  const double bulge = std::abs(values.begin - 2 * values.middle + values.end);
  return rescale_all(
      own, context.inputs,
      bound(values.begin, values.middle, values.end, get_least(values) - bulge, get_greatest(values) + bulge));
}

Course LawCourses::calc(const Context& context, int law, Bounds bounds, Marks& marks) {
  using Kind = LawStep::Kind;
  const PlanLaws& plan = context.plan.laws;
  const PlanLaw& own = plan.list[at(law)];
  Course stack[kLawStack];
  Course* top = stack;
  // A sharp function without the bounds that it may have.
  const auto put = [&](Course* to, const Course& result, const Marks& own_marks) {
    marks.sharp = marks.sharp || own_marks.sharp;
    marks.split = marks.split || own_marks.split;
    *to = own_marks.sharp && bounds == Bounds::kPlain
              ? Course{result.begin, result.middle, result.end, get_least(result), get_greatest(result)}
              : result;
  };
  for (const PlanLawStep& step : std::span(plan.steps).subspan(at(own.first), at(own.count))) {
    Marks here;
    switch (step.kind) {
      case Kind::kConstant:
        *top++ = {step.value, step.value, step.value, step.value, step.value};
        break;
      case Kind::kQuantity:
        if (step.of_law) {
          const Seen& other = seen_[at(step.subject)];
          marks.sharp = marks.sharp || other.marks.sharp;
          marks.split = marks.split || other.marks.split;
          *top++ = bounds == Bounds::kPlain ? other.plain : other.whole;
        } else {
          *top++ = context.quantities[at(plan.operands[at(step.subject)])];
        }
        break;
      case Kind::kCommand: {
        const double value = context.inputs.commands[at(step.subject)];
        *top++ = {value, value, value, value, value};
        break;
      }
      case Kind::kTable: {
        top -= plan.tables[at(step.subject)].axis_count;
        const Course found = look_up(context, step, top, bounds, here);
        put(top++, found, here);
        break;
      }
      case Kind::kIfLess: {
        top -= 3;
        const Course result = bound_if(top - 1, context.held, sides_[at(step.place)], here);
        put(top - 1, result, here);
        break;
      }
      default: {
        const bool two = get_operands(step.kind).takes == 2;
        if (two) --top;
        const Course result = two ? bound_two(step, top[-1], top[0], here) : bound_one(step, top[-1], here);
        put(top - 1, result, here);
      }
    }
  }
  return rescale_all(own, context.inputs, stack[0]);
}

}  // namespace unlatch
