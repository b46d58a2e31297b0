// Distances of unions, and bounds by which pairs are skipped.
#include <cmath>

#include "unlatch/geometry.h"

namespace unlatch::geometry {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-12;  // of the bounds' sizes: bounds stay below distances in spite of rounding

double calc_bound(const Vec3& between, double a, double b) {
  const double apart = norm(between);
  return std::isfinite(a) && std::isfinite(b) ? (apart - (a + b)) - kRounding * ((apart + a) + b) : -kInfinite;
}

}  // namespace

GroupDistance calc_distance(const ShapeGroup& a, const Placement& at_a, const ShapeGroup& b,
                            const Placement& at_b) noexcept {
  GroupDistance out;
  for (std::size_t i = 0; i < a.shapes.size(); ++i) {
    const CompiledShape& of_a = a.shapes[i];
    const Vec3 centre_a = at_a.p_WB + at_a.R_WB * of_a.p_BS;
    for (std::size_t k = 0; k < b.shapes.size(); ++k) {
      const CompiledShape& of_b = b.shapes[k];
      const Vec3 between = (at_b.p_WB + at_b.R_WB * of_b.p_BS) - centre_a;
      if (calc_bound(between, of_a.bound, of_b.bound) > out.least.distance) continue;
      const Distance d = calc_distance(of_a, at_a, of_b, at_b);
      if (d.distance < out.least.distance) {
        out.least = d;
        out.shape_a = static_cast<int>(i);
        out.shape_b = static_cast<int>(k);
      }
    }
  }
  return out;
}

double calc_lower_bound(const ShapeGroup& a, const Placement& at_a, const ShapeGroup& b,
                        const Placement& at_b) noexcept {
  return calc_bound((at_b.p_WB + at_b.R_WB * b.centre) - (at_a.p_WB + at_a.R_WB * a.centre), a.bound, b.bound);
}

double calc_closing_speed(const ShapeGroup& a, const Motion& of_a, const ShapeGroup& b, const Motion& of_b) noexcept {
  const double reach_a = norm(a.centre) + a.bound, reach_b = norm(b.centre) + b.bound;
  // A half-space that does not turn has no lever.
  const double turn_a = of_a.turn > 0 ? of_a.turn * reach_a : 0, turn_b = of_b.turn > 0 ? of_b.turn * reach_b : 0;
  return norm(of_a.v_WB - of_b.v_WB) + (turn_a + turn_b);
}

double calc_advanced_bound(double distance, const ShapeGroup& a, const Motion& of_a, const ShapeGroup& b,
                           const Motion& of_b, double interval) noexcept {
  const double speed = calc_closing_speed(a, of_a, b, of_b), increase = of_a.increase + of_b.increase;
  return distance - (speed + 0.5 * increase * interval) * interval;
}

}  // namespace unlatch::geometry
