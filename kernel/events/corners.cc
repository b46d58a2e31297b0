#include "kernel/events/corners.h"

#include <algorithm>

#include "kernel/math/index.h"
#include "unlatch/model/law_places.h"

namespace unlatch {
namespace {

constexpr double kNear = 1e-5;       // part of the step, from either end of a sub-step
constexpr double kNearJump = 1e-12;  // part of the sub-step, from its end: rounding of times

}  // namespace

PassedCorner find_corner(const PlanData& plan, double begin, double end, std::span<const double> at_begin,
                         std::span<const double> at_end, const PassedCorner& ended) noexcept {
  PassedCorner found;
  const double margin = kNear * plan.options.dt / (end - begin);
  double first = 1;
  for (const PlanCorner& corner : plan.laws.corners) {
    const double a = at_begin[at(corner.place)], b = at_end[at(corner.place)];
    if (!(a < b || b < a)) continue;  // at rest, or NaN
    const double* const knots = &plan.laws.numbers[at(corner.knots)];
    const double* const low = std::upper_bound(knots, knots + corner.count, std::min(a, b));
    const double* const high = std::upper_bound(low, knots + corner.count, std::max(a, b));
    if (high - low > kMostCorners) continue;
    for (std::ptrdiff_t i = 0; i < high - low; ++i) {
      const double knot = a < b ? low[i] : high[-1 - i], part = (knot - a) / (b - a);
      const bool exact = corner.jumps && !(corner.place == ended.place && knot == ended.knot);
      if (part <= margin && !corner.jumps) continue;
      if (part < first && part < 1 - (exact ? kNearJump : margin)) {
        first = part;
        found = {corner.place, knot, corner.jumps};
      }
      break;
    }
  }
  return found;
}

bool passes_and_returns(const PlanData& plan, std::span<const double> at_begin, std::span<const double> in_middle,
                        std::span<const double> at_end) noexcept {
  for (const PlanCorner& corner : plan.laws.corners) {
    const double a = at_begin[at(corner.place)], b = at_end[at(corner.place)], m = in_middle[at(corner.place)];
    const double low = std::min(a, b), high = std::max(a, b);
    if (!(m > high || m < low)) continue;
    const double* const knots = &plan.laws.numbers[at(corner.knots)];
    const double* const knot = std::upper_bound(knots, knots + corner.count, m > high ? high : m);
    if (knot != knots + corner.count && *knot < (m > high ? m : low)) return true;
  }
  return false;
}

}  // namespace unlatch
