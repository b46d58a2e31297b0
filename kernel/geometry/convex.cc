#include "kernel/geometry/distance.h"
#include "kernel/geometry/middle.h"
#include "kernel/geometry/penetration.h"

namespace unlatch::geometry {

Distance calc_convex(const Rounded& a, const Rounded& b) {
  Distance out;
  const Closest closest = calc_closest(a.core, b.core);
  if (closest.apart) {
    out = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
  } else {
    const Depth depth = calc_depth(a.core, b.core);
    out = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
  }
  move_to_middle(a.core, b.core, out.normal, calc_pair_size(a.core, b.core), out.on_a, out.on_b);
  out.distance -= a.radius + b.radius;
  out.on_a += a.radius * out.normal;
  out.on_b -= b.radius * out.normal;
  return out;
}

}  // namespace unlatch::geometry
