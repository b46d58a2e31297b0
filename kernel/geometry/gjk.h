// The algorithm of Gilbert, Johnson and Keerthi (1988): least distance of two convex sets by support points alone.
// Exact to rounding for polytopes; for curved sets a start and a fallback. Nearest points of simplices by signed
// volumes (Montanari, Petrinic, Barbieri 2017), which stay right where a simplex is nearly flat.
#pragma once

#include "kernel/geometry/core.h"

namespace unlatch::geometry {

struct Gjk {
  Vec3 a{0, 0, 0}, b{0, 0, 0};  // nearest points
  Vec3 w[4];                    // simplex of support points a − b
  Vec3 wa[4], wb[4];
  int count = 0;
  bool overlap = false;  // to rounding
};

// `towards`: any direction, for instance from A to B.
Gjk calc_gjk(const Core& a, const Core& b, const Vec3& towards);

}  // namespace unlatch::geometry
