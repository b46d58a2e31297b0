// Distances with known formulas, ties with a known middle, and degenerate pairs.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/kernel/geometry/solids.h"

namespace unlatch::test::closed_forms_test {
namespace {

using geometry::Distance;
using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;

constexpr double kRounding = 1e-14;  // m, of shapes of 1 m
constexpr double kPi = 3.14159265358979323846;

Shape cylinder(Vec3 from, Vec3 to, double r) {
  return {.kind = ShapeKind::kCylinder, .from = from, .to = to, .radius = r};
}
Shape box(Vec3 centre, Vec3 size) { return {.kind = ShapeKind::kBox, .from = centre, .size = size}; }
Shape capsule(Vec3 from, Vec3 to, double r) {
  return {.kind = ShapeKind::kCapsule, .from = from, .to = to, .radius = r};
}
Shape sphere(Vec3 centre, double r) { return {.kind = ShapeKind::kSphere, .from = centre, .radius = r}; }

Distance measure(const Shape& a, const Shape& b) {
  return calc_distance(geometry::compile_shape(a), {}, geometry::compile_shape(b), {});
}

void expect_near(const Vec3& found, const Vec3& wanted, double tolerance) {
  EXPECT_NEAR(found.x, wanted.x, tolerance);
  EXPECT_NEAR(found.y, wanted.y, tolerance);
  EXPECT_NEAR(found.z, wanted.z, tolerance);
}

TEST(GeometryClosedForms, SpheresAreAsFarApartAsTheirCentresLessTheirRadii) {
  for (const double x : {5.0, 3.0, 2.5, 0.1}) {
    const Distance d = measure(sphere({0, 0, 0}, 1), sphere({x, 0, 0}, 2));
    EXPECT_DOUBLE_EQ(d.distance, x - 3);
    expect_near(d.normal, {1, 0, 0}, 0);
    expect_near(d.on_a, {1, 0, 0}, 0);
    expect_near(d.on_b, {x - 2, 0, 0}, kRounding);
  }
}

TEST(GeometryClosedForms, ConcentricSpheresAreAsDeepAsTheSumOfTheirRadii) {
  EXPECT_DOUBLE_EQ(measure(sphere({1, 2, 3}, 1), sphere({1, 2, 3}, 2)).distance, -3);
}

TEST(GeometryClosedForms, CrossingCapsulesPartAcrossBothAxes) {
  const Distance d = measure(capsule({-1, 0, 0}, {1, 0, 0}, 0.2), capsule({0, -1, 0}, {0, 1, 0}, 0.1));
  EXPECT_NEAR(d.distance, -0.3, kRounding);
  EXPECT_NEAR(std::fabs(d.normal.z), 1, kRounding);
}

TEST(GeometryClosedForms, ASphereBesideAConeIsNearestToItsSide) {
  // Cone of base 1 and height 1: the side's normal is (1, 1)/√2 through (0.5, 0.5).
  const Shape cone{.kind = ShapeKind::kCone, .from = {0, 0, 0}, .to = {0, 0, 1}, .radius = 1};
  const double k = std::sqrt(0.5);
  for (const double way : {1.0, 0.3, 0.1}) {
    const Distance d = measure(cone, sphere({0.5 + way * k, 0, 0.5 + way * k}, 0.2));
    EXPECT_NEAR(d.distance, way - 0.2, kRounding);
    expect_near(d.normal, {k, 0, k}, kRounding);
    expect_near(d.on_a, {0.5, 0, 0.5}, kRounding);
  }
}

TEST(GeometryClosedForms, ASphereInABoxPartsThroughTheNearestFace) {
  const Distance d = measure(box({0, 0, 0}, {2, 4, 6}), sphere({0.75, 0.5, -1}, 0.1));
  EXPECT_NEAR(d.distance, -0.35, kRounding);
  expect_near(d.normal, {1, 0, 0}, kRounding);
  expect_near(d.on_a, {1, 0.5, -1}, 1e-12);
}

TEST(GeometryClosedForms, CoplanarRimsAreAsFarApartAsTheirCirclesInTheirPlane) {
  // Two upright cylinders beside each other, and one askew above the other.
  EXPECT_NEAR(measure(cylinder({0, 0, 0}, {0, 0, 1}, 1), cylinder({3, 4, 0}, {3, 4, 1}, 0.5)).distance, 3.5, kRounding);
  const Distance d = measure(cylinder({0, 0, 0}, {0, 0, 1}, 1), cylinder({5, 0, 2}, {5, 0, 3}, 1));
  EXPECT_NEAR(d.distance, std::sqrt(9.0 + 1), kRounding);
  expect_near(d.on_a, {1, 0, 1}, 1e-12);
  expect_near(d.on_b, {4, 0, 2}, 1e-12);
}

TEST(GeometryClosedForms, AHalfSpaceIsAsFarAsTheLowestPoint) {
  const Shape ground{.kind = ShapeKind::kHalfSpace, .from = {0, 0, 1}, .normal = {0, 0, 2}};
  EXPECT_NEAR(measure(ground, sphere({3, 4, 5}, 1)).distance, 3, kRounding);
  EXPECT_NEAR(measure(ground, box({3, 4, 1}, {2, 2, 2})).distance, -1, kRounding);
  const Distance d = measure(cylinder({1, 1, 3}, {1, 1, 5}, 0.5), ground);
  EXPECT_NEAR(d.distance, 2, kRounding);
  expect_near(d.normal, {0, 0, -1}, 0);
  expect_near(d.on_a, {1, 1, 3}, kRounding);  // the middle of its base
  expect_near(d.on_b, {1, 1, 1}, kRounding);
}

TEST(GeometryClosedForms, AHalfSpaceIsAsFarAsTheLowestPointOfAWall) {
  const Shape ground{.kind = ShapeKind::kHalfSpace, .from = {0, 0, 1}, .normal = {0, 0, 2}};
  Shape tube{.kind = ShapeKind::kHollow, .from = {0, 0, 3}, .to = {0, 0, 5}, .profile = {{0, 0.5}, {1, 1}, {2, 0.2}}};
  EXPECT_NEAR(measure(tube, ground).distance, 2, kRounding);
  tube.from = {0, 0, 3}, tube.to = {4, 0, 3};  // lying: the rim of 1 m is 1 m below the axis
  const Distance whole = measure(ground, tube);
  EXPECT_NEAR(whole.distance, 1, kRounding);
  expect_near(whole.on_a, {1, 0, 1}, 1e-12);
  expect_near(whole.on_b, {1, 0, 2}, 1e-12);
  tube.half = true, tube.side = {0, 0, 1};  // the upper half: its edges are at the height of the axis
  EXPECT_NEAR(measure(ground, tube).distance, 2, kRounding);
  tube.from = {0, 0, 1.5}, tube.to = {4, 0, 1.5}, tube.half = false;  // 0.5 m too deep
  EXPECT_NEAR(measure(tube, ground).distance, -0.5, kRounding);
}

TEST(GeometryTies, ParallelCapsulesMeetInTheMiddleOfTheirCommonLength) {
  const Distance d = measure(capsule({0, 0, 0}, {4, 0, 0}, 0.1), capsule({1, 2, 0}, {9, 2, 0}, 0.2));
  EXPECT_NEAR(d.distance, 1.7, kRounding);
  expect_near(d.on_a, {2.5, 0.1, 0}, 1e-12);
  expect_near(d.on_b, {2.5, 1.8, 0}, 1e-12);
}

TEST(GeometryTies, BoxesFaceToFaceMeetInTheCentreOfTheirCommonArea) {
  for (const double z : {3.0, 1.5}) {  // apart, and overlapping by 0.5
    const Distance d = measure(box({0, 0, 0}, {4, 4, 2}), box({1.5, 1, z}, {3, 4, 2}));
    EXPECT_NEAR(d.distance, z - 2, kRounding);
    expect_near(d.normal, {0, 0, 1}, kRounding);
    expect_near(d.on_a, {1, 0.5, 1}, 1e-12);
  }
}

TEST(GeometryTies, ACylinderOnABoxMeetsInTheCentreOfTheCommonArea) {
  const Shape table = box({0, 0, -1}, {4, 4, 2});
  expect_near(measure(table, cylinder({0.5, 0.25, 1}, {0.5, 0.25, 3}, 1)).on_a, {0.5, 0.25, 0}, 1e-12);
  // Half of the disc is beyond the edge: the centre of a half disc is 4 r / 3π from its diameter.
  expect_near(measure(table, cylinder({2, 0, 1}, {2, 0, 3}, 1)).on_a, {2 - 4 / (3 * kPi), 0, 0}, 1e-12);
}

TEST(GeometryTies, DiscsMeetInTheCentreOfTheirLens) {
  const Distance same = measure(cylinder({0, 0, 0}, {0, 0, 1}, 1), cylinder({1, 0, 2}, {1, 0, 3}, 1));
  expect_near(same.on_a, {0.5, 0, 1}, 1e-12);
  // Unequal discs: the centre of area by a sum over strips.
  const double ra = 1, rb = 0.7, way = 0.9;
  double area = 0, moment = 0;
  constexpr int kStrips = 2000000;
  for (int i = 0; i < kStrips; ++i) {
    const double x = -ra + (2 * ra) * (i + 0.5) / kStrips, u = x - way;
    const double half = std::sqrt(std::fmax(0, std::fmin(ra * ra - x * x, rb * rb - u * u)));
    area += half, moment += half * x;
  }
  const Distance d = measure(cylinder({0, 0, 0}, {0, 0, 1}, ra), cylinder({way, 0, 2}, {way, 0, 3}, rb));
  EXPECT_NEAR(d.on_a.x, moment / area, 1e-8);
}

TEST(GeometryTies, ALyingCylinderOnABoxMeetsInTheMiddleOfTheLine) {
  const Distance d = measure(box({0, 0, -1}, {4, 4, 2}), cylinder({1, 0, 0.5}, {7, 0, 0.5}, 0.5));
  EXPECT_NEAR(d.distance, 0, kRounding);
  expect_near(d.on_b, {1.5, 0, 0}, 1e-9);
}

TEST(GeometryTies, TwoHullsFaceToFaceMeetInTheCentreOfTheirCommonArea) {
  Shape a{.kind = ShapeKind::kHull}, b{.kind = ShapeKind::kHull};
  a.points = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 1, 0}, {1, 1, -2}};
  b.points = {{1, 0, 1}, {5, 0, 1}, {1, 4, 1}, {1, 1, 3}};
  // Common area: the square 1…2 × 0…2.
  const Distance d = measure(a, b);
  EXPECT_NEAR(d.distance, 1, kRounding);
  expect_near(d.on_a, {1.5, 1, 0}, 1e-12);
}

TEST(GeometryClosedForms, TwoHalfSpacesHaveNoDistance) {
  const Shape ground{.kind = ShapeKind::kHalfSpace, .normal = {0, 0, 1}};
  EXPECT_EQ(measure(ground, ground).distance, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(geometry::has_distance(ShapeKind::kHalfSpace, ShapeKind::kHalfSpace));
  EXPECT_TRUE(geometry::has_distance(ShapeKind::kHalfSpace, ShapeKind::kHollow));
}

}  // namespace
}  // namespace unlatch::test::closed_forms_test
