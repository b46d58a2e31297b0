// The middle of the touching region, where nearest points are not unique: faces and straight lines of the two cores
// that are parallel to each other and across the normal, to 1e-10 rad.
//
// Rule: the faces F_A(n) and F_B(−n), seen along n, overlap in a region. Two lines, or a line and a surface: the middle
// of the common line. Two surfaces: the centre of area of the common region. The rule does not know which body is A.
#pragma once

#include "kernel/geometry/core.h"

namespace unlatch::geometry {

// Moves the witnesses `a` and `b`, which lie opposite each other along n, to the middle.
void move_to_middle(const Core& A, const Core& B, const Vec3& n, double size, Vec3& a, Vec3& b);

}  // namespace unlatch::geometry
