// Nearest points of two convex cores that are apart, to rounding, with a certificate.
//
// a = P_A(b), b = P_B(a), with P the projections: a fixed point of alternating projections (Cheney and Goldstein 1959).
// Its equation is solved by Newton's method for piecewise smooth functions (Qi and Sun 1993): P's derivative of the
// piece where the point is, a 2×2 system in the tangent plane, quadratic convergence once the features (rim, side, end
// face, edge, vertex) are the right ones. A step that does not shorten the distance is replaced by one of alternating
// projections, which always does. Cost: two to six iterations of two projections each.
//
// Certificate: with n along b − a, the support planes of A and B across n are −h_A(n) − h_B(−n) apart. No two points of
// A and B are nearer to each other than that, and the distance is at most |b − a|: the gap is the difference.
#pragma once

#include "kernel/geometry/core.h"

namespace unlatch::geometry {

struct Closest {
  Vec3 a{0, 0, 0}, b{0, 0, 0};
  Vec3 n{0, 0, 1};      // from a to b
  double distance = 0;  // m
  double gap = 0;       // m, |b − a| less the distance of the support planes
  bool apart = false;   // else the cores overlap or touch, and only a and b mean something
};

// m, size of a pair, to which rounding is relative: the sizes of both cores and the distance of their centres.
double calc_pair_size(const Core& a, const Core& b);

Closest calc_closest(const Core& a, const Core& b);
// The same of a point, as B: one projection. False if its result is not certified, or the point is not outside.
bool find_closest_to_point(const Core& a, const Vec3& b, Closest& out);
// The same, begun at a point of A.
Closest calc_closest_from(const Core& a, const Core& b, const Vec3& start, double size);

// Curvature of two cores' supports at nearest points: derivative of (a − b) by the normal's turning, in the basis u, v.
struct Curvature {
  Vec3 u{0, 0, 0}, v{0, 0, 0};
  double uu = 0, uv = 0, vv = 0;  // m; large where flat
};
Curvature calc_curvature(const Core& a, const Core& b, const Closest& at);

}  // namespace unlatch::geometry
