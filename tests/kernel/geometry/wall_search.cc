#include "tests/kernel/geometry/wall_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace unlatch::test {
namespace {

using geometry::Placement;
using geometry::ProfilePoint;
using geometry::Shape;
using geometry::ShapeKind;

constexpr double kPi = 3.14159265358979323846;
constexpr double kGolden = 0.38196601125010515;

// Least value of a function with one minimum between two arguments, by golden section.
template <typename Function>
double minimise(const Function& f, double low, double high, int steps) {
  double a = low + kGolden * (high - low), b = high - kGolden * (high - low);
  double of_a = f(a), of_b = f(b), least = std::min({f(low), f(high), of_a, of_b});
  for (int i = 0; i < steps; ++i) {
    if (of_a < of_b) {
      high = b, b = a, of_b = of_a;
      a = low + kGolden * (high - low), of_a = f(a);
    } else {
      low = a, a = b, of_a = of_b;
      b = high - kGolden * (high - low), of_b = f(b);
    }
    least = std::min({least, of_a, of_b});
  }
  return least;
}

double calc_segment_distance(double x, double y, double x0, double y0, double x1, double y1) {
  const double dx = x1 - x0, dy = y1 - y0;
  const double t = std::clamp(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return std::hypot(x - (x0 + t * dx), y - (y0 + t * dy));
}

double calc_triangle_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto to_edge = [&](const Vec3& from, const Vec3& to) {
    const Vec3 d = to - from;
    return norm(p - (from + std::clamp(dot(p - from, d) / dot(d, d), 0.0, 1.0) * d));
  };
  const Vec3 n = cross(b - a, c - a);
  if (dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 && dot(cross(a - c, p - c), n) >= 0)
    return std::fabs(dot(n, p - a)) / norm(n);
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

// Point of the wall between two points of its profile.
Vec3 calc_wall_point(const ProfilePoint& from, const ProfilePoint& to, double azimuth, double share) {
  const double r = from.r + share * (to.r - from.r), z = from.z + share * (to.z - from.z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

}  // namespace

double calc_point_distance(const Shape& s, const Placement& at, const Vec3& p) {
  const Vec3 l = transpose_times(at.R_WB, p - at.p_WB);
  const Vec3 axis = s.to - s.from;
  const double length = norm(axis), z = dot(l - s.from, axis) / length, rho = norm(cross(axis, l - s.from)) / length;
  const auto revolved = [&](double r0, double r1) {
    if (z >= 0 && z <= length && rho <= r0 + (r1 - r0) * z / length) return 0.0;
    return std::min({calc_segment_distance(rho, z, 0, 0, std::max(r0, 1e-300), 0),
                     calc_segment_distance(rho, z, r0, 0, r1, length),
                     calc_segment_distance(rho, z, 0, length, std::max(r1, 1e-300), length)});
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
      return std::hypot(std::max(0.0, std::fabs(m.x) - 0.5 * s.size.x), std::max(0.0, std::fabs(m.y) - 0.5 * s.size.y),
                        std::max(0.0, std::fabs(m.z) - 0.5 * s.size.z));
    }
    default:
      break;
  }
  if (!(calc_outside(s, at, p) > 0)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < s.points.size(); ++i)
    for (std::size_t j = i + 1; j < s.points.size(); ++j)
      for (std::size_t k = j + 1; k < s.points.size(); ++k)
        least = std::min(least, calc_triangle_distance(l, s.points[i], s.points[j], s.points[k]));
  return least;
}

double search_wall(const Shape& wall, const Shape& body, const Placement& at, int azimuths) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < wall.profile.size(); ++i) {
    const ProfilePoint &from = wall.profile[i], &to = wall.profile[i + 1];
    // A distance to a convex solid is convex along a generator.
    const auto of_generator = [&](double azimuth, int steps) {
      const auto f = [&](double share) {
        return calc_point_distance(body, at, calc_wall_point(from, to, azimuth, share));
      };
      return minimise(f, 0, 1, steps);
    };
    const double first = wall.half ? -0.5 * kPi : 0, step = (wall.half ? kPi : 2 * kPi) / azimuths;
    const double last = first + azimuths * step;
    std::vector<double> coarse;
    for (int k = 0; k <= azimuths; ++k) coarse.push_back(of_generator(first + k * step, 18));
    const double best = *std::min_element(coarse.begin(), coarse.end());
    least = std::min(least, best);
    const double reach = std::max(from.r, to.r) * step + 1e-3;
    for (int k = 0; k <= azimuths; ++k) {
      const auto get = [&](int place) { return coarse[static_cast<std::size_t>(place)]; };
      const double here = get(k), left = k > 0 ? get(k - 1) : (wall.half ? here : get(azimuths - 1));
      const double right = k < azimuths ? get(k + 1) : (wall.half ? here : get(1));
      if (here > left || here > right || here > best + reach || here == 0) continue;
      const double angle = first + k * step;
      const double low = wall.half ? std::max(first, angle - step) : angle - step;
      const double high = wall.half ? std::min(last, angle + step) : angle + step;
      least = std::min(least, minimise([&](double azimuth) { return of_generator(azimuth, 52); }, low, high, 48));
    }
  }
  return least;
}

double search_crossed_wall(const Shape& wall, const Shape& body, const Placement& at) {
  const ProfilePoint &from = wall.profile[0], &to = wall.profile[1];
  // A strip is so wide that only directions in its meridian plane lead out of it.
  const auto calc_way_out = [&](double azimuth, double angle) {
    const Vec3 n{std::cos(azimuth) * std::cos(angle), std::sin(azimuth) * std::cos(angle), std::sin(angle)};
    const double of_strip =
        std::max(dot(n, calc_wall_point(from, to, azimuth, 0)), dot(n, calc_wall_point(from, to, azimuth, 1)));
    return of_strip + calc_extent(body, at, -n);
  };
  const auto in = [&](double azimuth) {
    constexpr int kAngles = 240;
    constexpr double kStep = 2 * kPi / kAngles;
    double coarse[kAngles], least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kAngles; ++k) coarse[k] = calc_way_out(azimuth, k * kStep), least = std::min(least, coarse[k]);
    double depth = least;
    for (int k = 0; k < kAngles; ++k) {
      const double here = coarse[k], left = coarse[(k + kAngles - 1) % kAngles], right = coarse[(k + 1) % kAngles];
      if (here > left || here > right || here > least + 0.1) continue;
      const auto f = [&](double angle) { return calc_way_out(azimuth, angle); };
      depth = std::min(depth, minimise(f, (k - 1) * kStep, (k + 1) * kStep, 40));
    }
    return -depth;
  };
  constexpr int kAzimuths = 360;
  constexpr double kStep = 2 * kPi / kAzimuths;
  double coarse[kAzimuths], least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kAzimuths; ++k) coarse[k] = in(k * kStep), least = std::min(least, coarse[k]);
  double height = least;
  for (int k = 0; k < kAzimuths; ++k) {
    const double here = coarse[k];
    if (here > coarse[(k + kAzimuths - 1) % kAzimuths] || here > coarse[(k + 1) % kAzimuths] || here > least + 0.02)
      continue;
    height = std::min(height, minimise(in, (k - 1) * kStep, (k + 1) * kStep, 36));
  }
  const Shape solid{
      .kind = ShapeKind::kFrustum, .from = {0, 0, from.z}, .to = {0, 0, to.z}, .radius = from.r, .end_radius = to.r};
  return std::max(height, calc_distance(compile_shape(solid), {}, compile_shape(body), at).distance);
}

}  // namespace unlatch::test
