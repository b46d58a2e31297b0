// Facts about random numbers, quantiles and points of the unit cube.
#include "hil/study/sampling/sampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "hil/scenario/base/normal.h"
#include "hil/scenario/base/philox.h"
#include "hil/study/sampling/distribution.h"

namespace unlatch::test::sampling_test {
namespace {

using hil::Distribution;
using hil::PhiloxCounter;
using hil::Sampling;
using hil::SamplingPlan;

// The known answers of Random123 (kat_vectors, philox4x32, 10 rounds).
TEST(Philox, GivesThePublishedNumbers) {
  EXPECT_EQ(hil::calc_philox({0, 0, 0, 0}, {0, 0}), (PhiloxCounter{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  constexpr std::uint32_t kAll = 0xffffffff;
  EXPECT_EQ(hil::calc_philox({kAll, kAll, kAll, kAll}, {kAll, kAll}),
            (PhiloxCounter{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(hil::calc_philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (PhiloxCounter{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Philox, UnitsNeverReachTheirEnds) {
  EXPECT_EQ(hil::to_unit(0), hil::kLeastUnit);
  EXPECT_EQ(hil::to_unit(~std::uint64_t{0}), 1 - hil::kLeastUnit);
  EXPECT_LT(hil::to_unit(~std::uint64_t{0}), 1);
}

// Error of the logarithm: two units of its last place where it is not near 0.
constexpr double kLogError = 5e-16;

TEST(Normal, LogarithmIsThatOfTheCLibrary) {
  for (double x = 1e-300; x < 1e300; x *= 1.7)
    EXPECT_NEAR(hil::calc_log(x), std::log(x), kLogError * std::abs(std::log(x))) << x;
  for (double x = 0.5; x < 2; x += 0.0137) EXPECT_NEAR(hil::calc_log(x), std::log(x), 2e-16) << x;
  EXPECT_EQ(hil::calc_log(1), 0);
}

TEST(Normal, QuantilesAreThoseOfTheTables) {
  constexpr double kDigits = 1e-14;  // relative
  // Abramowitz and Stegun 26.2, with the digits of multiple precision.
  const std::pair<double, double> known[] = {{0.975, 1.959963984540054},
                                             {0.999, 3.090232306167813},
                                             {0.5, 0},
                                             {1e-10, -6.361340902404056},
                                             {0.84134474606854293, 1.0}};
  for (const auto& [p, z] : known)
    EXPECT_NEAR(hil::calc_normal_quantile(p), z, kDigits * std::max(1.0, std::abs(z))) << p;
}

TEST(Normal, ProbabilityAndQuantileAreInverse) {
  for (double p = 1e-16; p < 1; p = p < 0.01 ? p * 3 : p + 0.0071) {
    const double back = hil::calc_normal_cdf(hil::calc_normal_quantile(p));
    EXPECT_NEAR(back, p, 1e-13 * p) << p;
    EXPECT_NEAR(hil::calc_normal_cdf(-hil::calc_normal_quantile(p)), 1 - p, 1e-15) << p;
  }
}

TEST(Distribution, CutNormalStaysWithinAndKeepsItsShape) {
  Distribution d{.kind = Distribution::Kind::kNormal, .a = 10, .b = 2};
  d.cut(7, 12);
  EXPECT_NEAR(d.calc_quantile(hil::kLeastUnit), 7, 1e-12);
  EXPECT_NEAR(d.calc_quantile(1 - hil::kLeastUnit), 12, 1e-12);
  const double middle = d.calc_quantile(0.5);
  EXPECT_NEAR(d.calc_cdf(middle), 0.5 * (d.calc_cdf(7) + d.calc_cdf(12)), 1e-14);
}

TEST(Distribution, DiscreteValuesComeByTheirWeights) {
  Distribution d{.kind = Distribution::Kind::kDiscrete, .values = {1, 2, 5}, .cumulative = {0.25, 0.25, 1}};
  EXPECT_EQ(d.calc_quantile(0.2), 1);
  EXPECT_EQ(d.calc_quantile(0.2501), 5);  // 2 has no weight
  EXPECT_EQ(d.calc_quantile(1 - hil::kLeastUnit), 5);
}

TEST(Distribution, ConeIsUniformOverItsCapAndUnitLong) {
  const double half = 0.3;
  const Distribution d{.kind = Distribution::Kind::kCone, .b = half};
  for (const double p : {0.1, 0.5, 0.9}) {
    const double angle = d.calc_quantile(p);
    EXPECT_NEAR((1 - std::cos(angle)) / (1 - std::cos(half)), p, 1e-13);
    for (const double turn : {0.0, 0.3, 0.8}) {
      const auto u = hil::tilt({0, -3, 4}, angle, turn);
      EXPECT_NEAR(u[0] * u[0] + u[1] * u[1] + u[2] * u[2], 1, 1e-15);
      EXPECT_NEAR((-3 * u[1] + 4 * u[2]) / 5, std::cos(angle), 1e-15);
    }
  }
}

std::vector<double> list_axis(const SamplingPlan& plan, std::size_t axis) {
  std::vector<double> values;
  for (std::int64_t i = 0; i < plan.samples; ++i) values.push_back(hil::calc_point(plan, i)[axis]);
  return values;
}

TEST(LatinHypercube, HasEachPartOfEachAxisOnce) {
  for (const std::int64_t samples : {1, 2, 7, 64, 1000}) {
    const SamplingPlan plan{Sampling::kLatinHypercube, 5, samples, 3, {}};
    std::vector<std::vector<std::int64_t>> orders;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::set<std::int64_t> parts;
      std::vector<std::int64_t>& order = orders.emplace_back();
      for (const double u : list_axis(plan, axis)) {
        order.push_back(static_cast<std::int64_t>(u * static_cast<double>(samples)));
        parts.insert(order.back());
      }
      EXPECT_EQ(static_cast<std::int64_t>(parts.size()), samples) << axis;
      EXPECT_EQ(*parts.rbegin(), samples - 1);
    }
    if (samples > 7) {
      EXPECT_NE(orders[0], orders[1]);
    }
  }
}

TEST(Sobol, FirstPowersOfTwoFillEachAxisEvenlyAndEachPairInBoxes) {
  const SamplingPlan plan{Sampling::kSobol, 3, 256, 12, {}};
  std::vector<std::vector<double>> axes;
  for (std::size_t axis = 0; axis < plan.dimensions; ++axis) {
    axes.push_back(list_axis(plan, axis));
    std::set<int> parts;
    for (const double u : axes.back()) parts.insert(static_cast<int>(u * 256));
    EXPECT_EQ(parts.size(), 256u) << axis;
  }
  std::set<int> boxes;  // the first two axes are a (0, 2)-sequence
  for (std::size_t i = 0; i < 256; ++i)
    boxes.insert(static_cast<int>(axes[0][i] * 16) * 16 + static_cast<int>(axes[1][i] * 16));
  EXPECT_EQ(boxes.size(), 256u);
}

TEST(Grid, HasAllCombinations) {
  const SamplingPlan plan{Sampling::kGrid, 1, 6, 2, {2, 3}};
  EXPECT_EQ(hil::count_samples(plan), 6);
  std::set<std::vector<double>> points;
  for (std::int64_t i = 0; i < 6; ++i) points.insert(hil::calc_point(plan, i));
  EXPECT_EQ(points.size(), 6u);
  EXPECT_EQ(hil::calc_point(plan, 0), (std::vector<double>{0.25, 0.5 / 3}));
}

TEST(OneAtATime, MovesOneAxisFromTheMedians) {
  const SamplingPlan plan{Sampling::kOneAtATime, 1, 7, 2, {2, 4}};
  EXPECT_EQ(hil::count_samples(plan), 7);
  EXPECT_EQ(hil::calc_point(plan, 0), (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(hil::calc_point(plan, 2), (std::vector<double>{0.75, 0.5}));
  EXPECT_EQ(hil::calc_point(plan, 3), (std::vector<double>{0.5, 0.125}));
}

TEST(Morris, EachTrajectoryMovesEachAxisOnce) {
  const SamplingPlan plan{Sampling::kMorris, 9, 50, 4, {}};
  for (std::int64_t trajectory = 0; trajectory < 10; ++trajectory) {
    std::set<std::size_t> moved;
    for (std::size_t k = 1; k <= 4; ++k) {
      const auto before = hil::calc_point(plan, trajectory * 5 + static_cast<std::int64_t>(k) - 1);
      const auto after = hil::calc_point(plan, trajectory * 5 + static_cast<std::int64_t>(k));
      const hil::MorrisStep step = hil::get_morris_step(plan, trajectory, k);
      for (std::size_t axis = 0; axis < 4; ++axis)
        EXPECT_NEAR(after[axis] - before[axis], axis == step.axis ? 0.98 * hil::kMorrisStep * step.sign : 0, 1e-15);
      moved.insert(step.axis);
    }
    EXPECT_EQ(moved.size(), 4u);
  }
}

TEST(Saltelli, BlocksExchangeOneAxis) {
  const SamplingPlan plan{Sampling::kSaltelli, 2, 10, 3, {}};
  const auto a = hil::calc_point(plan, 5), b = hil::calc_point(plan, 6);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto expected = a;
    expected[axis] = b[axis];
    EXPECT_EQ(hil::calc_point(plan, 7 + static_cast<std::int64_t>(axis)), expected);
    EXPECT_NE(a[axis], b[axis]);
  }
}

}  // namespace
}  // namespace unlatch::test::sampling_test
