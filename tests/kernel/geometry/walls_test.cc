// Distances to thin walls: closed forms, and the least distance to the wall's generators, by a dense search.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/kernel/geometry/solids.h"

namespace unlatch::test {
namespace {

using geometry::CompiledShape;
using geometry::Distance;
using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;

constexpr double kRounding = 1e-13;  // m, of shapes of some metres
constexpr double kPi = 3.14159265358979323846;

// Builds a hollow shape about z from 0 to the last z.
Shape hollow(std::vector<geometry::ProfilePoint> profile, bool half = false) {
  return {.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = std::move(profile), .half = half, .side = {1, 0, 0}};
}
Shape sphere(Vec3 centre, double r) { return {.kind = ShapeKind::kSphere, .from = centre, .radius = r}; }

Distance measure(const Shape& a, const Shape& b) {
  return calc_distance(geometry::compile_shape(a), {}, geometry::compile_shape(b), {});
}

// Least distance, m, of the body to the wall's generators, each a segment: overlaps count as 0.
double search_wall(const Shape& wall, const CompiledShape& b, const Placement& at_b) {
  double least = 1e9;
  for (std::size_t i = 0; i + 1 < wall.profile.size(); ++i) {
    const auto &from = wall.profile[i], &to = wall.profile[i + 1];
    const auto at = [&](double angle) {
      const double c = std::cos(angle), s = std::sin(angle);
      const Shape line{
          .kind = ShapeKind::kCapsule, .from = {from.r * c, from.r * s, from.z}, .to = {to.r * c, to.r * s, to.z}};
      return std::max(0.0, calc_distance(geometry::compile_shape(line), {}, b, at_b).distance);
    };
    constexpr int kAngles = 720;
    const double span = wall.half ? kPi : 2 * kPi, first = wall.half ? -0.5 * kPi : 0, step = span / kAngles;
    int best = 0;
    double coarse = 1e9;
    for (int k = 0; k <= kAngles; ++k)
      if (const double d = at(first + k * step); d < coarse) coarse = d, best = k;
    double low = first + step * (best - 1), high = first + step * (best + 1);
    if (wall.half) low = std::max(low, first), high = std::min(high, first + span);
    for (int k = 0; k < 60; ++k) {  // golden section
      const double a = low + 0.3819660112501051 * (high - low), c = high - 0.3819660112501051 * (high - low);
      (at(a) < at(c) ? high : low) = at(a) < at(c) ? c : a;
    }
    least = std::min({least, coarse, at(0.5 * (low + high))});
  }
  return least;
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

TEST(GeometryWalls, HaveTheDistanceOfTheirGenerators) {
  Random random(11);
  int inside = 0, crossing = 0;
  for (int i = 0; i < 250; ++i) {
    Shape wall = hollow({{0, 1.5}, {1, 1.3}, {2.5, 0.8}}, i % 2 == 1);
    if (i % 3 == 0) wall.profile = {{0, 1.2}, {2, 1.2}};
    const CompiledShape a = compile_shape(wall), b = compile_shape(draw_shape(random, kConvexKinds[i % 7]));
    Placement at = draw_placement(random, 2.5);
    if (i % 5 == 0) at.p_WB = {0.1, 0, 1.3};
    const double found = calc_distance(a, {}, b, at).distance, wanted = search_wall(wall, b, at);
    EXPECT_NEAR(std::max(0.0, found), wanted, 1e-9 * 3) << i;
    crossing += found<0, inside += found> 0 && std::hypot(at.p_WB.x, at.p_WB.y) < 0.7;
  }
  EXPECT_GT(inside, 5);
  EXPECT_GT(crossing, 20);
}

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
}  // namespace unlatch::test
