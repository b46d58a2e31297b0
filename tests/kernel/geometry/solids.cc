#include "tests/kernel/geometry/solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace unlatch::test {

using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;

namespace {

double calc_segment_distance(double x, double y, double x0, double y0, double x1, double y1) {
  const double dx = x1 - x0, dy = y1 - y0, square = dx * dx + dy * dy;
  const double t = square > 0 ? std::clamp(((x - x0) * dx + (y - y0) * dy) / square, 0.0, 1.0) : 0;
  const double ex = x - (x0 + t * dx), ey = y - (y0 + t * dy);
  return std::sqrt(ex * ex + ey * ey);
}

// Distance of a point and a triangle with its unit normal.
double calc_triangle_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& n) {
  const auto to_edge = [&](const Vec3& from, const Vec3& to) {
    const Vec3 d = to - from;
    return norm(p - (from + std::clamp(dot(p - from, d) / dot(d, d), 0.0, 1.0) * d));
  };
  if (dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 && dot(cross(a - c, p - c), n) >= 0)
    return std::fabs(dot(n, p - a));
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

}  // namespace

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

PointDistance::PointDistance(const Shape& s, const Placement& at)
    : kind_(s.kind),
      from_(at.p_WB + at.R_WB * s.from),
      axis_(at.R_WB * (s.to - s.from)),
      length_(norm(axis_)),
      radius_(s.radius),
      end_radius_(s.kind == ShapeKind::kCylinder ? s.radius : (s.kind == ShapeKind::kCone ? 0 : s.end_radius)),
      half_size_(0.5 * s.size) {
  axis_ = (1 / length_) * axis_;
  if (kind_ == ShapeKind::kBox) R_WS_ = at.R_WB * rotation_matrix(s.q_BS);
  if (kind_ != ShapeKind::kHull) return;
  // Facets are all triples of points whose plane has the others on one side.
  std::vector<Vec3> points;
  for (const Vec3& p : s.points) points.push_back(at.p_WB + at.R_WB * p);
  constexpr double kPlane = 1e-12;  // m
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        Vec3 n = cross(points[j] - points[i], points[k] - points[i]);
        n = (1 / norm(n)) * n;
        double low = 0, high = 0;
        for (const Vec3& q : points) {
          low = std::min(low, dot(n, q - points[i]));
          high = std::max(high, dot(n, q - points[i]));
        }
        if (high <= kPlane) facets_.push_back({points[i], points[j], points[k], n});
        if (low >= -kPlane) facets_.push_back({points[i], points[k], points[j], -n});
      }
    }
  }
}

double PointDistance::operator()(const Vec3& p) const {
  const Vec3 d = p - from_;
  const double z = dot(axis_, d);
  switch (kind_) {
    case ShapeKind::kSphere:
      return std::max(0.0, norm(d) - radius_);
    case ShapeKind::kCapsule:
      return std::max(0.0, norm(d - std::clamp(z, 0.0, length_) * axis_) - radius_);
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
    case ShapeKind::kFrustum: {
      const double rho = norm(cross(axis_, d));
      if (z >= 0 && z <= length_ && rho <= radius_ + (end_radius_ - radius_) * z / length_) return 0;
      return std::min({calc_segment_distance(rho, z, 0, 0, radius_, 0),
                       calc_segment_distance(rho, z, radius_, 0, end_radius_, length_),
                       calc_segment_distance(rho, z, 0, length_, end_radius_, length_)});
    }
    case ShapeKind::kBox: {
      const Vec3 m = transpose_times(R_WS_, d);
      const auto beyond = [](double x, double half) { return std::max(0.0, std::fabs(x) - half); };
      return norm({beyond(m.x, half_size_.x), beyond(m.y, half_size_.y), beyond(m.z, half_size_.z)});
    }
    default:
      break;
  }
  double least = std::numeric_limits<double>::infinity();
  bool outside = false;
  for (const Facet& f : facets_) {
    const double height = dot(f.n, p - f.a);
    outside = outside || height > 0;
    if (height < least && height > -least) least = std::min(least, calc_triangle_distance(p, f.a, f.b, f.c, f.n));
  }
  return outside ? least : 0;
}

double search_directions(const std::function<double(const Vec3& n)>& function, int directions, int starts) {
  struct Tried {
    double value;
    Vec3 n;
  };
  std::vector<Tried> tried;
  for (int i = 0; i < directions; ++i) {  // a spiral, evenly over the sphere
    const double z = 1 - (2 * i + 1.0) / directions, r = std::sqrt(1 - z * z), angle = 2.399963229728653 * i;
    const Vec3 n{r * std::cos(angle), r * std::sin(angle), z};
    tried.push_back({function(n), n});
  }
  // Tries ever other ways to the side, as a ridge may leave only a narrow one downwards, and goes on from the best of
  // them with the step that has led there.
  const auto refine = [&](Tried best) {
    constexpr int kWays = 40;
    constexpr double kGoldenAngle = 2.399963229728653;
    int tries = 0;
    for (double step = 0.1; step > 1e-9;) {
      const Vec3 u = std::fabs(best.n.x) < 0.7 ? cross(best.n, {1, 0, 0}) : cross(best.n, {0, 1, 0});
      const Vec3 v = cross(best.n, u);
      Tried next = best;
      for (int k = 0; k < kWays; ++k) {
        const double angle = kGoldenAngle * ++tries;
        Vec3 n = best.n + (step * std::cos(angle)) * u + (step * std::sin(angle)) * v;
        n = (1 / norm(n)) * n;
        if (const double value = function(n); value < next.value) next = {value, n};
      }
      if (next.value < best.value)
        best = next;
      else
        step *= 0.7;
    }
    return best.value;
  };
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start < starts && !tried.empty(); ++start) {
    const Tried best =
        *std::min_element(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) { return a.value < b.value; });
    least = std::min(least, refine(best));
    std::erase_if(tried, [&](const Tried& t) { return norm(t.n - best.n) < 0.3; });
  }
  return least;
}

double search_depth(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b, int directions) {
  return search_directions([&](const Vec3& n) { return calc_extent(a, at_a, n) + calc_extent(b, at_b, -n); },
                           directions);
}

}  // namespace unlatch::test
