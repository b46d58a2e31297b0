// Random pairs of every two kinds of convex shapes. Apart: the witness points lie in their shapes, and the slab between
// the support planes across the normal, by separate support functions of the tests, has the width of the distance,
// which proves the distance from both sides. Overlapping: the witness points lie in their shapes and on the support
// planes, and no direction of a dense search separates the two by less.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "tests/kernel/geometry/solids.h"

namespace unlatch::test::pairs_test {
namespace {

using geometry::Distance;
using geometry::Placement;
using geometry::Shape;

constexpr double kSize = 2;              // m, about that of a shape
constexpr double kError = 1e-9 * kSize;  // m, of a distance
constexpr double kOpposite = 1e-7;  // m: witness points of an overlap; their error affects the depth in second order
constexpr int kDirections = 250;    // directions of the search for a smaller depth
constexpr int kEvery = 8;           // interval of the overlaps that are searched

class GeometryPairs : public ::testing::TestWithParam<std::tuple<int, int>> {
 protected:
  void check(int count, std::uint64_t seed) {
    const auto [kind_a, kind_b] = GetParam();
    Random random(seed + 100 * static_cast<std::uint64_t>(kind_a) + static_cast<std::uint64_t>(kind_b));
    int overlaps = 0;
    for (int i = 0; i < count && !HasFailure(); ++i) {
      const Shape a = draw_shape(random, kConvexKinds[kind_a]), b = draw_shape(random, kConvexKinds[kind_b]);
      const Placement at_a = draw_placement(random, 1.6), at_b = draw_placement(random, 1.6);
      const Distance d = calc_distance(geometry::compile_shape(a), at_a, geometry::compile_shape(b), at_b);
      SCOPED_TRACE("pair " + std::to_string(i) + ", distance " + std::to_string(d.distance));
      EXPECT_NEAR(norm(d.normal), 1, 1e-14);
      EXPECT_LE(PointDistance(a, at_a)(d.on_a), kError);
      EXPECT_LE(PointDistance(b, at_b)(d.on_b), kError);
      const double slab = -calc_extent(a, at_a, d.normal) - calc_extent(b, at_b, -d.normal);
      EXPECT_NEAR(d.distance, slab, kError);
      EXPECT_LE(norm((d.on_b - d.on_a) - d.distance * d.normal), d.distance > 0 ? kError : kOpposite);
      if (d.distance < 0 && ++overlaps % kEvery == 0) {
        EXPECT_LE(-d.distance, search_depth(a, at_a, b, at_b, kDirections) + kError);
      }
    }
    EXPECT_GT(overlaps, count / 50);
  }
};

TEST_P(GeometryPairs, HaveTheDistanceThatSupportsProve) { check(10000, 1); }
TEST_P(GeometryPairs, HaveTheDistanceThatSupportsProveLong) { check(100000, 1000000); }

std::string name_pair(const ::testing::TestParamInfo<std::tuple<int, int>>& info) {
  return std::string(kConvexNames[std::get<0>(info.param)]) + kConvexNames[std::get<1>(info.param)];
}

std::vector<std::tuple<int, int>> list_pairs() {
  std::vector<std::tuple<int, int>> pairs;
  for (int a = 0; a < 7; ++a)
    for (int b = a; b < 7; ++b) pairs.emplace_back(a, b);
  return pairs;
}

INSTANTIATE_TEST_SUITE_P(Every, GeometryPairs, ::testing::ValuesIn(list_pairs()), name_pair);

}  // namespace
}  // namespace unlatch::test::pairs_test
