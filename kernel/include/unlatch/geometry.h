// Signed distance between shapes: positive apart, 0 touching, negative the depth of an overlap.
//
// Shapes are given in the axes of their body, metres. Results are in world axes W. Same bits on every compiler and
// processor; no allocation, exception, C library function but sqrt, or state between calls; bounded iterations.
// Definitions and method: kernel/geometry/README.md.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "unlatch/model/shapes.h"

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

// Bounding sphere of a union of shapes.
struct GroupNumbers {
  Vec3 centre{0, 0, 0};  // m, in the body
  double bound = 0;      // m, radius
};

struct CompiledShape;  // kernel/geometry/compiled_shape.h

// A named union of shapes of one body, without mass, made ready. Copies share its parts.
struct ShapeGroup : GroupNumbers {
  std::string name;                                           // as scenarios call it
  std::shared_ptr<const std::vector<CompiledShape>> parts{};  // all shapes
};

// May allocate. The shapes must be free of mistakes: check_shape().
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
