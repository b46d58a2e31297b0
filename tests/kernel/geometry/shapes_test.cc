// Mistakes of shapes are reported with their field and the correction.
#include <gtest/gtest.h>

#include <limits>

#include "unlatch/geometry.h"

namespace unlatch::test::shapes_test {
namespace {

using geometry::check_shape;
using geometry::Shape;
using geometry::ShapeKind;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinite = std::numeric_limits<double>::infinity();

void expect_mistake(const Shape& shape, const std::string& key, const std::string& what) {
  const auto errors = check_shape(shape);
  ASSERT_EQ(errors.size(), 1u) << key;
  EXPECT_EQ(errors[0].key, key);
  EXPECT_NE(errors[0].what.find(what), std::string::npos) << errors[0].what;
  EXPECT_FALSE(errors[0].mend.empty());
}

TEST(GeometryShapes, NumbersThatAreNotFiniteAreRefused) {
  expect_mistake({.kind = ShapeKind::kSphere, .from = {0, kNan, 0}, .radius = 1}, "from", "not finite");
  expect_mistake({.kind = ShapeKind::kSphere, .radius = kNan}, "radius", "nan");
  expect_mistake({.kind = ShapeKind::kCapsule, .to = {1, 0, 0}, .radius = kInfinite}, "radius", "inf");
  expect_mistake({.kind = ShapeKind::kHull, .points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, kNan}}}, "points",
                 "point 4");
  expect_mistake({.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}, {kNan, 1}}}, "profile", "point 2");
}

TEST(GeometryShapes, ShapesWithoutVolumeAreRefused) {
  expect_mistake({.kind = ShapeKind::kSphere, .radius = 0}, "radius", "radius is 0");
  expect_mistake({.kind = ShapeKind::kCylinder, .to = {0, 0, 1}, .radius = -1}, "radius", "radius is -1");
  expect_mistake({.kind = ShapeKind::kCone, .radius = 1}, "to", "length 0");
  expect_mistake({.kind = ShapeKind::kFrustum, .to = {0, 0, 1}}, "radius", "without volume");
  expect_mistake({.kind = ShapeKind::kBox, .size = {1, 0, 1}}, "size", "1 × 0 × 1");
  expect_mistake({.kind = ShapeKind::kHull, .points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}}, "points", "plane");
  expect_mistake({.kind = ShapeKind::kHull, .points = {{0, 0, 0}}}, "points", "1 point");
}

TEST(GeometryShapes, DirectionsAndProfilesMustMeanSomething) {
  expect_mistake({.kind = ShapeKind::kHalfSpace}, "normal", "not a direction");
  expect_mistake({.kind = ShapeKind::kBox, .size = {1, 1, 1}, .q_BS = {0, 0, 0, 0}}, "attitude", "no rotation");
  expect_mistake({.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}}}, "profile", "1 point");
  expect_mistake({.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}, {0, 2}}}, "profile", "not beyond");
  expect_mistake({.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}, {1, -1}}}, "profile", "(1, -1)");
  expect_mistake({.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}, {1, 0}, {2, 0}}}, "profile", "axis");
  expect_mistake(
      {.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}, {1, 1}}, .half = true, .side = {0, 0, 2}},
      "side", "along the axis");
}

TEST(GeometryShapes, GoodShapesHaveNoMistakes) {
  EXPECT_TRUE(check_shape({.kind = ShapeKind::kCapsule, .to = {1, 0, 0}, .radius = 0}).empty());
  EXPECT_TRUE(check_shape({.kind = ShapeKind::kFrustum, .to = {0, 0, 1}, .radius = 1}).empty());
  EXPECT_TRUE(check_shape({.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}, {1, 1}}}).empty());
}

}  // namespace
}  // namespace unlatch::test::shapes_test
