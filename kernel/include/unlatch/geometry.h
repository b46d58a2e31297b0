// Signed distance between shapes: positive apart, 0 touching, negative the depth of an overlap.
//
// Shapes are given in the axes of their body, metres. Results are in world axes W. Same bits on every compiler and
// processor; no allocation, exception, C library function but sqrt, or state between calls; bounded iterations.
// Definitions and method: kernel/geometry/README.md.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "unlatch/shapes.h"

namespace unlatch::geometry {

inline constexpr int kMaxHullPoints = 256;    // of a hull
inline constexpr int kMaxProfilePoints = 64;  // of a hollow shape

// A mistake in a shape: its field, the fault, and the way to mend it.
struct ShapeError {
  std::string key;   // the field: "radius"
  std::string what;  // the fault: "radius is -1"
  std::string mend;  // the way to mend it: "greater than 0"
};

// Mistakes of a shape: numbers that are not finite, no volume, too many points. Empty: the shape can be compiled.
std::vector<ShapeError> check_shape(const Shape& shape);

// A shape made ready, but for its points: axes, half lengths, bounding sphere.
struct ShapeNumbers {
  ShapeKind kind = ShapeKind::kSphere;  // cylinder and cone have become frustums
  Vec3 p_BS{0, 0, 0};                   // m, centre of its axes in the body
  Mat3 R_BS = kIdentity3;             // its axes in the body; z along the axis or the normal, x to the middle of a half
  double half_length = 0;             // m, along z
  double r0 = 0, r1 = 0;              // m, radius at −z and +z end; of spheres and capsules r0
  double slope_r = 0, slope_z = 1;    // direction of a frustum's generator in the meridian plane, unit length
  double generator = 0;               // m, its length
  Vec3 half_size{0, 0, 0};            // m, of a box
  bool half = false;                  // of a hollow shape
  double bound = 0;                   // m, radius of the bounding sphere about p_BS; infinite for a half-space
  std::int32_t first = 0, count = 0;  // of its points in a plan's list
};

// A shape made ready.
struct CompiledShape : ShapeNumbers {
  std::vector<Vec3> points{};           // m, of a hull, in its axes
  std::vector<ProfilePoint> profile{};  // of a hollow shape, z from its centre
};

// A shape made ready, wherever its parts are.
struct ShapeView {
  ShapeView(const CompiledShape& shape) : numbers(shape), points(shape.points), profile(shape.profile) {}
  // `all_numbers`: of the shape; `all_points`, `all_profile`: its own.
  ShapeView(const ShapeNumbers& all_numbers, std::span<const Vec3> all_points,
            std::span<const ProfilePoint> all_profile)
      : numbers(all_numbers), points(all_points), profile(all_profile) {}

  const ShapeNumbers& numbers;            // axes, sizes
  std::span<const Vec3> points;           // of a hull, else empty
  std::span<const ProfilePoint> profile;  // of a hollow shape, else empty
};

// May allocate. The shape must be free of mistakes.
CompiledShape compile_shape(const Shape& shape);

// Place of a body: its origin and attitude in W.
struct Placement {
  Vec3 p_WB{0, 0, 0};      // m
  Mat3 R_WB = kIdentity3;  // body to world; columns of length 1
};

// Result of one pair.
struct Distance {
  double distance = std::numeric_limits<double>::infinity();  // m; negative: least translation that parts the two
  Vec3 on_a{0, 0, 0};                                         // m, witness of A in W
  Vec3 on_b{0, 0, 0};                                         // m, witness of B in W: on_a + distance · normal
  Vec3 normal{0, 0, 1};                                       // from A to B, unit length, in W
  // m, how far the distance may be from the truth by the certificate of its method; 0 for closed forms. Of an overlap:
  // how far the witnesses are from lying opposite each other.
  double gap = 0;
};

// Two hollow shapes and two half-spaces have no distance here; all other pairs have one.
bool has_distance(ShapeKind a, ShapeKind b) noexcept;

// Distance of two shapes; no allocation. Infinite for a pair that has none.
Distance calc_distance(const ShapeView& a, const Placement& at_a, const ShapeView& b, const Placement& at_b) noexcept;

// Bounding sphere of a union of shapes.
struct GroupNumbers {
  Vec3 centre{0, 0, 0};  // m, in the body
  double bound = 0;      // m, radius
};

// A named union of shapes of one body, without mass.
struct ShapeGroup : GroupNumbers {
  std::string name;                   // as scenarios call it
  std::vector<CompiledShape> shapes;  // all parts
};

// May allocate. The shapes must be free of mistakes.
ShapeGroup build_group(std::string name, std::span<const Shape> shapes);

// Result of a pair of groups: the least of all pairs of shapes, the first of equals.
struct GroupDistance {
  Distance least;                // of that pair
  int shape_a = 0, shape_b = 0;  // the pair's indices
};

// Least distance of two groups; pairs whose bounding spheres are farther apart than the least so far are skipped, which
// cannot change a bit of the result.
GroupDistance calc_distance(const ShapeGroup& a, const Placement& at_a, const ShapeGroup& b,
                            const Placement& at_b) noexcept;

// m, at most the distance: between bounding spheres. −infinity where one is unbounded.
double calc_lower_bound(const GroupNumbers& a, const Placement& at_a, const GroupNumbers& b,
                        const Placement& at_b) noexcept;

// Speeds of a body for conservative advancement.
struct Motion {
  Vec3 v_WB{0, 0, 0};   // m/s, of its origin, in W
  double turn = 0;      // rad/s, at most |angular velocity| in the interval
  double increase = 0;  // m/s², at most |acceleration| of the origin in the interval
};

// m/s, at most by which the distance of the two groups can fall per second at the beginning of the interval:
// relative speed of the origins and the turning of the parts farthest from them (Mirtich 1996).
double calc_closing_speed(const GroupNumbers& a, const Motion& of_a, const GroupNumbers& b,
                          const Motion& of_b) noexcept;

// m, at most the distance after `interval` seconds, from a distance now: a pair whose bound is above what is looked for
// need not be computed.
double calc_advanced_bound(double distance, const GroupNumbers& a, const Motion& of_a, const GroupNumbers& b,
                           const Motion& of_b, double interval) noexcept;

}  // namespace unlatch::geometry
