#include "hil/run/extremes/smooth_part.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {

SmoothPart find_smooth_part(const unlatch::Quantity& quantity) {
  const bool is_angle = get_traits(quantity.kind).values == QuantityValues::kQuaternion;
  if (is_angle && quantity.part == unlatch::Quantity::kSize) return SmoothPart::kOfAngle;
  return unlatch::is_size(quantity) ? SmoothPart::kSquare : SmoothPart::kItself;
}

double to_smooth(SmoothPart part, double value) {
  if (part == SmoothPart::kSquare) return value * value;
  const double sine = std::sin(0.5 * value);
  return part == SmoothPart::kOfAngle ? 2 * sine * sine : value;
}

double from_smooth(SmoothPart part, double smooth) {
  if (part == SmoothPart::kItself) return smooth;
  const double positive = std::max(smooth, 0.0);
  return part == SmoothPart::kSquare ? std::sqrt(positive) : 2 * std::asin(std::min(1.0, std::sqrt(0.5 * positive)));
}

}  // namespace unlatch::hil
