#include "tests/kernel/geometry/solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace unlatch::test {

using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;

Vec3 draw_vector(Random& random, double reach) {
  const double x = random.uniform(-reach, reach), y = random.uniform(-reach, reach), z = random.uniform(-reach, reach);
  return {x, y, z};
}

Vec3 draw_direction(Random& random) {
  for (;;) {
    const Vec3 v = draw_vector(random, 1);
    const double length = norm(v);
    if (length > 0.1 && length < 1) return (1.0 / length) * v;
  }
}

Mat3 draw_rotation(Random& random) {
  const Vec3 a = draw_direction(random);
  const double w = random.uniform(-1, 1);
  return rotation_matrix(normalized(Quat{w, a.x, a.y, a.z}));
}

Shape draw_shape(Random& random, ShapeKind kind) {
  Shape s;
  s.kind = kind;
  s.from = draw_vector(random, 0.3);
  const Vec3 axis = draw_direction(random);
  s.to = s.from + random.uniform(0.2, 2) * axis;
  s.radius = random.uniform(0.1, 0.8);
  s.end_radius = random.uniform(0, 0.8);
  s.size = {random.uniform(0.2, 2), random.uniform(0.2, 2), random.uniform(0.2, 2)};
  const Vec3 turn = draw_direction(random);
  s.q_BS = normalized(Quat{random.uniform(-1, 1), turn.x, turn.y, turn.z});
  const int count = 4 + random.below(9);
  for (int i = 0; i < count; ++i) s.points.push_back(draw_vector(random, 0.8));
  return s;
}

Shape draw_any(Random& random, int kind) {
  if (kind < 7) return draw_shape(random, kConvexKinds[kind]);
  Shape s = draw_shape(random, ShapeKind::kCylinder);
  s.kind = kind == 7 ? ShapeKind::kHalfSpace : ShapeKind::kHollow;
  s.normal = draw_direction(random);
  s.profile = {{0, 1.5}, {1, 1.2}, {2.5, 1}};
  s.half = random.chance(0.5);
  s.side = cross(s.to - s.from, s.normal);
  return s;
}

Placement draw_placement(Random& random, double reach) {
  const Vec3 p = draw_vector(random, reach);
  return {p, draw_rotation(random)};
}

double calc_extent(const Shape& s, const Placement& at, const Vec3& n) {
  const Vec3 l = transpose_times(at.R_WB, n);
  const double base = dot(n, at.p_WB);
  const auto disc = [&](const Vec3& centre, double r) {
    const Vec3 axis = s.to - s.from;
    return dot(l, centre) + r * norm(cross(axis, l)) / norm(axis);
  };
  switch (s.kind) {
    case ShapeKind::kSphere:
      return base + dot(l, s.from) + s.radius;
    case ShapeKind::kCapsule:
      return base + std::max(dot(l, s.from), dot(l, s.to)) + s.radius;
    case ShapeKind::kCylinder:
      return base + std::max(disc(s.from, s.radius), disc(s.to, s.radius));
    case ShapeKind::kCone:
      return base + std::max(disc(s.from, s.radius), dot(l, s.to));
    case ShapeKind::kFrustum:
      return base + std::max(disc(s.from, s.radius), disc(s.to, s.end_radius));
    case ShapeKind::kBox: {
      const Vec3 m = transpose_times(rotation_matrix(s.q_BS), l);
      return base + dot(l, s.from) +
             0.5 * (std::fabs(m.x) * s.size.x + std::fabs(m.y) * s.size.y + std::fabs(m.z) * s.size.z);
    }
    default: {
      double most = -std::numeric_limits<double>::infinity();
      for (const Vec3& p : s.points) most = std::max(most, dot(l, p));
      return base + most;
    }
  }
}

double calc_outside(const Shape& s, const Placement& at, const Vec3& p) {
  const Vec3 l = transpose_times(at.R_WB, p - at.p_WB);
  const Vec3 axis = s.to - s.from;
  const double length = norm(axis), z = dot(l - s.from, axis) / length, rho = norm(cross(axis, l - s.from)) / length;
  const auto revolved = [&](double r0, double r1) {
    const double slope = (r1 - r0) / length;
    const double beyond = (rho - (r0 + slope * z)) / std::sqrt(1 + slope * slope);
    return std::max({0.0, beyond, -z, z - length});
  };
  switch (s.kind) {
    case ShapeKind::kSphere:
      return std::max(0.0, norm(l - s.from) - s.radius);
    case ShapeKind::kCapsule:
      return std::max(0.0, norm(l - (s.from + (std::clamp(z, 0.0, length) / length) * axis)) - s.radius);
    case ShapeKind::kCylinder:
      return revolved(s.radius, s.radius);
    case ShapeKind::kCone:
      return revolved(s.radius, 0);
    case ShapeKind::kFrustum:
      return revolved(s.radius, s.end_radius);
    case ShapeKind::kBox: {
      const Vec3 m = transpose_times(rotation_matrix(s.q_BS), l - s.from);
      return std::max(
          {0.0, std::fabs(m.x) - 0.5 * s.size.x, std::fabs(m.y) - 0.5 * s.size.y, std::fabs(m.z) - 0.5 * s.size.z});
    }
    default:
      break;
  }
  // Tries all planes through three points that have the others on one side.
  double outside = 0;
  const std::size_t count = s.points.size();
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      for (std::size_t k = j + 1; k < count; ++k) {
        Vec3 n = cross(s.points[j] - s.points[i], s.points[k] - s.points[i]);
        n = (1 / norm(n)) * n;
        double low = 0, high = 0;
        for (const Vec3& q : s.points) {
          low = std::min(low, dot(n, q - s.points[i]));
          high = std::max(high, dot(n, q - s.points[i]));
        }
        constexpr double kPlane = 1e-12;  // m
        const double height = dot(n, l - s.points[i]);
        if (high <= kPlane) outside = std::max(outside, height);
        if (low >= -kPlane) outside = std::max(outside, -height);
      }
    }
  }
  return outside;
}

double search_depth(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b, int directions) {
  const auto width = [&](const Vec3& n) { return calc_extent(a, at_a, n) + calc_extent(b, at_b, -n); };
  double least = std::numeric_limits<double>::infinity();
  Vec3 best{0, 0, 1};
  for (int i = 0; i < directions; ++i) {  // a spiral, evenly over the sphere
    const double z = 1 - (2 * i + 1.0) / directions, r = std::sqrt(1 - z * z), angle = 2.399963229728653 * i;
    const Vec3 n{r * std::cos(angle), r * std::sin(angle), z};
    if (const double w = width(n); w < least) least = w, best = n;
  }
  for (double step = 0.1; step > 1e-8;) {
    const Vec3 u = std::fabs(best.x) < 0.7 ? cross(best, {1, 0, 0}) : cross(best, {0, 1, 0});
    const Vec3 v = cross(best, u);
    bool better = false;
    for (int k = 0; k < 8 && !better; ++k) {
      const double angle = 0.78539816339744831 * k;
      Vec3 n = best + (step * std::cos(angle)) * u + (step * std::sin(angle)) * v;
      n = (1 / norm(n)) * n;
      if (const double w = width(n); w < least) least = w, best = n, better = true;
    }
    if (!better) step *= 0.5;
  }
  return least;
}

}  // namespace unlatch::test
