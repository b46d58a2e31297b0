// Reference distances of thin walls, without the kernel's: exact distances of points to solids over all points of
// the wall, extents over all directions.
#pragma once

#include "tests/kernel/geometry/solids.h"

namespace unlatch::test {

// Least distance, m, of the body to the points of the hollow shape, whose axis is z from the origin and whose side is
// x; overlaps count as 0.
double search_wall(const geometry::Shape& wall, const geometry::Shape& body, const geometry::Placement& at);

// Signed distance, m, of a body that crosses the wall of one frustum (a profile of two points) or its half about x:
// the greater of minus its way out of the solid that the wall bounds, and of the least over the azimuths of minus its
// way out of the tangent strip, both by dense searches of directions.
double search_crossed_wall(const geometry::Shape& wall, const geometry::Shape& body, const geometry::Placement& at);

}  // namespace unlatch::test
