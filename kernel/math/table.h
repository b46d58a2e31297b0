// Search in tables over one variable.
#pragma once

#include <cstddef>

namespace unlatch {

// The piece that holds s, by bisection: knot i with get_place(i) ≤ s < get_place(i + 1). `count` ≥ 2 knots, their
// places increasing; s is within them.
template <class GetPlace>
std::size_t find_piece(std::size_t count, double s, const GetPlace& get_place) {
  std::size_t low = 0, high = count - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (get_place(middle) <= s ? low : high) = middle;
  }
  return low;
}

}  // namespace unlatch
