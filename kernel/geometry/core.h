// Convex cores: a shape at its place, without the radius of spheres and capsules. Each has an exact support point, an
// exact projection and the projection's derivative, all in closed form (of a hull: by GJK, exact for polytopes).
//
// Coordinates have the axes of W; the origin is that of the pair (distance.cc).
#pragma once

#include <cmath>

#include "unlatch/math.h"

namespace unlatch::geometry {

struct Core {
  enum class Kind { kPoint, kSegment, kFrustum, kHalfFrustum, kBox, kPoints };
  Kind kind = Kind::kPoint;
  Vec3 c{0, 0, 0};               // m, centre
  Mat3 R = kIdentity3;           // its axes; a half frustum is the part with local x ≥ 0
  double h = 0;                  // m, half length along z
  double r0 = 0, r1 = 0;         // m, radius at −h and at +h
  double gr = 0, gz = 1;         // direction of a generator from −h to +h in the meridian plane, unit length
  double length = 0;             // m, of a generator
  Vec3 half{0, 0, 0};            // m, of a box
  const Vec3* points = nullptr;  // m, of a hull, in its axes
  int count = 0;
  double bound = 0;  // m, no point is farther from c
};

// Derivative of a projection: l1 u1 u1ᵀ + l2 u2 u2ᵀ, u1 and u2 orthonormal, across the normal.
struct Tangent {
  Vec3 u1{0, 0, 0}, u2{0, 0, 0};
  double l1 = 0, l2 = 0;
};

struct Projection {
  Vec3 p{0, 0, 0};  // nearest point of the core
  Tangent J;        // only outside
  bool inside = false;
};

// Sets the generator of a frustum from h, r0 and r1.
void update_generator(Core& core);

Vec3 calc_support(const Core& core, const Vec3& d);
inline double calc_extent(const Core& core, const Vec3& n) { return dot(n, calc_support(core, n)); }

Projection calc_projection(const Core& core, const Vec3& x);

// How far the projection of x is from the borders of the feature (face, side, rim, edge, vertex, end) that it lies on:
// smooth functions of x near those borders, one of which changes sign where the feature changes, and with it the
// projection's derivative. Those that a core does not have are 1.
struct Margins {
  Vec3 of;             // m
  bool known = false;  // only outside, and not of hulls and half frustums
};
Margins calc_margins(const Core& core, const Vec3& x);

inline Vec3 to_local(const Core& core, const Vec3& x) { return transpose_times(core.R, x - core.c); }
inline Vec3 to_pair(const Core& core, const Vec3& x) { return core.c + core.R * x; }
inline bool is_polytope(const Core& core) {
  return core.kind != Core::Kind::kFrustum && core.kind != Core::Kind::kHalfFrustum;
}

// A unit vector across n; the same for the same n.
inline Vec3 calc_across(const Vec3& n) {
  const double x = std::fabs(n.x), y = std::fabs(n.y), z = std::fabs(n.z);
  const Vec3 e = x <= y && x <= z ? Vec3{1, 0, 0} : (y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1});
  const Vec3 t = cross(n, e);
  return (1.0 / norm(t)) * t;
}

}  // namespace unlatch::geometry
