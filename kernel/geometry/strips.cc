#include "kernel/geometry/strips.h"

#include "kernel/geometry/closest.h"
#include "kernel/geometry/penetration.h"
#include "unlatch/elementary.h"

namespace unlatch::geometry {
namespace {

constexpr double kRightAngle = 1.57079632679489661923;  // rad

// True if one point of the core is farthest along the unit vector d: no face, line or generator lies across it.
bool has_single_support(const Core& core, const Vec3& d) {
  constexpr double kAcross = 1e-8;  // rad
  if (core.kind == Core::Kind::kPoint) return true;
  const Vec3 at{dot(core.R.x, d), dot(core.R.y, d), dot(core.R.z, d)};
  if (core.kind == Core::Kind::kSegment) return std::fabs(at.z) > kAcross;
  if (core.kind == Core::Kind::kBox)
    return std::fabs(at.x) > kAcross && std::fabs(at.y) > kAcross && std::fabs(at.z) > kAcross;
  if (core.kind != Core::Kind::kFrustum) return false;
  const double across = std::sqrt(at.x * at.x + at.y * at.y);
  return across > kAcross && std::fabs(core.gr * across + core.gz * at.z) > kAcross;
}

}  // namespace

Strips::Strips(const Core& solid, const Core& b)
    : solid_(solid),
      b_(b),
      size_(calc_pair_size(solid, b)),
      is_half_(solid.kind == Core::Kind::kHalfFrustum),
      has_rims_(b.kind == Core::Kind::kFrustum) {}

double Strips::clamp(double azimuth) const {
  if (!is_half_) return azimuth;
  return azimuth < -kRightAngle ? -kRightAngle : (azimuth > kRightAngle ? kRightAngle : azimuth);
}

double Strips::calc_azimuth(const Vec3& point) const {
  const Vec3 way = point - solid_.c;
  return elementary::atan2(dot(way, solid_.R.y), dot(way, solid_.R.x));
}

Strip Strips::calc_strip(const Axes& at) const {
  Core strip;
  strip.kind = Core::Kind::kBox;
  strip.R.z = solid_.gr * at.e + solid_.gz * solid_.R.z;
  strip.R.y = at.t;
  strip.R.x = solid_.gz * at.e - solid_.gr * solid_.R.z;  // outwards: (y × z)
  const Extent wide = calc_extent(at);
  strip.c = solid_.c + (0.5 * (solid_.r0 + solid_.r1)) * at.e + (0.5 * (wide.low + wide.high)) * at.t;
  strip.half = {0, 0.5 * (wide.high - wide.low), 0.5 * solid_.length};
  strip.bound = norm(strip.half);
  Strip out;
  if (!find_foot(strip, out.d)) {
    const Closest closest = calc_closest(strip, b_);
    if (closest.apart) {
      out.d = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
    } else {
      const Depth depth = calc_depth(strip, b_);
      out.d = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
    }
  }
  out.azimuth = at.azimuth;
  out.rate = -dot(out.d.normal, cross(solid_.R.z, out.d.on_a - solid_.c));
  return out;
}

bool Strips::find_foot(const Core& strip, Distance& out) const {
  const Vec3 n = dot(strip.R.x, b_.c - strip.c) < 0 ? -strip.R.x : strip.R.x;
  if (!has_single_support(b_, -n)) return false;
  const Vec3 nearest = calc_support(b_, -n), way = nearest - strip.c;
  const double height = dot(n, way);
  if (!(height > 0) || std::fabs(dot(strip.R.y, way)) > strip.half.y || std::fabs(dot(strip.R.z, way)) > strip.half.z)
    return false;
  out = {height, nearest - height * n, nearest, n, 0};
  return true;
}

TurningDirection Strips::calc_direction(const Strip& strip, const Axes& at) const {
  TurningDirection u;
  u.e = dot(strip.d.normal, at.e), u.t = is_half_ ? dot(strip.d.normal, at.t) : 0.0;
  u.z = dot(strip.d.normal, solid_.R.z);
  const double length = std::sqrt((u.e * u.e + u.t * u.t) + u.z * u.z);
  constexpr double kLeast = 0.1;
  if (length > kLeast) {
    u.e *= 1 / length, u.t *= 1 / length, u.z *= 1 / length;
  } else {
    u.e = -1, u.t = 0, u.z = 0;
  }
  u.of_wall = 0.5 * (solid_.r0 + solid_.r1) * u.e + 0.5 * solid_.length * std::fabs(solid_.gr * u.e + solid_.gz * u.z);
  if (has_rims_) {
    const double roundness = calc_roundness(u);
    const double centre = dot(b_.c - solid_.c, solid_.R.z), half = b_.h * dot(b_.R.z, solid_.R.z);
    u.residue[0] = u.z * (centre - half) - b_.r0 * roundness;
    u.residue[1] = u.z * (centre + half) - b_.r1 * roundness;
  } else {
    u.residue[0] = u.residue[1] = calc_extent_of_b(u.z * solid_.R.z);
  }
  return u;
}

Reach Strips::calc_reach(const TurningDirection& u, const Axes& at) const {
  const Vec3 d = -((u.e * at.e + u.t * at.t) + u.z * solid_.R.z);
  if (!has_rims_) {
    const double reach = calc_extent_of_b(d) + u.residue[0];
    return {{reach, reach}};
  }
  const double x = dot(d, b_.R.z), square = 1 - x * x, across = square > 0 ? std::sqrt(square) : 0.0;
  const double centre = dot(d, b_.c - solid_.c);
  return {
      {((centre - b_.h * x) + b_.r0 * across) + u.residue[0], ((centre + b_.h * x) + b_.r1 * across) + u.residue[1]}};
}

double Strips::calc_bound(const TurningDirection& u, double azimuth, const Reach& at) const {
  return calc_bound_by_parts(u, azimuth, azimuth, at.of[0], at.of[1]);
}

double Strips::calc_bound(const TurningDirection& u, double from, double to, const HalfArc& half_arc,
                          const Reach& at_from, const Reach& at_to) const {
  const double s = half_arc.sine, c = half_arc.cosine;
  const double cosine = 1 - 2 * s * s;  // of the arc
  const auto calc_most = [&](double x, double y) {
    if (!(y > x * cosine && x > y * cosine)) return x > y ? x : y;
    const double half = (y - x) / (2 * s);
    return std::sqrt(half * half + x * y) / c;
  };
  return calc_bound_by_parts(u, from, to, calc_most(at_from.of[0], at_to.of[0]), calc_most(at_from.of[1], at_to.of[1]));
}

Strips::Axes Strips::calc_axes(double azimuth) const {
  double s, c;
  elementary::sincos(azimuth, s, c);
  return {c * solid_.R.x + s * solid_.R.y, c * solid_.R.y - s * solid_.R.x, c, s, azimuth};
}

Strips::Extent Strips::calc_extent(const Axes& at) const {
  Extent out{-2 * size_, 2 * size_};
  if (!is_half_) return out;
  const double r = solid_.r0 < solid_.r1 ? solid_.r0 : solid_.r1, reach = at.cosine > 0 ? r * at.cosine : 0.0;
  if (at.sine > 0 && reach < out.high * at.sine) out.high = reach / at.sine;
  if (at.sine < 0 && reach < out.low * at.sine) out.low = reach / at.sine;
  return out;
}

double Strips::calc_extent_of_b(const Vec3& d) const { return dot(d, calc_support(b_, d) - solid_.c); }

double Strips::calc_roundness(const TurningDirection& u) const {
  const double tilt = dot(b_.R.z, solid_.R.z), sine = norm(cross(b_.R.z, solid_.R.z));
  const double p = std::sqrt(u.e * u.e + u.t * u.t) * sine, q = std::fabs(u.z * tilt);
  const double most = p + q < 1 ? p + q : 1.0, least = q > p ? q - p : 0.0;
  const double left = ((1 - p * p) + q * q) - q * most * (3 - most * most), square = 1 - least * least;
  return left > 0 && square > 0 ? left / (square * std::sqrt(square)) : 0.0;
}

double Strips::calc_bound_by_parts(const TurningDirection& u, double from, double to, double most_0,
                                   double most_1) const {
  const double reach_0 = most_0 - u.residue[0], reach_1 = most_1 - u.residue[1];
  const double bound = -(reach_0 > reach_1 ? reach_0 : reach_1) - u.of_wall;
  if (u.t > 0) return bound - u.t * calc_extent(calc_axes(from)).high;
  if (u.t < 0) return bound - u.t * calc_extent(calc_axes(to)).low;
  return bound;
}

}  // namespace unlatch::geometry
