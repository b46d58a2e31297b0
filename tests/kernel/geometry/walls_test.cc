// Distances to thin walls: closed forms, and the least distance to the wall's points, by a dense search.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/kernel/geometry/wall_search.h"

namespace unlatch::test::walls_test {
namespace {

using geometry::CompiledShape;
using geometry::Distance;
using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;

constexpr double kRounding = 1e-13;  // m, of shapes of some metres

// Builds a hollow shape about z from 0 to the last z.
Shape hollow(std::vector<geometry::ProfilePoint> profile, bool half = false) {
  return {.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = std::move(profile), .half = half, .side = {1, 0, 0}};
}
Shape sphere(Vec3 centre, double r) { return {.kind = ShapeKind::kSphere, .from = centre, .radius = r}; }

Distance measure(const Shape& a, const Shape& b) {
  return calc_distance(geometry::compile_shape(a), {}, geometry::compile_shape(b), {});
}

TEST(GeometryWalls, ASphereInATubeIsAsFarAsTheWallIsFromItsSide) {
  const Shape tube = hollow({{0, 2}, {5, 2}});
  for (const double x : {0.5, 1.4, 1.6}) {  // 1.6: stands out of the wall by 0.1
    const Distance d = measure(tube, sphere({x, 0, 2}, 0.5));
    EXPECT_NEAR(d.distance, 1.5 - x, kRounding);
    EXPECT_NEAR(d.normal.x, -1, kRounding);
    EXPECT_NEAR(d.on_a.x, 2, kRounding);
    EXPECT_NEAR(d.on_b.x, x + 0.5, kRounding);
  }
}

TEST(GeometryWalls, ASphereOutsideOfATubeIsAsFarAsItsSideIsFromTheWall) {
  const Shape tube = hollow({{0, 2}, {5, 2}});
  for (const double x : {3.0, 2.4}) EXPECT_NEAR(measure(tube, sphere({0, x, 2}, 0.5)).distance, x - 2.5, kRounding);
}

TEST(GeometryWalls, ASphereBeforeAnOpenEndIsAsFarAsTheRim) {
  const Shape tube = hollow({{0, 2}, {5, 2}});
  EXPECT_NEAR(measure(tube, sphere({0.5, 0, 6}, 0.5)).distance, std::sqrt(1.5 * 1.5 + 1) - 0.5, kRounding);
  EXPECT_NEAR(measure(tube, sphere({2, 0, -1}, 0.5)).distance, 0.5, kRounding);
}

TEST(GeometryWalls, ACapsuleInATubeIsNearestWithItsOuterEnd) {
  const Shape tube = hollow({{0, 2}, {5, 2}});
  const Shape rod{.kind = ShapeKind::kCapsule, .from = {0, -0.3, 1}, .to = {0.4, 1.2, 4}, .radius = 0.1};
  EXPECT_NEAR(measure(tube, rod).distance, 2 - std::hypot(0.4, 1.2) - 0.1, kRounding);
}

TEST(GeometryWalls, ABoxStandsOutOfATubeByItsOutermostEdge) {
  const Shape tube = hollow({{-5, 2}, {5, 2}});
  for (const double x : {0.0, 0.5, 0.8}) {
    const Shape box{.kind = ShapeKind::kBox, .from = {x, 0, 0}, .size = {2, 2.4, 2}};
    const Distance d = measure(tube, box);
    EXPECT_NEAR(d.distance, 2 - std::hypot(x + 1, 1.2), 1e-9);
  }
}

TEST(GeometryWalls, AConeInAConicalSkirtIsAsFarAsBothSidesAreApart) {
  // Equal slope: every generator is equally near; displaced, the nearest is on the side of the displacement.
  const Shape skirt = hollow({{0, 2}, {4, 1}});
  const double k = 4 / std::sqrt(17.0);
  for (const double x : {0.0, 0.2, 0.6}) {
    const Shape nozzle{
        .kind = ShapeKind::kFrustum, .from = {x, 0, 1}, .to = {x, 0, 3}, .radius = 1.25, .end_radius = 0.75};
    EXPECT_NEAR(measure(skirt, nozzle).distance, (0.5 - x) * k, 1e-9);
  }
}

TEST(GeometryWalls, APayloadStandsInAFairingAndInEachHalf) {
  const Shape fairing = hollow({{0, 2}, {4, 2}, {6, 1.2}, {7, 0.3}});
  Shape half = fairing;
  half.half = true;
  half.side = {1, 0, 0};
  const Shape payload{.kind = ShapeKind::kCylinder, .from = {0.1, 0, 0.5}, .to = {0.1, 0, 2}, .radius = 1.5};
  EXPECT_NEAR(measure(fairing, payload).distance, 0.4, 1e-9);
  EXPECT_NEAR(measure(half, payload).distance, 0.4, 1e-9);
  half.side = {-1, 0, 0};  // its edges are nearer than its middle
  EXPECT_NEAR(measure(half, payload).distance, std::hypot(2, 0.1) - 1.5, 1e-9);
  // Rotated away by its half, it clears the payload.
  EXPECT_NEAR(measure(half, sphere({3, 0, 2}, 1)).distance, std::hypot(3, 2) - 1, 1e-9);
}

// Draws a body of a size beside the wall's, 0.02 to 2 m, whose points are within some sizes of its origin.
Shape draw_body(Random& random, ShapeKind kind, double size) {
  Shape s = draw_shape(random, kind);
  s.from = size * s.from, s.to = size * s.to;
  s.radius *= size, s.end_radius *= size, s.size = size * s.size;
  for (Vec3& p : s.points) p = size * p;
  return s;
}

// Draws a size between 0.02 and 2, as often small as large.
double draw_size(Random& random) { return 0.02 * std::exp(random.uniform(0, std::log(100.0))); }

// Farthest points of a body: a box's corners, a hull's points, a capsule's ends.
std::vector<Vec3> list_corners(const Shape& s) {
  if (s.kind == ShapeKind::kHull) return s.points;
  if (s.kind == ShapeKind::kCapsule) return {s.from, s.to};
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    const Vec3 half{(i & 1 ? 0.5 : -0.5) * s.size.x, (i & 2 ? 0.5 : -0.5) * s.size.y, (i & 4 ? 0.5 : -0.5) * s.size.z};
    corners.push_back(s.from + rotation_matrix(s.q_BS) * half);
  }
  return corners;
}

// Inside a wall the distance of a point is a concave function of it, so that of a body with corners the nearest point
// is a corner; all lie where their feet are on the wall, not at its ends.
void expect_the_distance_of_corners(std::uint64_t seed, int pairs) {
  Random random(seed);
  const ShapeKind kinds[] = {ShapeKind::kBox, ShapeKind::kCapsule, ShapeKind::kHull};
  for (int i = 0; i < pairs; ++i) {
    const double slope = i % 2 ? random.uniform(-0.4, 0.4) : 0;
    const CompiledShape wall = compile_shape(hollow({{-4, 1.7 - 4 * slope}, {4, 1.7 + 4 * slope}}));
    const Shape body = draw_body(random, kinds[i % 3], draw_size(random));
    const double distance_from_axis = random.uniform(0, 1.6), azimuth = random.uniform(-3.2, 3.2);
    const Placement at{
        {distance_from_axis * std::cos(azimuth), distance_from_axis * std::sin(azimuth), random.uniform(-0.3, 0.3)},
        draw_rotation(random)};
    double wanted = 1e9;
    for (const Vec3& corner : list_corners(body)) {
      const Vec3 p = at.p_WB + at.R_WB * corner;
      wanted = std::min(wanted, (1.7 + slope * p.z - std::hypot(p.x, p.y)) / std::hypot(1, slope));
    }
    if (body.kind == ShapeKind::kCapsule) wanted -= body.radius;
    if (wanted < 1e-6) continue;
    ASSERT_NEAR(calc_distance(wall, {}, compile_shape(body), at).distance, wanted, 1e-10)
        << "seed " << seed << ": pair " << i;
  }
}

TEST(GeometryWalls, FromWithinAreAsFarAsTheNearestCorner) { expect_the_distance_of_corners(21, 3000); }
TEST(GeometryWallsLong, FromWithinAreAsFarAsTheNearestCorner) { expect_the_distance_of_corners(22, 100000); }

// Bodies of all kinds and sizes beside, in and before walls, whole and half, of one piece or two.
void expect_the_distance_of_their_points(std::uint64_t seed, int pairs) {
  Random random(seed);
  int apart = 0, crossing = 0;
  for (int i = 0; i < pairs; ++i) {
    Shape wall = hollow({{0, 1.5}, {1, 1.3}, {2.5, 0.8}}, i % 2 == 1);
    if (i % 3 == 0) wall.profile = {{0, 1.2}, {2, 1.2}};
    const double size = draw_size(random);
    const Shape body = draw_body(random, kConvexKinds[i % 7], size);
    Placement at = draw_placement(random, 2);
    at.p_WB.z += 1;
    const double found = calc_distance(compile_shape(wall), {}, compile_shape(body), at).distance;
    const double wanted = search_wall(wall, body, at);
    ASSERT_NEAR(std::max(0.0, found), wanted, 1e-9 * 3) << "seed " << seed << ": pair " << i;
    crossing += found<0, apart += found> 0;
  }
  EXPECT_GT(apart, pairs / 2);
  EXPECT_GT(crossing, pairs / 20);
}

TEST(GeometryWalls, HaveTheDistanceOfTheirPoints) { expect_the_distance_of_their_points(11, 600); }
TEST(GeometryWallsLong, HaveTheDistanceOfTheirPoints) { expect_the_distance_of_their_points(23, 100000); }

void expect_the_depth_of_their_strips(std::uint64_t seed, int pairs) {
  Random random(seed);
  int crossing = 0;
  for (int i = 0; crossing < pairs; ++i) {
    Shape wall = hollow({{0, 1.5}, {2, 1.1}}, i % 2 == 1);
    if (i % 3 == 0) wall.profile = {{0, 1.2}, {2, 1.2}};
    const Shape body = draw_body(random, kConvexKinds[i % 7], draw_size(random));
    Placement at = draw_placement(random, 1.6);
    at.p_WB.z += 1;
    const double found = calc_distance(compile_shape(wall), {}, compile_shape(body), at).distance;
    if (!(found < -1e-6)) continue;
    ++crossing;
    EXPECT_NEAR(found, search_crossed_wall(wall, body, at), 1e-5 * 3) << "seed " << seed << ": pair " << i;
  }
}

TEST(GeometryWalls, AreCrossedByTheDepthOfTheirStrips) { expect_the_depth_of_their_strips(24, 20); }
TEST(GeometryWallsLong, AreCrossedByTheDepthOfTheirStrips) { expect_the_depth_of_their_strips(25, 1000); }

TEST(GeometryWalls, AreContinuousThroughTheTouch) {
  Random random(12);
  for (int i = 0; i < 14; ++i) {
    const Shape wall = hollow({{0, 1.5}, {2, 1.1}}, i % 2 == 1);
    const CompiledShape a = compile_shape(wall), b = compile_shape(draw_shape(random, kConvexKinds[i % 7]));
    const Mat3 R = draw_rotation(random);
    const Vec3 v = draw_direction(random), from = Vec3{0.1, 0, 1} - 1.5 * v;
    constexpr int kSteps = 300;
    const double dt = 3.0 / kSteps;
    double last = 0;
    for (int k = 0; k <= kSteps; ++k) {
      const double d = calc_distance(a, {}, b, {from + (k * dt) * v, R}).distance;
      if (k > 0) {
        ASSERT_LE(std::fabs(d - last), dt * 1.0000001 + 1e-9) << i << " at " << k;
      }
      last = d;
    }
  }
}

}  // namespace
}  // namespace unlatch::test::walls_test
