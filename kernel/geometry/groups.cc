// Distances of unions, and bounds by which pairs are skipped.
#include "kernel/geometry/groups.h"

namespace unlatch::geometry {
namespace {

// Half of the box about a shape, in its axes.
Vec3 get_half_box(const ShapeNumbers& shape) {
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

double calc_lower_bound(const ShapeNumbers& a, const Placement& at_a, const ShapeNumbers& b,
                        const Placement& at_b) noexcept {
  if (!std::isfinite(a.bound) || !std::isfinite(b.bound)) return -HUGE_VAL;
  const bool of_a = a.bound > b.bound;
  const ShapeNumbers &boxed = of_a ? a : b, &round = of_a ? b : a;
  const Placement &at_boxed = of_a ? at_a : at_b, &at_round = of_a ? at_b : at_a;
  const Vec3 centre = at_round.p_WB + at_round.R_WB * round.p_BS;
  const Vec3 in_body = transpose_times(at_boxed.R_WB, centre - at_boxed.p_WB) - boxed.p_BS;
  const Vec3 x = transpose_times(boxed.R_BS, in_body), half = get_half_box(boxed);
  const Vec3 out{calc_outside(x.x, half.x), calc_outside(x.y, half.y), calc_outside(x.z, half.z)};
  const double bound = (norm(out) - round.bound) - kRounding * ((norm(x) + a.bound) + b.bound);
  return bound > 0 ? bound : -HUGE_VAL;
}

GroupDistance calc_distance(const ShapeGroup& a, const Placement& at_a, const ShapeGroup& b,
                            const Placement& at_b) noexcept {
  const auto get_shape = [](std::span<const CompiledShape> parts) {
    return [parts](std::size_t i) { return ShapeView(parts[i]); };
  };
  const std::span<const CompiledShape> parts_a = get_parts(a), parts_b = get_parts(b);
  return calc_least(parts_a.size(), get_shape(parts_a), at_a, parts_b.size(), get_shape(parts_b), at_b);
}

double calc_lower_bound(const GroupNumbers& a, const Placement& at_a, const GroupNumbers& b,
                        const Placement& at_b) noexcept {
  return calc_bound((at_b.p_WB + at_b.R_WB * b.centre) - (at_a.p_WB + at_a.R_WB * a.centre), a.bound, b.bound);
}

double calc_closing_speed(const GroupNumbers& a, const Motion& of_a, const GroupNumbers& b,
                          const Motion& of_b) noexcept {
  const double reach_a = norm(a.centre) + a.bound, reach_b = norm(b.centre) + b.bound;
  // Without a turn the term is 0, also for a half-space, whose reach is infinite.
  const double turn_a = of_a.turn > 0 ? of_a.turn * reach_a : 0, turn_b = of_b.turn > 0 ? of_b.turn * reach_b : 0;
  return norm(of_a.v_WB - of_b.v_WB) + (turn_a + turn_b);
}

double calc_advanced_bound(double distance, const GroupNumbers& a, const Motion& of_a, const GroupNumbers& b,
                           const Motion& of_b, double interval) noexcept {
  const double speed = calc_closing_speed(a, of_a, b, of_b), increase = of_a.increase + of_b.increase;
  return distance - (speed + 0.5 * increase * interval) * interval;
}

}  // namespace unlatch::geometry
