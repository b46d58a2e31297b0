// Distances of unions, and bounds by which pairs are skipped.
#include <cmath>

#include "kernel/geometry/bounds.h"

namespace unlatch::geometry {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-12;  // of the bounds' sizes: bounds stay below distances in spite of rounding

double calc_bound(const Vec3& between, double a, double b) {
  const double apart = norm(between);
  return std::isfinite(a) && std::isfinite(b) ? (apart - (a + b)) - kRounding * ((apart + a) + b) : -kInfinite;
}

// Half of the box about a shape, in its axes.
Vec3 get_half_box(const CompiledShape& shape) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return shape.half_size;
    case ShapeKind::kSphere:
      return {shape.r0, shape.r0, shape.r0};
    case ShapeKind::kCapsule:
      return {shape.r0, shape.r0, shape.half_length + shape.r0};
    case ShapeKind::kHull:
    case ShapeKind::kHollow:
      return {shape.bound, shape.bound, shape.bound};
    default: {
      const double r = shape.r0 > shape.r1 ? shape.r0 : shape.r1;
      return {r, r, shape.half_length};
    }
  }
}

double calc_outside(double x, double half) {
  const double out = std::fabs(x) - half;
  return out > 0 ? out : 0.0;
}

}  // namespace

double calc_lower_bound(const CompiledShape& a, const Placement& at_a, const CompiledShape& b,
                        const Placement& at_b) noexcept {
  if (!std::isfinite(a.bound) || !std::isfinite(b.bound)) return -kInfinite;
  const bool of_a = a.bound > b.bound;
  const CompiledShape &boxed = of_a ? a : b, &round = of_a ? b : a;
  const Placement &at_boxed = of_a ? at_a : at_b, &at_round = of_a ? at_b : at_a;
  const Vec3 centre = at_round.p_WB + at_round.R_WB * round.p_BS;
  const Vec3 in_body = transpose_times(at_boxed.R_WB, centre - at_boxed.p_WB) - boxed.p_BS;
  const Vec3 x = transpose_times(boxed.R_BS, in_body), half = get_half_box(boxed);
  const Vec3 out{calc_outside(x.x, half.x), calc_outside(x.y, half.y), calc_outside(x.z, half.z)};
  const double bound = (norm(out) - round.bound) - kRounding * ((norm(x) + a.bound) + b.bound);
  return bound > 0 ? bound : -kInfinite;
}

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
