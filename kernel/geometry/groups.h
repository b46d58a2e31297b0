// The least distance of two unions of shapes, and bounds by which pairs are skipped.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "kernel/geometry/compiled_shape.h"

namespace unlatch::geometry {

inline constexpr double kRounding = 1e-12;  // of the bounds' sizes: bounds stay below distances in spite of rounding

// m, at most the distance of what lies in two spheres with these radii; −infinity where one is unbounded.
inline double calc_bound(const Vec3& between, double a, double b) {
  const double apart = norm(between);
  return std::isfinite(a) && std::isfinite(b) ? (apart - (a + b)) - kRounding * ((apart + a) + b)
                                              : -std::numeric_limits<double>::infinity();
}

// m, at most the distance of two shapes, at a small part of its cost: from the bounding sphere of the smaller shape to
// the box about the other, in the latter's axes. −infinity where one is unbounded, or they may overlap.
double calc_lower_bound(const ShapeNumbers& a, const Placement& at_a, const ShapeNumbers& b,
                        const Placement& at_b) noexcept;

// `get_a(i)`, `get_b(i)`: the ShapeViews of the parts.
template <class A, class B>
GroupDistance calc_least(std::size_t count_a, const A& get_a, const Placement& at_a, std::size_t count_b,
                         const B& get_b, const Placement& at_b) noexcept {
  GroupDistance out;
  for (std::size_t i = 0; i < count_a; ++i) {
    const ShapeView of_a = get_a(i);
    const Vec3 centre_a = at_a.p_WB + at_a.R_WB * of_a.numbers.p_BS;
    for (std::size_t k = 0; k < count_b; ++k) {
      const ShapeView of_b = get_b(k);
      const Vec3 between = (at_b.p_WB + at_b.R_WB * of_b.numbers.p_BS) - centre_a;
      if (calc_bound(between, of_a.numbers.bound, of_b.numbers.bound) > out.least.distance) continue;
      const Distance d = calc_distance(of_a, at_a, of_b, at_b);
      if (d.distance < out.least.distance) {
        out.least = d;
        out.shape_a = static_cast<int>(i);
        out.shape_b = static_cast<int>(k);
      }
    }
  }
  return out;
}

}  // namespace unlatch::geometry
