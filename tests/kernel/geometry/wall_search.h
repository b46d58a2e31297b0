// Reference distances of thin walls, without the kernel's: exact distances of points to solids, over all points of the
// wall.
#pragma once

#include "tests/kernel/geometry/solids.h"

namespace unlatch::test {

// Distance, m, of the point of W to the convex solid, exact; 0 inside.
double calc_point_distance(const geometry::Shape& solid, const geometry::Placement& at, const Vec3& p);

// Least distance, m, of the body to the points of the hollow shape, whose axis is z from the origin and whose side is
// x; overlaps count as 0. `azimuths` are tried all round; the search goes on at each of their local minima.
double search_wall(const geometry::Shape& wall, const geometry::Shape& body, const geometry::Placement& at,
                   int azimuths);

// Signed distance, m, of a body that crosses the wall of one frustum (a profile of two points): the greater of its
// distance to the convex solid, by the kernel, and of the least over the azimuths of minus its way out of the tangent
// strip, by a dense search of directions in the meridian plane.
double search_crossed_wall(const geometry::Shape& wall, const geometry::Shape& body, const geometry::Placement& at);

}  // namespace unlatch::test
