// How far a group of shapes reaches in a direction: supports, which bound distances from below. Wherever two convex
// groups are, the slab between them across any direction, from the reach of one to the reach of the other, is at most
// their signed distance.
#pragma once

#include "unlatch/geometry.h"

namespace unlatch::geometry {

// m, the greatest coordinate along a direction of unit length of any point of the group whose body is at a place; of
// hollow shapes, of the ball about them. Infinite where the group is unbounded.
double calc_reach(const ShapeGroup& group, const Placement& at, const Vec3& direction) noexcept;

// m, as deep as a shape's surface may be in another without that the depth is a search: the radius of spheres and
// capsules, whose distances are those of their cores. Infinite where no surface is curved. Of a group the least.
double get_exact_depth(const ShapeGroup& group) noexcept;

}  // namespace unlatch::geometry
