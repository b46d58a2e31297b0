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

// The same of a ball, as B; false where that takes more than one projection.
bool find_ball(const Rounded& a, const Vec3& centre, double radius, Distance& out);

// The wall of a frustum, or half of one (the part with local x ≥ 0): A, given by its solid.
Distance calc_wall(const Core& solid, const Rounded& b);

// Margins of both shapes at the witnesses of `d`, their distance: where one of them changes sign, the second derivative
// of the distance jumps. Not a number where they are not known: of hulls, walls and half-spaces, and where more than
// the radii overlap.
struct PairMargins {
  Vec3 on_a, on_b;  // m
};
PairMargins calc_pair_margins(const ShapeView& a, const Placement& at_a, const ShapeView& b, const Placement& at_b,
                              const Distance& d) noexcept;

// --- A sphere and a convex shape or a half-space, with the derivative of the normal: what the second derivative of the
// distance needs.
//
// Seen from the other shape, let x be the sphere's centre, P(x) the nearest point of the shape's core and J = dP/dx,
// all in closed form (core.h). The distance is D = |x − P(x)| less the radii, its gradient the normal n = (x − P)/D,
// and
//
//   dn/dx = (I − n nᵀ − J) / D,
//
// which is 0 at a face or a half-space and (I − n nᵀ)/D at a point: the curvature of the surface at the distance of x.
struct SphereDistance {
  double distance = 0;   // m, of the surfaces
  Vec3 centre{0, 0, 0};  // of the sphere, W, m
  Vec3 normal{0, 0, 1};  // from the other shape to the sphere, W
  double bend = 0;       // 1 / D, 1/m; 0 for a half-space
  Tangent kept;          // J
  bool outside = true;   // false: the centre lies within the core, and nothing else here counts

  // Rate of the normal, 1/s, seen from the other shape, if the centre moves there with u, m/s; both in axes of W.
  Vec3 calc_normal_rate(const Vec3& u) const {
    const Vec3 along =
        dot(u, normal) * normal + (kept.l1 * dot(u, kept.u1)) * kept.u1 + (kept.l2 * dot(u, kept.u2)) * kept.u2;
    return bend * (u - along);
  }
};

// True if the other shape is convex or a half-space, so that its distance from a sphere is computed here.
inline bool has_sphere_distance(ShapeKind other) noexcept { return other != ShapeKind::kHollow; }

SphereDistance calc_sphere_distance(const ShapeView& sphere, const Placement& at_sphere, const ShapeView& other,
                                    const Placement& at_other) noexcept;

// Two capsules: the place x of the capsule's axis that is nearest to the other's axis, with the distance of the sphere
// about it, whose radius is the capsule's.
struct CapsuleDistance {
  SphereDistance sphere;
  // Unit vector along the axis, W, if x lies between its ends, so that it moves along the axis; else zero.
  Vec3 axis{0, 0, 0};
};
CapsuleDistance calc_capsule_distance(const ShapeView& capsule, const Placement& at_capsule, const ShapeView& other,
                                      const Placement& at_other) noexcept;

}  // namespace unlatch::geometry
