// Angles whose turns are counted.
#pragma once

#include <cmath>

namespace unlatch {

// The value of `angle` + 2πk nearest to `previous`, rad.
inline double unwind(double angle, double previous) {
  constexpr double kTwoPi = 6.283185307179586;
  return angle - kTwoPi * std::nearbyint((angle - previous) / kTwoPi);
}

}  // namespace unlatch
