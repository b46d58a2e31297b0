// Signed distance of two convex cores with radii, and of a thin wall and a convex core.
#pragma once

#include "kernel/geometry/compiled_shape.h"
#include "kernel/geometry/core.h"

namespace unlatch::geometry {

// A core and the radius around it.
struct Rounded {
  Core core;
  double radius = 0;  // m
};

// Result in the pair's coordinates; `normal` from a to b.
Distance calc_convex(const Rounded& a, const Rounded& b);

// The wall of a frustum, or half of one (the part with local x ≥ 0): A, given by its solid.
Distance calc_wall(const Core& solid, const Rounded& b);

}  // namespace unlatch::geometry
