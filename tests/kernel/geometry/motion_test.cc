// Distances under exchange of the bodies, rigid motion, and smooth motion; no allocation; bounds by speeds.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "kernel/geometry/groups.h"
#include "tests/kernel/geometry/solids.h"
#include "tests/support/malloc_guard.h"
#include "unlatch/geometry/group_pair.h"
#include "unlatch/geometry/reach.h"

namespace unlatch::test::motion_test {
namespace {

using geometry::CompiledShape;
using geometry::Distance;
using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;

constexpr int kKinds = 9;

bool is_same(double a, double b) {
  return a == b || std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
bool is_same(const Vec3& a, const Vec3& b) { return is_same(a.x, b.x) && is_same(a.y, b.y) && is_same(a.z, b.z); }

TEST(GeometryMotion, ExchangeMirrorsTheResultToTheLastBit) {
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    const int kind_a = random.below(kKinds), kind_b = random.below(7);
    const CompiledShape a = compile_shape(draw_any(random, kind_a)), b = compile_shape(draw_any(random, kind_b));
    const Placement at_a = draw_placement(random, 1.5), at_b = draw_placement(random, 1.5);
    if (kind_a == 8 && i % 8) continue;  // walls take longer
    const Distance d = calc_distance(a, at_a, b, at_b), e = calc_distance(b, at_b, a, at_a);
    ASSERT_TRUE(is_same(d.distance, e.distance) && is_same(d.normal, -e.normal) && is_same(d.on_a, e.on_b) &&
                is_same(d.on_b, e.on_a))
        << kind_a << " " << kind_b;
  }
}

TEST(GeometryMotion, ARigidMotionOfBothChangesNothingButRounding) {
  Random random(6);
  for (int i = 0; i < 20000; ++i) {
    const int kind_a = random.below(kKinds), kind_b = random.below(7);
    const CompiledShape a = compile_shape(draw_any(random, kind_a)), b = compile_shape(draw_any(random, kind_b));
    const Placement at_a = draw_placement(random, 1.5), at_b = draw_placement(random, 1.5);
    const Placement by = draw_placement(random, 3);
    if (kind_a == 8 && i % 8) continue;
    const auto move = [&](const Placement& at) { return Placement{by.p_WB + by.R_WB * at.p_WB, by.R_WB * at.R_WB}; };
    const Distance d = calc_distance(a, at_a, b, at_b), e = calc_distance(a, move(at_a), b, move(at_b));
    ASSERT_NEAR(d.distance, e.distance, 1e-9) << kind_a << " " << kind_b << " at " << i;
  }
}

// Along a smooth motion the distance is continuous: no change is greater than the speed of approach. At a change of
// features its slope may change; a jump would show as a change that does not shrink with the interval.
TEST(GeometryMotion, HasNoStepsAlongASmoothMotion) {
  Random random(7);
  for (int i = 0; i < 189; ++i) {
    const int kind_a = i % kKinds, kind_b = (i / kKinds) % 7;
    const CompiledShape a = compile_shape(draw_any(random, kind_a)), b = compile_shape(draw_any(random, kind_b));
    const Placement at_a = draw_placement(random, 0.5), start = draw_placement(random, 0.5);
    const Vec3 v = draw_direction(random), w = draw_direction(random);
    const auto at = [&](double t) {
      const Quat q = normalized(Quat{1, 0.5 * t * w.x, 0.5 * t * w.y, 0.5 * t * w.z});
      return Placement{start.p_WB + t * v, rotation_matrix(q) * start.R_WB};
    };
    const double fastest = 1 + 1.0 * (norm(b.p_BS) + b.bound);  // m/s
    const int steps = kind_a == 8 ? 60 : 600;
    const double all = 3, dt = all / steps;
    double last = 0;
    for (int k = 0; k <= steps; ++k) {
      const double d = calc_distance(a, at_a, b, at(k * dt)).distance;
      if (k > 0) {
        ASSERT_LE(std::fabs(d - last), fastest * dt * 1.0000001 + 1e-9) << kind_a << " " << kind_b << " tick " << k;
      }
      last = d;
    }
  }
}

// Second differences of a distance along a smooth motion, in an interval without a change of features: those of a
// smooth function, h² d²; noise of the distance would be larger.
TEST(GeometryMotion, SecondDifferencesAreThoseOfASmoothFunction) {
  const Shape first{.kind = ShapeKind::kCylinder, .from = {0, 0, -1}, .to = {0, 0, 1}, .radius = 0.5};
  const Shape second{.kind = ShapeKind::kCone, .from = {0, 0, 0}, .to = {0, 0, 1.5}, .radius = 0.4};
  const CompiledShape a = compile_shape(first), b = compile_shape(second);
  const auto measure = [&](double t, double depth) {
    const Quat q = normalized(Quat{1, 0.7 + 0.1 * t, 0.3, 0.2 * t});
    return calc_distance(a, {}, b, {{0.9 + 0.05 * t - depth, 0.1 * t, 0.3 + 0.1 * t}, rotation_matrix(q)}).distance;
  };
  for (const double depth : {0.0, 0.55}) {  // apart, and overlapping
    constexpr double kStep = 1e-4;
    double worst = 0, least = 1e9;
    for (int k = 0; k < 2000; ++k) {
      const double t = k * kStep;
      const double d = measure(t, depth);
      least = std::min(least, d);
      worst = std::max(worst, std::fabs(measure(t - kStep, depth) - 2 * d + measure(t + kStep, depth)));
    }
    EXPECT_TRUE(depth > 0 ? least < 0 : least > 0) << least;
    EXPECT_LE(worst, 5 * kStep * kStep);  // |d²/dt²| of this motion is below 5 m/s²
  }
}

// The same for random pairs of every two kinds. A change of features gives a slope another value: its second difference
// is the change of slope times the step, and few are such. A jump, or noise above rounding, would be in most.
TEST(GeometryMotion, SecondDifferencesOfEveryPairOfKindsAreThoseOfPiecewiseSmoothFunctions) {
  constexpr std::uint64_t kSeed = 13;
  constexpr double kStep = 1e-4;  // s
  constexpr int kMotions = 40, kInstants = 25;
  Random random(kSeed);
  for (int kind_a = 0; kind_a < kKinds; ++kind_a) {
    for (int kind_b = 0; kind_b < 7; ++kind_b) {
      int smooth = 0, all = 0;
      for (int motion = 0; motion < kMotions; ++motion) {
        const CompiledShape a = compile_shape(draw_any(random, kind_a)), b = compile_shape(draw_any(random, kind_b));
        const Placement at_a = draw_placement(random, 1), start = draw_placement(random, 1);
        const Vec3 v = draw_direction(random), w = draw_direction(random);
        const auto measure = [&](double t) {
          const Quat q = normalized(Quat{1, 0.5 * t * w.x, 0.5 * t * w.y, 0.5 * t * w.z});
          return calc_distance(a, at_a, b, {start.p_WB + t * v, rotation_matrix(q) * start.R_WB}).distance;
        };
        const double fastest = 1 + (norm(b.p_BS) + b.bound);  // m/s
        for (int k = 0; k < kInstants; ++k) {
          const double t = 0.05 * k, d = measure(t);
          if (std::fabs(d) < 0.05) continue;
          const double second = std::fabs(measure(t - kStep) - 2 * d + measure(t + kStep));
          // A point that passes an edge at a distance d: v²/d, and the rotation's.
          const double bound = fastest * fastest * (1 / std::fabs(d) + 4);
          ASSERT_LE(second, 2.1 * fastest * kStep) << "seed " << kSeed << ": " << kind_a << " " << kind_b;
          ++all, smooth += second <= bound * kStep * kStep + 1e-12;
        }
      }
      EXPECT_GT(all, 100);
      EXPECT_GE(smooth, 0.97 * all) << "seed " << kSeed << ": " << kind_a << " " << kind_b << " of " << all;
    }
  }
}

// Walls and half-spaces: the wall's lowest point is on a rim, a circle or half of one.
TEST(GeometryMotion, WallsAreAsFarFromHalfSpacesAsTheLowestPointOfTheirRims) {
  constexpr std::uint64_t kSeed = 14;
  Random random(kSeed);
  for (int i = 0; i < 100000; ++i) {
    const Shape wall = draw_any(random, 8), ground = draw_any(random, 7);
    const Placement at_wall = draw_placement(random, 2), at_ground = draw_placement(random, 2);
    const Vec3 n = at_ground.R_WB * ground.normal;
    const Vec3 axis = (1 / norm(wall.to - wall.from)) * (wall.to - wall.from);
    const Vec3 z = at_wall.R_WB * axis;
    double wanted = 1e9;
    for (const geometry::ProfilePoint& p : wall.profile) {
      const Vec3 centre = at_wall.p_WB + at_wall.R_WB * (wall.from + p.z * axis);
      const double height = dot(n, centre - (at_ground.p_WB + at_ground.R_WB * ground.from));
      const Vec3 across = n - dot(n, z) * z;
      double reach = norm(across);
      if (wall.half) {
        const Vec3 x = at_wall.R_WB * ((1 / norm(wall.side)) * wall.side), y = cross(z, x);
        // Down along −across where the half has such points, else at one of its edges.
        if (dot(across, x) > 0) reach = std::fabs(dot(across, y));
      }
      wanted = std::min(wanted, height - p.r * reach);
    }
    ASSERT_NEAR(calc_distance(compile_shape(wall), at_wall, compile_shape(ground), at_ground).distance, wanted, 1e-12)
        << "seed " << kSeed << ": pair " << i;
  }
}

TEST(GeometryMotion, AllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  Random random(8);
  std::vector<CompiledShape> shapes;
  for (int kind = 0; kind < kKinds; ++kind) shapes.push_back(compile_shape(draw_any(random, kind)));
  double sum = 0;
  const AllocationCount count;
  for (const CompiledShape& a : shapes)
    for (const CompiledShape& b : shapes)
      for (const double x : {0.0, 0.2, 3.0}) sum += std::fmin(1, calc_distance(a, {}, b, {{x, 0.1, 0.2}}).distance);
  EXPECT_EQ(count.get(), 0);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(GeometryMotion, BoundsAreBelowTheDistance) {
  Random random(9);
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Shape> parts_a{draw_any(random, random.below(7)), draw_any(random, random.below(7))};
    const std::vector<Shape> parts_b{draw_any(random, random.below(7))};
    const geometry::ShapeGroup a = build_group("a", parts_a), b = build_group("b", parts_b);
    const Placement at_a = draw_placement(random, 3), at_b = draw_placement(random, 3);
    const geometry::GroupDistance d = calc_distance(a, at_a, b, at_b);
    const double apart = std::min(calc_distance((*a.parts)[0], at_a, (*b.parts)[0], at_b).distance,
                                  calc_distance((*a.parts)[1], at_a, (*b.parts)[0], at_b).distance);
    EXPECT_EQ(d.least.distance, apart);
    EXPECT_LE(calc_lower_bound(a, at_a, b, at_b), apart);
    // After 0.1 s at known speeds, the distance is above the advanced bound.
    const geometry::Motion of_b{.v_WB = draw_direction(random), .turn = 1};
    const double dt = 0.1;
    const Vec3 w = draw_direction(random);
    const double half = std::tan(0.5 * dt * of_b.turn);
    const Mat3 turn = rotation_matrix(normalized(Quat{1, half * w.x, half * w.y, half * w.z}));
    const Placement then{at_b.p_WB + dt * of_b.v_WB, turn * at_b.R_WB};
    EXPECT_LE(calc_advanced_bound(apart, a, {}, b, of_b, dt), calc_distance(a, at_a, b, then).least.distance + 1e-9);
  }
}

TEST(GeometryMotion, BoundsByBoxesAreBelowTheDistanceAndOftenNearIt) {
  constexpr std::uint64_t kSeed = 10;
  Random random(kSeed);
  int apart = 0, near = 0;
  for (int i = 0; i < 20000; ++i) {
    const int kind_a = random.below(kKinds), kind_b = random.below(7);
    const CompiledShape a = compile_shape(draw_any(random, kind_a)), b = compile_shape(draw_any(random, kind_b));
    if (kind_a == 8 && i % 8) continue;  // walls take longer
    const Placement at_a = draw_placement(random, 2), at_b = draw_placement(random, 2);
    const double d = calc_distance(a, at_a, b, at_b).distance, bound = calc_lower_bound(a, at_a, b, at_b);
    ASSERT_LE(bound, d) << "seed " << kSeed << ": " << kind_a << " " << kind_b << " at " << i;
    ASSERT_LE(calc_lower_bound(b, at_b, a, at_a), d) << "seed " << kSeed << ": " << kind_a << " " << kind_b;
    apart += d > 0.5, near += d > 0.5 && bound > 0.5 * d;
  }
  EXPECT_GT(near, apart / 2) << "of " << apart;
  // A ball beside the long side of a box: there the bound equals the distance.
  const CompiledShape ball = compile_shape(Shape{.kind = ShapeKind::kSphere, .radius = 0.1});
  const CompiledShape strip = compile_shape(Shape{.kind = ShapeKind::kBox, .size = {4, 0.2, 0.2}});
  EXPECT_NEAR(calc_lower_bound(ball, {{1.5, 0.3, 0}, kIdentity3}, strip, {}), 0.1, 1e-11);
}

TEST(GeometryMotion, TheExtentOfAGroupHoldsAllOfIt) {
  constexpr std::uint64_t kSeed = 12;
  constexpr double kRounding = 1e-12;  // m, at sizes of some metres
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const int kind_a = random.below(7), kind_b = random.below(7);
    const geometry::ShapeGroup group =
        build_group("", std::vector<Shape>{draw_any(random, kind_a), draw_any(random, kind_b)});
    const Placement at = draw_placement(random, 2);
    const geometry::Extent extent = calc_extent(group, at);
    const double ends[6] = {extent.most.x,  extent.most.y,  extent.most.z,
                            extent.least.x, extent.least.y, extent.least.z};
    for (int k = 0; k < 6; ++k) {
      Vec3 out{0, 0, 0};
      (k % 3 == 0 ? out.x : k % 3 == 1 ? out.y : out.z) = k < 3 ? 1 : -1;
      const double end = ends[k] * (k < 3 ? 1 : -1);  // along `out`
      const Shape beyond{.kind = ShapeKind::kHalfSpace, .from = end * out, .normal = -out};
      const double apart = calc_distance(group, at, build_group("", std::vector<Shape>{beyond}), {}).least.distance;
      ASSERT_GE(apart, -kRounding) << "seed " << kSeed << ": " << kind_a << " " << kind_b << " at " << i;
    }
  }
  // Of a box along the axes it is the box; of what has no end it has none.
  const std::vector<Shape> strip{{.kind = ShapeKind::kBox, .from = {1, 0, 0}, .size = {4, 0.2, 0.4}}};
  EXPECT_EQ(calc_extent(build_group("", strip), {}).most.x, 3);
  EXPECT_EQ(calc_extent(build_group("", strip), {}).least.z, -0.2);
  const std::vector<Shape> space{{.kind = ShapeKind::kHalfSpace, .normal = {0, 0, 1}}};
  EXPECT_TRUE(std::isinf(calc_extent(build_group("", space), {}).most.x));
}

TEST(GeometryMotion, TheSlabAcrossAnyDirectionIsBelowTheDistanceAndAcrossTheNormalEqualsIt) {
  constexpr std::uint64_t kSeed = 13;
  constexpr double kCertified = 1e-9;  // m, at sizes of some metres
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const int kind_a = random.below(7), kind_b = random.below(7);
    const geometry::ShapeGroup a = build_group("", std::vector<Shape>{draw_any(random, kind_a)}),
                               b = build_group("", std::vector<Shape>{draw_any(random, kind_b)});
    const Placement at_a = draw_placement(random, 1), at_b = draw_placement(random, 1);
    const Distance d = calc_distance(a, at_a, b, at_b).least;
    const auto calc_slab = [&](const Vec3& n) { return -calc_reach(b, at_b, -n) - calc_reach(a, at_a, n); };
    // Of overlaps the depth is a search, but where it is no deeper than the radius of something round.
    const bool exact = d.distance > -std::min(get_exact_depth(a), get_exact_depth(b));
    if (exact) {
      ASSERT_LE(calc_slab(draw_direction(random)), d.distance + kCertified) << i << ": " << kind_a << " " << kind_b;
    }
    ASSERT_NEAR(calc_slab(d.normal), d.distance, kCertified) << i << ": " << kind_a << " " << kind_b;
  }
}

TEST(GeometryMotion, SlabsBetweenBoxesAreBelowTheDistanceOverlapsIncluded) {
  constexpr std::uint64_t kSeed = 11;
  Random random(kSeed);
  int overlaps = 0, near = 0, apart = 0;
  for (int i = 0; i < 20000; ++i) {
    const int kind_a = random.below(kKinds), kind_b = random.below(7);
    const CompiledShape a = compile_shape(draw_any(random, kind_a)), b = compile_shape(draw_any(random, kind_b));
    if (kind_a == 8 && i % 8) continue;  // walls take longer
    const Placement at_a = draw_placement(random, i % 2 ? 2 : 0.5), at_b = draw_placement(random, i % 2 ? 2 : 0.5);
    const geometry::Box box_a = build_box(a, at_a, at_a.p_WB), box_b = build_box(b, at_b, at_a.p_WB);
    const double d = calc_distance(a, at_a, b, at_b).distance, bound = calc_slab_bound(box_a, box_b);
    ASSERT_LE(bound, d) << "seed " << kSeed << ": " << kind_a << " " << kind_b << " at " << i;
    ASSERT_LE(calc_slab_bound(box_b, box_a), d) << "seed " << kSeed << ": " << kind_a << " " << kind_b << " at " << i;
    overlaps += d<0, apart += d> 0.5, near += d > 0.5 && bound > 0.7 * d;
  }
  EXPECT_GT(overlaps, 1000);
  EXPECT_GT(near, apart / 2) << "of " << apart;
}

// Bodies of many shapes that creep and turn: all pairs, computed one by one, are the reference.
TEST(GeometryMotion, GroupsInMotionHaveTheBitsOfAllTheirPairs) {
  constexpr std::uint64_t kSeed = 12;
  Random random(kSeed);
  int overlaps = 0;
  for (int round = 0; round < 40; ++round) {
    std::vector<Shape> parts_a, parts_b;
    const int count_a = 1 + random.below(round % 8 == 0 ? 26 : 7), count_b = 1 + random.below(5);
    for (int i = 0; i < count_a; ++i) parts_a.push_back(draw_any(random, random.below(8)));
    for (int i = 0; i < count_b; ++i) parts_b.push_back(draw_any(random, random.below(7)));
    if (round % 5 == 0) parts_b.push_back(parts_b.front());  // equal distances: the first pair is the result
    geometry::GroupPair pair(build_group("a", parts_a), build_group("b", parts_b));
    const Placement at_a = draw_placement(random, 1);
    Placement at_b = draw_placement(random, 3);
    const Vec3 v = 0.02 * draw_direction(random), w = draw_direction(random);
    for (int step = 0; step < 60; ++step) {
      const double half = 0.5 * (step % 20 == 19 ? 1.0 : 0.01);  // now and then far at once
      at_b.p_WB += (step % 20 == 19 ? 40.0 : 1.0) * v;
      at_b.R_WB = rotation_matrix(normalized(Quat{1, half * w.x, half * w.y, half * w.z})) * at_b.R_WB;
      geometry::GroupDistance all;
      for (std::size_t i = 0; i < parts_a.size(); ++i)
        for (std::size_t k = 0; k < parts_b.size(); ++k) {
          const Distance d = calc_distance(get_parts(pair.get_a())[i], at_a, get_parts(pair.get_b())[k], at_b);
          if (d.distance < all.least.distance) all = {d, static_cast<int>(i), static_cast<int>(k)};
        }
      const geometry::GroupDistance least = calc_distance(pair.get_a(), at_a, pair.get_b(), at_b);
      for (const geometry::GroupDistance& found : {least, pair.calc_distance(at_a, at_b)}) {
        ASSERT_EQ(found.least.distance, all.least.distance) << "seed " << kSeed << ", " << round << ", " << step;
        ASSERT_EQ(found.shape_a, all.shape_a) << "seed " << kSeed << ", " << round << ", " << step;
        ASSERT_EQ(found.shape_b, all.shape_b) << "seed " << kSeed << ", " << round << ", " << step;
        ASSERT_EQ(found.least.on_b.x, all.least.on_b.x);
      }
      overlaps += all.least.distance < 0;
    }
  }
  EXPECT_GT(overlaps, 100);
}

}  // namespace
}  // namespace unlatch::test::motion_test
