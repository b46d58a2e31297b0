// A lower bound of the distance of two shapes that costs a small part of it.
#pragma once

#include "unlatch/geometry.h"

namespace unlatch::geometry {

// m, at most the distance: from the bounding sphere of the smaller shape to the box about the other, in the latter's
// axes. −infinity where one is unbounded, or they may overlap.
double calc_lower_bound(const ShapeNumbers& a, const Placement& at_a, const ShapeNumbers& b,
                        const Placement& at_b) noexcept;

}  // namespace unlatch::geometry
