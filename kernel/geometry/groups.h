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

// Likewise, with the widest slab across an axis of the box, on whose other side the sphere is. `of_b`: the sphere is
// about B.
struct SphereBound {
  double distance = -HUGE_VAL;            // m, as calc_lower_bound()
  double width = -HUGE_VAL;               // m, of the slab
  Vec3 normal{0, 0, 0}, centre{0, 0, 0};  // W: from the box to the sphere; of the sphere, m
  bool of_b = true;
};
SphereBound calc_sphere_bound(const ShapeNumbers& a, const Placement& at_a, const ShapeNumbers& b,
                              const Placement& at_b) noexcept;

// The box about a shape at its place.
struct Box {
  Vec3 c{0, 0, 0};       // m, centre, from the pair's origin
  Mat3 R = kIdentity3;   // its axes in W
  Vec3 half{0, 0, 0};    // m
  double bound = 0;      // m, radius of the sphere about it; infinite: the shape has no box
  bool polytope = true;  // no surface is curved
};
Box build_box(const ShapeNumbers& shape, const Placement& at, const Vec3& origin) noexcept;

// m, at most what calc_distance() returns, also of an overlap: the widest slab between the boxes across one of their
// six directions, or the way between their spheres. −infinity where a shape has no box.
double calc_slab_bound(const Box& a, const Box& b) noexcept;

// The widest slab between two boxes across one of their six directions.
struct Slab {
  double width = 0;      // m; negative where they overlap in all six
  Vec3 normal{0, 0, 0};  // from A to B, W axes
};
// Of boxes that are finite.
Slab calc_widest_slab(const Box& a, const Box& b) noexcept;

// Takes the distance of a pair of shapes, numbered `pair`, into the least of several, whatever the order: of equals the
// one with the least number.
inline void take(const Distance& d, std::size_t pair, std::size_t count_b, GroupDistance& least, std::size_t& number) {
  const bool first = d.distance == least.least.distance && pair < number;
  if (!(d.distance < least.least.distance) && !first) return;
  number = pair;
  least = {d, static_cast<int>(pair / count_b), static_cast<int>(pair % count_b)};
}

// Most shapes of a group whose boxes are compared.
inline constexpr std::size_t kMostBoxes = 24;

// `get_a(i)`, `get_b(i)`: the ShapeViews of the parts. The pair whose boxes are nearest is computed first, then those
// whose boxes are nearer than the least distance so far.
template <class A, class B>
GroupDistance calc_least(std::size_t count_a, const A& get_a, const Placement& at_a, std::size_t count_b,
                         const B& get_b, const Placement& at_b) noexcept {
  GroupDistance out;
  std::size_t number = count_a * count_b;
  const bool boxed = count_a * count_b > 1 && count_a <= kMostBoxes && count_b <= kMostBoxes;
  double bounds[kMostBoxes * kMostBoxes];
  if (boxed) {
    Box of_b[kMostBoxes];
    for (std::size_t k = 0; k < count_b; ++k) of_b[k] = build_box(get_b(k).numbers, at_b, at_a.p_WB);
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < count_a; ++i) {
      const Box of_a = build_box(get_a(i).numbers, at_a, at_a.p_WB);
      for (std::size_t k = 0; k < count_b; ++k) {
        const std::size_t pair = i * count_b + k;
        bounds[pair] = calc_slab_bound(of_a, of_b[k]);
        if (bounds[pair] < bounds[nearest]) nearest = pair;
      }
    }
    take(calc_distance(get_a(nearest / count_b), at_a, get_b(nearest % count_b), at_b), nearest, count_b, out, number);
    bounds[nearest] = HUGE_VAL;  // computed
  }
  const auto calc_far = [&](const ShapeNumbers& a, const ShapeNumbers& b) {
    return calc_bound((at_b.p_WB + at_b.R_WB * b.p_BS) - (at_a.p_WB + at_a.R_WB * a.p_BS), a.bound, b.bound);
  };
  for (std::size_t i = 0; i < count_a; ++i) {
    const ShapeView of_a = get_a(i);
    for (std::size_t k = 0; k < count_b; ++k) {
      const ShapeView of_b = get_b(k);
      const std::size_t pair = i * count_b + k;
      const double bound = boxed ? bounds[pair] : calc_far(of_a.numbers, of_b.numbers);
      if (bound > out.least.distance) continue;
      take(calc_distance(of_a, at_a, of_b, at_b), pair, count_b, out, number);
    }
  }
  return out;
}

}  // namespace unlatch::geometry
