// Depth of two convex cores that overlap: the least translation that parts them, min over unit n of h_A(n) + h_B(−n)
// (Cameron and Culley 1986). Not convex: there are many local minima.
//
// Global: the expanding polytope (van den Bergen 2001) inside A − B. The offset of its nearest face is a lower bound of
// the depth; each face that might hold the minimum is polished, so that the best polished depth is an upper bound.
// Polishing: B is moved out along n by s, more than its depth along n, and the normal between the nearest points of the
// parted cores (closest.h) is a better n: the exact one on a face; elsewhere Newton's method with the curvatures of the
// supports improves it.
#pragma once

#include "kernel/geometry/closest.h"

namespace unlatch::geometry {

struct Depth {
  Vec3 a{0, 0, 0}, b{0, 0, 0};  // b − a = −depth n
  Vec3 n{0, 0, 1};              // B moved by depth n touches A
  double depth = 0;             // m
  double gap = 0;               // m, how far the witnesses are from lying opposite each other along n
};

// Local minimum next to n.
Depth calc_depth_near(const Core& a, const Core& b, const Vec3& n, double size);

// Global minimum, of overlapping cores.
Depth calc_depth(const Core& a, const Core& b);

}  // namespace unlatch::geometry
