// Shapes of bodies as a user describes them, in axes of their body, metres: for contacts and distances
// (unlatch/geometry.h).
#pragma once

#include <vector>

#include "unlatch/math.h"

namespace unlatch::geometry {

// Kinds of shapes. All are convex solids but the hollow ones, which are thin walls.
enum class ShapeKind {
  kSphere,     // centre `from`, `radius`
  kCapsule,    // all points within `radius` of the segment from–to; radius 0: the segment itself
  kCylinder,   // axis from–to, `radius`
  kCone,       // base of `radius` around `from`, apex at `to`
  kFrustum,    // axis from–to, `radius` at `from`, `end_radius` at `to`
  kBox,        // centre `from`, edge lengths `size`, attitude `q_BS`
  kHull,       // convex hull of `points`
  kHalfSpace,  // all points p with normal · (p − from) ≤ 0
  kHollow      // thin wall: `profile` turned about the axis from–to, both ends open; `half`: 180° of it
};

// A point of a hollow shape's profile.
struct ProfilePoint {
  double z = 0;  // m along the axis, from `from` towards `to`
  double r = 0;  // m, distance from the axis
};

// A shape as a user describes it, in body axes.
struct Shape {
  ShapeKind kind = ShapeKind::kSphere;  // says which of the members below count
  Vec3 from{0, 0, 0};                   // m
  Vec3 to{0, 0, 0};                     // m
  double radius = 0;                    // m
  double end_radius = 0;                // m
  Vec3 size{0, 0, 0};                   // m
  Quat q_BS{1, 0, 0, 0};                // attitude of a box in the body
  Vec3 normal{0, 0, 0};                 // of a half-space, away from it; of any length but 0
  std::vector<Vec3> points{};           // m
  std::vector<ProfilePoint> profile{};  // of a hollow shape; z increases
  bool half = false;                    // of a hollow shape: only the half that `side` points to
  Vec3 side{0, 0, 0};                   // of a half: from the axis to the middle of the half; across the axis
};

}  // namespace unlatch::geometry
