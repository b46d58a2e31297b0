// Distances between shapes, against closed-form geometry.
#include "hil/scenario/shapes/clearance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "hil/scenario/base/from_eigen.h"

namespace unlatch::test::clearance_test {
namespace {

using geometry::Shape;
using hil::ClearanceMonitor;
using hil::Pose;
using hil::to_vec3;
using Kind = geometry::ShapeKind;
using Vector = Eigen::Vector3d;

constexpr double kExact = 1e-12;  // metres, for shapes of some metres

Shape capsule(const Vector& from, const Vector& to, double radius) {
  return {.kind = Kind::kCapsule, .from = to_vec3(from), .to = to_vec3(to), .radius = radius};
}
Shape sphere(const Vector& centre, double radius) {
  return {.kind = Kind::kSphere, .from = to_vec3(centre), .radius = radius};
}

// Pair of every shape of body 0 with every shape of body 1.
hil::ClearancePair all_of(const std::vector<std::vector<hil::BodyShape>>& shapes) {
  hil::ClearancePair pair{.a = {0, "a", {}}, .b = {1, "b", {}}, .except = {}};
  pair.a.shapes.resize(shapes[0].size());
  pair.b.shapes.resize(shapes[1].size());
  std::iota(pair.a.shapes.begin(), pair.a.shapes.end(), 0);
  std::iota(pair.b.shapes.begin(), pair.b.shapes.end(), 0);
  return pair;
}

std::vector<hil::BodyShape> body(const std::vector<Shape>& shapes) {
  std::vector<hil::BodyShape> list;
  for (const Shape& shape : shapes) list.push_back({"", "", shape});
  return list;
}

double distance(const Shape& a, const Shape& b, const Pose& at_a = {}, const Pose& at_b = {}) {
  const std::vector<std::vector<hil::BodyShape>> shapes{body({a}), body({b})};
  ClearanceMonitor monitor({all_of(shapes)}, shapes);
  monitor.update(0, {at_a, at_b});
  return monitor.get()[0].now;
}

TEST(Clearance, SegmentsOfAllSorts) {
  const Shape x = capsule({-1, 0, 0}, {1, 0, 0}, 0);
  EXPECT_NEAR(distance(x, capsule({0, -1, 3}, {0, 1, 3}, 0)), 3, kExact);              // crossing
  EXPECT_NEAR(distance(x, capsule({-1, 2, 0}, {1, 2, 0}, 0)), 2, kExact);              // parallel
  EXPECT_NEAR(distance(x, capsule({4, 0, 0}, {5, 0, 0}, 0)), 3, kExact);               // in line
  EXPECT_NEAR(distance(x, capsule({2, 1, 0}, {3, 5, 0}, 0)), std::sqrt(2.0), kExact);  // end to end
  EXPECT_NEAR(distance(x, capsule({0, 1, 0}, {0, 4, 0}, 0.25)), 0.75, kExact);         // end to side, thick
  EXPECT_NEAR(distance(x, sphere({0, 0, 5}, 1)), 4, kExact);
  EXPECT_EQ(distance(x, capsule({0, -1, 0}, {0, 1, 0}, 0)), 0);
}

// No pair of points is nearer than the closed form, and some pair is as near.
TEST(Clearance, SegmentDistanceIsTheLeastOverAllPoints) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto point = [&] { return Vector(u(random), u(random), u(random)); };
  for (int i = 0; i < 50; ++i) {
    const Vector p = point(), q = point(), r = point(), s = point();
    const double d = distance(capsule(p, q, 0), capsule(r, s, 0));
    double least = 1e9;
    constexpr int kGrid = 200;
    for (int a = 0; a <= kGrid; ++a)
      for (int b = 0; b <= kGrid; ++b)
        least = std::min(least, (p + (q - p) * a / kGrid - r - (s - r) * b / kGrid).norm());
    EXPECT_LE(d, least + kExact) << "seed " << kSeed << " case " << i;
    EXPECT_GE(d, least - 0.03) << "seed " << kSeed << " case " << i;  // the grid's pitch: at most 3.5 / 200 each
  }
}

TEST(Clearance, SolidsOfAllKinds) {
  const Shape ball = sphere({0, 0, 10}, 1);
  EXPECT_NEAR(distance(ball, Shape{.kind = Kind::kCylinder, .from = {0, 0, -1}, .to = {0, 0, 2}, .radius = 0.5}), 7,
              kExact);
  EXPECT_NEAR(distance(sphere({5, 0, 1}, 1),
                       Shape{.kind = Kind::kCylinder, .from = {0, 0, -1}, .to = {0, 0, 2}, .radius = 0.5}),
              3.5, kExact);
  EXPECT_NEAR(distance(ball, Shape{.kind = Kind::kCone, .from = {0, 0, 0}, .to = {0, 0, 4}, .radius = 1}), 5,
              kExact);  // base around from, apex at to
  EXPECT_NEAR(
      distance(sphere({0, 0, -3}, 1), Shape{.kind = Kind::kCone, .from = {0, 0, 0}, .to = {0, 0, 4}, .radius = 1}), 2,
      kExact);
  Shape box{.kind = Kind::kBox, .from = {1, 0, 0}, .size = {2, 4, 6}};
  EXPECT_NEAR(distance(ball, box), 6, kExact);
  box.q_BS = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};  // 90° about x
  EXPECT_NEAR(distance(ball, box), 7, kExact);
  Shape hull{.kind = Kind::kHull};
  hull.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.1, 0.1}};
  EXPECT_NEAR(distance(sphere({2, 2, 2}, 1), hull), 5 / std::sqrt(3.0) - 1, kExact);
  EXPECT_NEAR(distance(sphere({-1, 0.2, 0.2}, 1.25), hull), -0.25, kExact);  // 0.25 m deep in the face x = 0
}

TEST(Clearance, FollowsTheBodies) {
  const Shape x = capsule({0, 0, 0}, {1, 0, 0}, 0);
  const Pose turned{{0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector::UnitZ()))};
  EXPECT_NEAR(distance(x, sphere({0, 3, 0}, 1), turned), 1, kExact);
  EXPECT_NEAR(distance(x, Shape{.kind = Kind::kCylinder, .from = {0, 3, -1}, .to = {0, 3, 1}, .radius = 1}, turned), 1,
              kExact);
}

TEST(Clearance, OfAnOverlapIsMinusItsDepth) {
  EXPECT_NEAR(distance(sphere({0, 0, 0}, 1), sphere({1.5, 0, 0}, 1)), -0.5, kExact);
  const Shape tube{.kind = Kind::kHollow, .from = {0, 0, 0}, .to = {0, 0, 4}, .profile = {{0, 1}, {4, 1}}};
  EXPECT_NEAR(distance(sphere({0.2, 0, 2}, 0.5), tube), 0.3, kExact);  // inside, clear of the wall
  EXPECT_NEAR(distance(sphere({0.7, 0, 2}, 0.5), tube), -0.2, kExact);
}

TEST(Clearance, TellsTheWitnessesAndTheNearestShapes) {
  const std::vector<std::vector<hil::BodyShape>> shapes{body({sphere({0, 0, 0}, 1), sphere({3, 0, 0}, 1)}),
                                                        body({sphere({0, 0, 9}, 1), sphere({0, 0, 6}, 1)})};
  const ClearanceMonitor monitor({all_of(shapes)}, shapes);
  const hil::PairDistance found = monitor.calc(0, {{1, 0, 0}, kIdentity3}, {{1, 0, 0}, kIdentity3});
  EXPECT_NEAR(found.least.distance, 4, kExact);
  EXPECT_EQ(found.shape_a, 0);
  EXPECT_EQ(found.shape_b, 1);
  EXPECT_NEAR(norm(found.least.on_a - Vec3{1, 0, 1}), 0, kExact);
  EXPECT_NEAR(norm(found.least.on_b - Vec3{1, 0, 5}), 0, kExact);
}

TEST(Clearance, LeavesOutPairsOfShapes) {
  const std::vector<std::vector<hil::BodyShape>> shapes{body({sphere({0, 0, 0}, 1), sphere({0, 0, 1}, 1)}),
                                                        body({sphere({0, 0, 3}, 1), sphere({0, 0, 6}, 1)})};
  hil::ClearancePair pair = all_of(shapes);
  const auto calc = [&] { return ClearanceMonitor({pair}, shapes).calc(0, {}, {}).least.distance; };
  EXPECT_NEAR(calc(), 0, kExact);  // of 1 and 0
  pair.except = {{1, 0}};
  EXPECT_NEAR(calc(), 1, kExact);  // of 0 and 0
  pair.except = {{1, 0}, {0, 0}};
  EXPECT_NEAR(calc(), 3, kExact);  // of 1 and 1
  pair.except = {{1, 0}, {0, 0}, {1, 1}};
  EXPECT_NEAR(calc(), 4, kExact);
  pair.except = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
  EXPECT_THROW(calc(), std::invalid_argument);
}

// At 7000 km from the origin, positions are rounded to 1e-9 m; the distance of two near places is that of their
// difference.
TEST(Clearance, LosesNoDigitsFarFromTheOrigin) {
  const std::vector<std::vector<hil::BodyShape>> shapes{body({capsule({0, 0, 0}, {1, 0, 0}, 0.25)}),
                                                        body({sphere({0, 0, 0}, 0.25)})};
  const ClearanceMonitor monitor({all_of(shapes)}, shapes);
  const Vec3 far{7e6, 1e6, -3e6};
  EXPECT_EQ(monitor.calc(0, {far, kIdentity3}, {far + Vec3{0.5, 2, 0}, kIdentity3}).least.distance, 1.5);
}

TEST(Clearance, RemembersTheSmallestAndItsTime) {
  const std::vector<std::vector<hil::BodyShape>> shapes{body({sphere({0, 0, 0}, 1)}), body({sphere({0, 0, 0}, 1)})};
  ClearanceMonitor monitor({all_of(shapes)}, shapes);
  for (const double x : {5.0, 3.0, 4.0}) monitor.update(10 - x, {{}, {{x, 0, 0}, Eigen::Quaterniond::Identity()}});
  EXPECT_NEAR(monitor.get()[0].smallest, 1, kExact);
  EXPECT_EQ(monitor.get()[0].time, 7);
  EXPECT_NEAR(monitor.get()[0].now, 2, kExact);
}

TEST(Clearance, RemembersWhenTheyFirstTouch) {
  const std::vector<std::vector<hil::BodyShape>> shapes{body({sphere({0, 0, 0}, 1)}), body({sphere({0, 0, 0}, 1)})};
  ClearanceMonitor monitor({all_of(shapes)}, shapes);
  for (const double x : {5.0, 2.0, 1.0, 3.0}) monitor.update(10 - x, {{}, {{x, 0, 0}, Eigen::Quaterniond::Identity()}});
  EXPECT_EQ(monitor.get()[0].touch, 8);
  EXPECT_EQ(monitor.get()[0].smallest, -1);
}

TEST(Clearance, NeedsShapes) {
  const std::vector<std::vector<hil::BodyShape>> none(2), one{body({sphere({0, 0, 0}, 1)}), {}};
  EXPECT_THROW(ClearanceMonitor({all_of(none)}, none), std::invalid_argument);
  hil::ClearancePair pair{.a = {0, "a", {1}}, .b = {1, "b", {0}}, .except = {}};
  EXPECT_THROW(ClearanceMonitor({pair}, one), std::invalid_argument);
}

}  // namespace
}  // namespace unlatch::test::clearance_test
