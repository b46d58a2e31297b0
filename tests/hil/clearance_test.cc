// Distances between shapes, against closed-form geometry.
#include "hil/analysis/clearance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace unlatch::test {
namespace {

using hil::ClearanceMonitor;
using hil::Pose;
using hil::Shape;
using Kind = hil::Shape::Kind;
using Vector = Eigen::Vector3d;

constexpr double kExact = 1e-12;    // closed forms, metres
constexpr double kIterated = 1e-5;  // GJK on curved shapes, metres

Shape capsule(const Vector& from, const Vector& to, double radius) { return {Kind::kCapsule, from, to, radius}; }

double distance(const Shape& a, const Shape& b, const Pose& at_a = {}, const Pose& at_b = {}) {
  ClearanceMonitor monitor({{0, 1}}, {{a}, {b}});
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
  EXPECT_NEAR(distance(x, {Kind::kSphere, {0, 0, 5}, {}, 1}), 4, kExact);
  EXPECT_EQ(distance(x, capsule({0, -1, 0}, {0, 1, 0}, 0)), 0);
}

// No pair of points is nearer than the closed form says, and some pair is as near.
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
  const Shape ball{Kind::kSphere, {0, 0, 10}, {}, 1};
  EXPECT_NEAR(distance(ball, {Kind::kCylinder, {0, 0, -1}, {0, 0, 2}, 0.5}), 7, kIterated);
  EXPECT_NEAR(distance({Kind::kSphere, {5, 0, 1}, {}, 1}, {Kind::kCylinder, {0, 0, -1}, {0, 0, 2}, 0.5}), 3.5,
              kIterated);
  EXPECT_NEAR(distance(ball, {Kind::kCone, {0, 0, 0}, {0, 0, 4}, 1}), 5, kIterated);  // base around from, apex at to
  EXPECT_NEAR(distance({Kind::kSphere, {0, 0, -3}, {}, 1}, {Kind::kCone, {0, 0, 0}, {0, 0, 4}, 1}), 2, kIterated);
  Shape box{Kind::kBox, {1, 0, 0}};
  box.size = {2, 4, 6};
  EXPECT_NEAR(distance(ball, box), 6, kIterated);
  box.q_BS = Eigen::AngleAxisd(M_PI / 2, Vector::UnitX());
  EXPECT_NEAR(distance(ball, box), 7, kIterated);
  Shape hull{Kind::kHull};
  hull.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.1, 0.1}};
  EXPECT_NEAR(distance({Kind::kSphere, {2, 2, 2}, {}, 1}, hull), 5 / std::sqrt(3.0) - 1, kIterated);
  EXPECT_EQ(distance({Kind::kSphere, {0.2, 0.2, 0.2}, {}, 1}, hull), 0);
}

TEST(Clearance, FollowsTheBodies) {
  const Shape x = capsule({0, 0, 0}, {1, 0, 0}, 0);
  const Pose turned{{0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector::UnitZ()))};
  EXPECT_NEAR(distance(x, {Kind::kSphere, {0, 3, 0}, {}, 1}, turned), 1, kExact);
  EXPECT_NEAR(distance(x, {Kind::kCylinder, {0, 3, -1}, {0, 3, 1}, 1}, turned), 1, kIterated);
}

TEST(Clearance, RemembersTheSmallestAndItsTime) {
  ClearanceMonitor monitor({{0, 1}}, {{{Kind::kSphere, {}, {}, 1}}, {{Kind::kSphere, {}, {}, 1}}});
  for (const double x : {5.0, 3.0, 4.0}) monitor.update(10 - x, {{}, {{x, 0, 0}, Eigen::Quaterniond::Identity()}});
  EXPECT_NEAR(monitor.get()[0].smallest, 1, kExact);
  EXPECT_EQ(monitor.get()[0].time, 7);
  EXPECT_NEAR(monitor.get()[0].now, 2, kExact);
}

TEST(Clearance, NeedsShapes) { EXPECT_THROW(ClearanceMonitor({{0, 1}}, {{}, {}}), std::invalid_argument); }

}  // namespace
}  // namespace unlatch::test
