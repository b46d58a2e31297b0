// Shapes made ready for distances: axes, half lengths, bounding spheres.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "unlatch/geometry.h"

namespace unlatch::geometry {

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

inline std::span<const CompiledShape> get_parts(const ShapeGroup& group) {
  return group.parts ? std::span<const CompiledShape>(*group.parts) : std::span<const CompiledShape>();
}

// Distance of two shapes; no allocation. Infinite for a pair that has none.
Distance calc_distance(const ShapeView& a, const Placement& at_a, const ShapeView& b, const Placement& at_b) noexcept;

}  // namespace unlatch::geometry
