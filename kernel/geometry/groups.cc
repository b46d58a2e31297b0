// Distances of unions, and bounds by which pairs are skipped.
#include "kernel/geometry/groups.h"

#include <algorithm>

#include "unlatch/geometry/group_pair.h"
#include "unlatch/geometry/reach.h"

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

double choose_more(double a, double b) { return a > b ? a : b; }

double calc_outside(double x, double half) {
  const double out = std::fabs(x) - half;
  return out > 0 ? out : 0.0;
}

// The smaller shape's bounding sphere, as seen from the box about the other shape.
struct FromBox {
  const ShapeNumbers &a, &b, &boxed, &round;
  const Placement& at_boxed;
  Vec3 centre;   // W
  Vec3 x, half;  // of its centre, in the box's axes; of the box

  double calc_bound() const {
    const Vec3 out{calc_outside(x.x, half.x), calc_outside(x.y, half.y), calc_outside(x.z, half.z)};
    const double bound = (norm(out) - round.bound) - kRounding * ((norm(x) + a.bound) + b.bound);
    return bound > 0 ? bound : -HUGE_VAL;
  }
};
FromBox see_from_box(const ShapeNumbers& a, const Placement& at_a, const ShapeNumbers& b, const Placement& at_b) {
  const bool of_a = a.bound > b.bound;
  const ShapeNumbers &boxed = of_a ? a : b, &round = of_a ? b : a;
  const Placement &at_boxed = of_a ? at_a : at_b, &at_round = of_a ? at_b : at_a;
  const Vec3 centre = at_round.p_WB + at_round.R_WB * round.p_BS;
  const Vec3 in_body = transpose_times(at_boxed.R_WB, centre - at_boxed.p_WB) - boxed.p_BS;
  return {a, b, boxed, round, at_boxed, centre, transpose_times(boxed.R_BS, in_body), get_half_box(boxed)};
}

}  // namespace

double calc_lower_bound(const ShapeNumbers& a, const Placement& at_a, const ShapeNumbers& b,
                        const Placement& at_b) noexcept {
  if (!std::isfinite(a.bound) || !std::isfinite(b.bound)) return -HUGE_VAL;
  return see_from_box(a, at_a, b, at_b).calc_bound();
}

SphereBound calc_sphere_bound(const ShapeNumbers& a, const Placement& at_a, const ShapeNumbers& b,
                              const Placement& at_b) noexcept {
  if (!std::isfinite(a.bound) || !std::isfinite(b.bound)) return {};
  const FromBox seen = see_from_box(a, at_a, b, at_b);
  SphereBound out{seen.calc_bound(), -HUGE_VAL, {0, 0, 0}, seen.centre, &seen.round == &b};
  const auto try_axis = [&](double at, double own, const Vec3& axis) {
    const double width = (std::fabs(at) - own) - seen.round.bound;
    if (!(width > out.width)) return;
    out.width = width;
    out.normal = at < 0 ? -axis : axis;
  };
  const Mat3& axes = seen.boxed.R_BS;
  try_axis(seen.x.x, seen.half.x, axes.x);
  try_axis(seen.x.y, seen.half.y, axes.y);
  try_axis(seen.x.z, seen.half.z, axes.z);
  out.normal = seen.at_boxed.R_WB * out.normal;
  return out;
}

Box build_box(const ShapeNumbers& shape, const Placement& at, const Vec3& origin) noexcept {
  const bool curved = shape.kind != ShapeKind::kBox && shape.kind != ShapeKind::kHull;
  return {(at.p_WB - origin) + at.R_WB * shape.p_BS, at.R_WB * shape.R_BS, get_half_box(shape), shape.bound, !curved};
}

double calc_slab_bound(const Box& a, const Box& b) noexcept {
  if (!std::isfinite(a.bound) || !std::isfinite(b.bound)) return -HUGE_VAL;
  const Vec3 d = b.c - a.c, of_a = transpose_times(a.R, d), of_b = transpose_times(b.R, d);
  const Vec3 x = transpose_times(a.R, b.R.x), y = transpose_times(a.R, b.R.y), z = transpose_times(a.R, b.R.z);
  const auto calc_reach = [](double r, double s, double t, const Vec3& half) {
    return (std::fabs(r) * half.x + std::fabs(s) * half.y) + std::fabs(t) * half.z;
  };
  const double apart = norm(d), size = (apart + a.bound) + b.bound;
  double bound = apart - (a.bound + b.bound);
  bound = choose_more(bound, (std::fabs(of_a.x) - a.half.x) - calc_reach(x.x, y.x, z.x, b.half));
  bound = choose_more(bound, (std::fabs(of_a.y) - a.half.y) - calc_reach(x.y, y.y, z.y, b.half));
  bound = choose_more(bound, (std::fabs(of_a.z) - a.half.z) - calc_reach(x.z, y.z, z.z, b.half));
  bound = choose_more(bound, (std::fabs(of_b.x) - b.half.x) - calc_reach(x.x, x.y, x.z, a.half));
  bound = choose_more(bound, (std::fabs(of_b.y) - b.half.y) - calc_reach(y.x, y.y, y.z, a.half));
  bound = choose_more(bound, (std::fabs(of_b.z) - b.half.z) - calc_reach(z.x, z.y, z.z, a.half));
  // What a distance may be below the widest slab: its certificate and, of curved shapes that overlap, 1e-5 of their
  // size (penetration.cc).
  constexpr double kCertifiedGap = 1e-9, kCurved = 2e-5;
  return bound - (bound < 0 && !(a.polytope && b.polytope) ? kCurved : kCertifiedGap) * size;
}

Slab calc_widest_slab(const Box& a, const Box& b) noexcept {
  const Vec3 d = b.c - a.c;
  Slab out{-HUGE_VAL, {0, 0, 0}};
  const auto try_axes = [&](const Mat3& axes, const Vec3& half, const Box& other) {
    const auto try_axis = [&](const Vec3& n, double own) {
      const double along = dot(n, d);
      const double reach = (std::fabs(dot(n, other.R.x)) * other.half.x + std::fabs(dot(n, other.R.y)) * other.half.y) +
                           std::fabs(dot(n, other.R.z)) * other.half.z;
      const double width = std::fabs(along) - (own + reach);
      if (width > out.width) out = {width, along < 0 ? -n : n};
    };
    try_axis(axes.x, half.x);
    try_axis(axes.y, half.y);
    try_axis(axes.z, half.z);
  };
  try_axes(a.R, a.half, b);
  try_axes(b.R, b.half, a);
  return out;
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

double calc_way(const Vec3& from_centre, const Mat3& from_R, const Vec3& to_centre, const Mat3& to_R,
                double bound) noexcept {
  const Vec3 x = to_R.x - from_R.x, y = to_R.y - from_R.y, z = to_R.z - from_R.z;
  return norm(to_centre - from_centre) + bound * std::sqrt(0.5 * ((dot(x, x) + dot(y, y)) + dot(z, z)));
}

Extent calc_extent(const ShapeGroup& group, const Placement& at) noexcept {
  Extent out{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
  for (const CompiledShape& shape : get_parts(group)) {
    if (!std::isfinite(shape.bound)) return {{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, HUGE_VAL, HUGE_VAL}};
    const Box box = build_box(shape, at, {0, 0, 0});
    const Mat3& R = box.R;
    const auto calc_reach = [&](double x, double y, double z) {
      return (std::fabs(x) * box.half.x + std::fabs(y) * box.half.y) + std::fabs(z) * box.half.z;
    };
    const Vec3 reach{calc_reach(R.x.x, R.y.x, R.z.x), calc_reach(R.x.y, R.y.y, R.z.y), calc_reach(R.x.z, R.y.z, R.z.z)};
    const Vec3 least = box.c - reach, most = box.c + reach;
    out.least = {std::min(out.least.x, least.x), std::min(out.least.y, least.y), std::min(out.least.z, least.z)};
    out.most = {std::max(out.most.x, most.x), std::max(out.most.y, most.y), std::max(out.most.z, most.z)};
  }
  return out;
}

namespace {

// m, from the centre of a shape's axes along n, given in its axes.
double calc_reach(const CompiledShape& shape, const Vec3& n) {
  switch (shape.kind) {
    case ShapeKind::kSphere:
    case ShapeKind::kHollow:
      return shape.bound;
    case ShapeKind::kCapsule:
      return std::fabs(n.z) * shape.half_length + shape.r0;
    case ShapeKind::kBox:
      return (std::fabs(n.x) * shape.half_size.x + std::fabs(n.y) * shape.half_size.y) +
             std::fabs(n.z) * shape.half_size.z;
    case ShapeKind::kHull: {
      double most = -HUGE_VAL;
      for (const Vec3& point : shape.points) most = std::max(most, dot(n, point));
      return most;
    }
    case ShapeKind::kHalfSpace:
      return HUGE_VAL;
    default: {
      const double across = std::sqrt(n.x * n.x + n.y * n.y), along = n.z * shape.half_length;
      return std::max(along + across * shape.r1, across * shape.r0 - along);
    }
  }
}

}  // namespace

double calc_reach(const ShapeGroup& group, const Placement& at, const Vec3& direction) noexcept {
  const Vec3 in_body = transpose_times(at.R_WB, direction);
  double most = -HUGE_VAL;
  for (const CompiledShape& shape : get_parts(group))
    most = std::max(most, dot(in_body, shape.p_BS) + calc_reach(shape, transpose_times(shape.R_BS, in_body)));
  return dot(direction, at.p_WB) + most;
}

double get_exact_depth(const ShapeGroup& group) noexcept {
  double least = HUGE_VAL;
  for (const CompiledShape& shape : get_parts(group)) {
    if (shape.kind == ShapeKind::kBox || shape.kind == ShapeKind::kHull) continue;
    const bool is_round = shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule;
    least = std::min(least, is_round ? shape.r0 : 0);
  }
  return least;
}

GroupPair::Seen GroupPair::calc_seen(const Placement& at_a, const Placement& at_b) const noexcept {
  const bool of_b = std::isfinite(b_.bound);
  const Placement &from = of_b ? at_a : at_b, &seen = of_b ? at_b : at_a;
  const Vec3 between = (seen.p_WB - from.p_WB) + seen.R_WB * (of_b ? b_.centre : a_.centre);
  const Mat3 &R = from.R_WB, &S = seen.R_WB;
  return {transpose_times(R, between), {transpose_times(R, S.x), transpose_times(R, S.y), transpose_times(R, S.z)}};
}

void GroupPair::add_way(const Seen& seen, double bound) noexcept {
  constexpr int kMostCalls = 10000;  // until then the sum of the ways is rounded by less than the bounds' own margin
  constexpr double kMostWay = 100;   // of the bounding radius
  way_ += calc_way(latest_.centre, latest_.R, seen.centre, seen.R, bound);
  latest_ = seen;
  if (++calls_ < kMostCalls && way_ < kMostWay * bound) return;
  std::fill(bounds_.begin(), bounds_.end(), -HUGE_VAL);
  way_ = 0;
  calls_ = 0;
}

GroupDistance GroupPair::calc_distance(const Placement& at_a, const Placement& at_b) noexcept {
  const double bound = std::isfinite(b_.bound) ? b_.bound : a_.bound;
  if (bounds_.size() < 2 || !std::isfinite(bound)) return geometry::calc_distance(a_, at_a, b_, at_b);
  const std::span<const CompiledShape> of_a = get_parts(a_), of_b = get_parts(b_);
  const std::size_t count_b = of_b.size();
  add_way(calc_seen(at_a, at_b), bound);

  GroupDistance out;
  std::size_t number = bounds_.size();
  const auto add = [&](std::size_t pair) {
    take(geometry::calc_distance(of_a[pair / count_b], at_a, of_b[pair % count_b], at_b), pair, count_b, out, number);
  };
  const std::size_t first = nearest_;
  add(first);
  for (std::size_t pair = 0; pair < bounds_.size(); ++pair) {
    if (pair == first || bounds_[pair] - way_ > out.least.distance) continue;
    const double now = calc_slab_bound(build_box(of_a[pair / count_b], at_a, at_a.p_WB),
                                       build_box(of_b[pair % count_b], at_b, at_a.p_WB));
    bounds_[pair] = now + way_;
    if (!(now > out.least.distance)) add(pair);
  }
  if (number < bounds_.size()) nearest_ = number;
  return out;
}

}  // namespace unlatch::geometry
