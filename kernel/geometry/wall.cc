// Distance of a thin wall and a convex core. The wall is the side of a frustum S, or half of it, its ends open.
//
//   distance = max(out, in)
//   out = signed distance of B and the solid S
//   in  = min over azimuths θ of the signed distance of B and the tangent strip P_θ: the generator at θ, widened across
//   it
//         in the tangent plane (of a half wall: not beyond the plane of its edges)
//
// Apart, this is the distance to the wall: neither is more than it, because S and the strips contain the wall; where B
// is beside or before S, the nearest point of S is on the wall and `out` is exact, or on an open end and the nearest
// point of the wall is on its rim, where `in` is; where B is in S, a nearest strip has its nearest point on its
// generator, for turning a strip moves all its other points, and `in` is exact. Overlapping, it is minus the lesser of
// two depths: the greatest height by which B stands out of the wall, and the way out of the solid. Both are continuous.
#include <limits>

#include "kernel/geometry/distance.h"
#include "kernel/geometry/penetration.h"
#include "unlatch/elementary.h"

namespace unlatch::geometry {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kFullSamples = 48;  // around the wall; every second but for hulls, whose corners are narrow
constexpr int kHalfSamples = 25;  // the same of a half, edges included
constexpr int kMostRefinements = 40;
constexpr double kStationary = 1e-9;  // of the pair's size, per rad: what is left of an interval is less than it
constexpr double kTurn = 1e-9;        // rad; the distance is stationary there, so that its error is of second order

struct Strip {
  Distance d;
  double rate = 0;  // m/rad, of the distance by the azimuth
};

Strip calc_strip(const Core& solid, const Core& b, double azimuth, double size) {
  double s, c;
  elementary::sincos(azimuth, s, c);
  const Vec3 e = c * solid.R.x + s * solid.R.y, t = c * solid.R.y - s * solid.R.x;
  Core strip;
  strip.kind = Core::Kind::kBox;
  strip.R.z = solid.gr * e + solid.gz * solid.R.z;
  strip.R.y = t;
  strip.R.x = solid.gz * e - solid.gr * solid.R.z;  // outwards: (y × z)
  strip.c = solid.c + (0.5 * (solid.r0 + solid.r1)) * e;
  double low = -2 * size, high = 2 * size;
  if (solid.kind == Core::Kind::kHalfFrustum) {
    const double r = solid.r0 < solid.r1 ? solid.r0 : solid.r1, reach = c > 0 ? r * c : 0.0;
    if (s > 0 && reach < high * s) high = reach / s;
    if (s < 0 && reach < low * s) low = reach / s;
  }
  strip.c += (0.5 * (low + high)) * t;
  strip.half = {0, 0.5 * (high - low), 0.5 * solid.length};
  strip.bound = norm(strip.half);
  Strip out;
  const Closest closest = calc_closest(strip, b);
  if (closest.apart) {
    out.d = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
  } else {
    const Depth depth = calc_depth(strip, b);
    out.d = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
  }
  out.rate = -dot(out.d.normal, cross(solid.R.z, out.d.on_a - solid.c));
  return out;
}

// Between two samples: the root of the rate (Illinois, Dowell and Jarratt 1971), else the best that was seen.
void refine(const Core& solid, const Core& b, double size, double from, Strip left, double to, Strip right,
            Strip& best) {
  double weight_left = left.rate, weight_right = right.rate;
  if (!(weight_left < 0 && weight_right > 0)) return;
  int side = 0;
  for (int i = 0; i < kMostRefinements && to - from > kTurn; ++i) {
    // Every third step halves, so that the interval shrinks whatever the rate does.
    const double at =
        i % 3 == 2 ? 0.5 * (from + to) : from + (to - from) * (weight_left / (weight_left - weight_right));
    const Strip middle = calc_strip(solid, b, at, size);
    if (middle.d.distance < best.d.distance) best = middle;
    if (std::fabs(middle.rate) <= kStationary * size) return;
    if (middle.rate < 0) {
      from = at, weight_left = middle.rate;
      if (side == -1) weight_right *= 0.5;
      side = -1;
    } else {
      to = at, weight_right = middle.rate;
      if (side == 1) weight_left *= 0.5;
      side = 1;
    }
  }
}

Distance calc_in(const Core& solid, const Core& b) {
  const bool half = solid.kind == Core::Kind::kHalfFrustum;
  const int thin = b.kind == Core::Kind::kPoints ? 1 : 2;
  const int count = half ? (kHalfSamples - 1) / thin + 1 : kFullSamples / thin;
  const double step = half ? kPi / (count - 1) : 2 * kPi / count, first = half ? -0.5 * kPi : 0.0;
  const double size = calc_pair_size(solid, b);
  Strip samples[kFullSamples];
  Strip best;
  for (int i = 0; i < count; ++i) {
    samples[i] = calc_strip(solid, b, first + step * i, size);
    if (samples[i].d.distance < best.d.distance) best = samples[i];
  }
  const double coarse = best.d.distance;
  for (int i = 0; i < (half ? count - 1 : count); ++i) {
    const Strip &left = samples[i], &right = samples[(i + 1) % count];
    // Turning by half a step changes the distance by at most this.
    const double least = left.d.distance < right.d.distance ? left.d.distance : right.d.distance;
    const double reach = 0.25 * step * (std::fabs(left.rate) + std::fabs(right.rate)) + 1e-12 * size;
    if (least - reach <= coarse) refine(solid, b, size, first + step * i, left, first + step * (i + 1), right, best);
  }
  return best.d;
}

}  // namespace

Distance calc_wall(const Core& solid, const Rounded& b) {
  Distance out;
  const Closest closest = calc_closest(solid, b.core);
  if (closest.apart) {
    out = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
    const Vec3 on_wall = transpose_times(solid.R, out.on_a - solid.c);
    const double rho = solid.kind == Core::Kind::kHalfFrustum && !(on_wall.x > 0)
                           ? std::fabs(on_wall.y)
                           : std::sqrt(on_wall.x * on_wall.x + on_wall.y * on_wall.y);
    const double away = std::fabs((rho - solid.r0) * solid.gz - (on_wall.z + solid.h) * solid.gr);
    if (away > 1e-13 * solid.bound) {  // on an open end
      const Distance in = calc_in(solid, b.core);
      if (in.distance > out.distance) out = in;
    }
  } else {
    out = calc_in(solid, b.core);
    if (!(out.distance > 0)) {
      const Depth depth = calc_depth(solid, b.core);
      if (-depth.depth > out.distance) out = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
    }
  }
  out.distance -= b.radius;
  out.on_b -= b.radius * out.normal;
  return out;
}

}  // namespace unlatch::geometry
