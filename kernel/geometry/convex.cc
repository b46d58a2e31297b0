#include "kernel/geometry/distance.h"
#include "kernel/geometry/middle.h"
#include "kernel/geometry/penetration.h"

namespace unlatch::geometry {
namespace {

constexpr double kCertified = 1e-10;  // of the pair's size: up to this gap no third method is tried

// Improves the normal of cores that are so near that the direction between their nearest points is uncertain
// (millionths of their size apart): B is moved away along the normal, as for a depth; there the same direction is well
// determined.
void sharpen(const Core& a, const Core& b, Closest& closest) {
  const Depth width = calc_depth_near(a, b, closest.n, calc_pair_size(a, b));
  const Vec3 between = width.b - width.a;
  const double distance = norm(between), gap = distance + width.depth;
  if (!(width.depth < 0) || !(gap < closest.gap)) return;
  closest.a = width.a;
  closest.b = width.b;
  closest.n = width.n;
  closest.distance = -width.depth;  // of the support planes: a lower bound
  closest.gap = gap > 0 ? gap : 0;
}

}  // namespace

Distance calc_convex(const Rounded& a, const Rounded& b) {
  Distance out;
  Closest closest = calc_closest(a.core, b.core);
  const double size = calc_pair_size(a.core, b.core);
  if (closest.apart) {
    if (closest.gap > kCertified * size) sharpen(a.core, b.core, closest);
    out = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
  } else {
    const Depth depth = calc_depth(a.core, b.core);
    out = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
  }
  move_to_middle(a.core, b.core, out.normal, size, out.on_a, out.on_b);
  out.distance -= a.radius + b.radius;
  out.on_a += a.radius * out.normal;
  out.on_b -= b.radius * out.normal;
  return out;
}

bool find_ball(const Rounded& a, const Vec3& centre, double radius, Distance& out) {
  Closest closest;
  if (!find_closest_to_point(a.core, centre, closest)) return false;
  out = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
  out.distance -= a.radius + radius;
  out.on_a += a.radius * out.normal;
  out.on_b -= radius * out.normal;
  return true;
}

}  // namespace unlatch::geometry
