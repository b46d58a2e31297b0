// What of a quantity is smooth, and goes with it: itself; the square of a vector's size, which has a corner at zero; of
// an angle between 0 and half a turn, which has one at either end, 1 - cos of it. Polynomials are of that.
#pragma once

#include "unlatch/quantities.h"

namespace unlatch::hil {

enum class SmoothPart { kItself, kSquare, kOfAngle };
SmoothPart find_smooth_part(const unlatch::Quantity& quantity);
double to_smooth(SmoothPart part, double value);
double from_smooth(SmoothPart part, double smooth);

}  // namespace unlatch::hil
