// References for the tests of distances: supports and membership of shapes, written from their definitions, independent
// of the kernel's; random shapes and places.
#pragma once

#include <functional>
#include <vector>

#include "kernel/geometry/compiled_shape.h"
#include "tests/support/random.h"

namespace unlatch::test {

inline constexpr geometry::ShapeKind kConvexKinds[] = {geometry::ShapeKind::kSphere,   geometry::ShapeKind::kCapsule,
                                                       geometry::ShapeKind::kCylinder, geometry::ShapeKind::kCone,
                                                       geometry::ShapeKind::kFrustum,  geometry::ShapeKind::kBox,
                                                       geometry::ShapeKind::kHull};
inline constexpr const char* kConvexNames[] = {"Sphere", "Capsule", "Cylinder", "Cone", "Frustum", "Box", "Hull"};

Vec3 draw_vector(Random& random, double reach);
Vec3 draw_direction(Random& random);
Mat3 draw_rotation(Random& random);
// Draws a shape with sizes of 0.1 to 2 m, near the body's origin.
geometry::Shape draw_shape(Random& random, geometry::ShapeKind kind);
// Draws a shape of a kind by its number: the convex kinds, 7 a half-space, 8 a hollow shape.
geometry::Shape draw_any(Random& random, int kind);
geometry::Placement draw_placement(Random& random, double reach);

// Farthest extent, m, of the shape along the unit vector n of W, from W's origin.
double calc_extent(const geometry::Shape& shape, const geometry::Placement& at, const Vec3& n);

// Distance, m, of points of W to a convex solid, exact; 0 inside.
class PointDistance {
 public:
  PointDistance(const geometry::Shape& solid, const geometry::Placement& at);
  double operator()(const Vec3& p) const;

 private:
  struct Facet {
    Vec3 a, b, c, n;  // corners; outward unit normal
  };

  geometry::ShapeKind kind_;
  Vec3 from_, axis_;                     // m; unit vector
  double length_, radius_, end_radius_;  // m
  Mat3 R_WS_;                            // of a box
  Vec3 half_size_;                       // m, of a box
  std::vector<Facet> facets_;            // of a hull
};

// Least of a function of the direction over a dense set of directions, refined by pattern search from the least of them
// and from so many more that are 0.3 apart.
double search_directions(const std::function<double(const Vec3& n)>& function, int directions, int starts = 1);

// Least extent, m, of the two shapes' difference over the directions: depth of an overlap.
double search_depth(const geometry::Shape& a, const geometry::Placement& at_a, const geometry::Shape& b,
                    const geometry::Placement& at_b, int directions);

}  // namespace unlatch::test
