// Facts about the statistics of campaigns: against closed forms and published numbers.
// tests/tools/studies/campaign_statistics_test.py compares with OpenTURNS.
#include "hil/study/statistics/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "hil/study/sampling/sampling.h"

namespace unlatch::test::statistics_test {
namespace {

TEST(Statistics, QuantilesAreNumPys) {
  const std::vector<double> sorted{1, 2, 4, 8};
  EXPECT_EQ(hil::calc_quantile(sorted, 0), 1);
  EXPECT_EQ(hil::calc_quantile(sorted, 0.5), 3);
  EXPECT_NEAR(hil::calc_quantile(sorted, 0.9), 6.8, 1e-15);
  EXPECT_EQ(hil::calc_quantile(sorted, 1), 8);
  EXPECT_TRUE(std::isnan(hil::calc_quantile({}, 0.5)));
}

TEST(Statistics, ClopperPearsonSolvesTheBinomialTails) {
  constexpr double kSolved = 1e-12;
  for (const auto& pair : {std::pair{0, 10}, {3, 1000}, {5, 10}, {10, 10}, {1, 100000}}) {
    const int hits = pair.first, trials = pair.second;
    const hil::Interval bounds = hil::calc_clopper_pearson(hits, trials);
    const auto tail = [&](double p, int k) {  // P(X ≤ k), summed
      double term = std::pow(1 - p, trials), sum = 0;
      for (int i = 0; i <= k; ++i) {
        sum += term;
        term *= p / (1 - p) * (trials - i) / (i + 1);
      }
      return sum;
    };
    if (hits > 0) {
      EXPECT_NEAR(1 - tail(bounds.low, hits - 1), 0.025, kSolved * 1e3);
    }
    if (hits < trials) {
      EXPECT_NEAR(tail(bounds.high, hits), 0.025, kSolved * 1e3);
    }
  }
  EXPECT_EQ(hil::calc_clopper_pearson(0, 100).low, 0);
  EXPECT_NEAR(hil::calc_clopper_pearson(0, 100).high, 1 - std::pow(0.025, 0.01), kSolved);
}

// Closed forms: 1 − cⁿ ≥ 0.95; of the second order 1 − cⁿ − n (1 − c) cⁿ⁻¹ ≥ 0.95.
TEST(Statistics, WilksNeeds59SamplesFor95Of95) {
  EXPECT_EQ(hil::calc_wilks_trials(0.95), 59);
  EXPECT_EQ(hil::calc_wilks_trials(0.99), 299);
  EXPECT_EQ(hil::calc_wilks_rank(58, 0.95), 0);
  EXPECT_EQ(hil::calc_wilks_rank(59, 0.95), 1);
  EXPECT_EQ(hil::calc_wilks_rank(93, 0.95), 2);  // Wilks' second order
}

TEST(Statistics, QuantileIntervalsCoverAsOftenAsTheySay) {
  const std::int64_t n = 59;
  int covered = 0;
  constexpr int kTrials = 2000;
  for (int k = 0; k < kTrials; ++k) {
    const hil::SamplingPlan plan{hil::Sampling::kRandom, static_cast<std::uint64_t>(k), n, 1, {}};
    std::vector<double> values;
    for (std::int64_t i = 0; i < n; ++i) values.push_back(hil::calc_point(plan, i)[0]);
    std::sort(values.begin(), values.end());
    const auto interval = hil::calc_quantile_interval(values, 0.5);
    ASSERT_TRUE(interval);
    covered += interval->low <= 0.5 && 0.5 <= interval->high ? 1 : 0;
  }
  EXPECT_GT(covered, 0.94 * kTrials);  // the numbers are always the same: the test is not random
  EXPECT_LT(covered, 0.99 * kTrials);
  EXPECT_FALSE(hil::calc_quantile_interval(std::vector<double>(58, 1.0), 0.01));
}

TEST(Statistics, SpearmanSeesOrderAlone) {
  std::vector<double> x, y, z;
  for (int i = 0; i < 20; ++i) {
    x.push_back(i);
    y.push_back(std::exp(0.3 * i));
    z.push_back(i == 3 ? std::nan("") : -i);
  }
  EXPECT_NEAR(hil::calc_spearman(x, y), 1, 1e-15);
  EXPECT_NEAR(hil::calc_spearman(x, z), -1, 1e-15);
  EXPECT_TRUE(std::isnan(hil::calc_spearman(x, std::vector<double>(20, 2.0))));
  // Several at once, with gaps on either side: the same.
  const std::vector<std::vector<double>> several{x, y, z};
  hil::RankedVariables ranked;
  for (const std::vector<double>& variable : several) ranked.add(variable);
  for (const std::vector<double>& other : several)
    for (std::size_t k = 0; k < several.size(); ++k)
      EXPECT_EQ(ranked.calc_spearman(other)[k], hil::calc_spearman(several[k], other));
}

// An even dependence, of which a rank correlation sees nothing; an input without influence; interaction.
TEST(Statistics, FirstOrderIndicesSeeAnyDependence) {
  const std::int64_t n = 2000;
  int covered = 0, significant = 0;
  constexpr int kTrials = 200;
  double sum = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const hil::SamplingPlan plan{hil::Sampling::kRandom, static_cast<std::uint64_t>(trial), n, 4, {}};
    std::vector<std::vector<double>> x(4);
    std::vector<double> y;
    for (std::int64_t i = 0; i < n; ++i) {
      const std::vector<double> u = hil::calc_point(plan, i);
      for (std::size_t k = 0; k < 4; ++k) x[k].push_back(2 * u[k] - 1);
      // variances: x² 4/45, 0.3 x 0.03, product of two 1/9 · 0.25
      y.push_back(x[0].back() * x[0].back() + 0.3 * x[1].back() + 0.5 * x[2].back() * x[3].back() + 1e6);
    }
    hil::RankedVariables ranked;
    for (const std::vector<double>& variable : x) ranked.add(variable);
    const hil::FirstOrders orders = ranked.calc_first_orders(y);
    const double exact = (4.0 / 45) / (4.0 / 45 + 0.03 + 0.25 / 9);
    EXPECT_NEAR(orders.of_inputs[0].index, exact, 0.08);
    sum += orders.of_inputs[0].index / kTrials;
    covered += orders.of_inputs[0].interval.low <= exact && exact <= orders.of_inputs[0].interval.high ? 1 : 0;
    significant += orders.of_inputs[2].index > orders.significant ? 1 : 0;  // no first order: interaction alone
    EXPECT_LT(std::abs(ranked.calc_spearman(y)[0]), 0.1);
    if (trial > 0) continue;
    EXPECT_EQ(orders.bins, 14u);
    EXPECT_GT(orders.of_inputs[1].index, orders.significant);
  }
  EXPECT_NEAR(sum, (4.0 / 45) / (4.0 / 45 + 0.03 + 0.25 / 9), 0.002);  // lines in 14 bins leave 1/14⁴ of a parabola
  EXPECT_GT(covered, 0.9 * kTrials);  // the numbers are always the same: the test is not random
  EXPECT_LT(significant, 0.12 * kTrials);
}

// The size of what disperses to both sides decides alone, as a tip-off does that unequal springs cause: of 200 samples
// bins with their means alone left a sixth of the variance, and the interval was beside the truth.
TEST(Statistics, FirstOrderIndicesOfOneCauseAreNearlyOneAndSoAreTheirIntervals) {
  constexpr int kTrials = 100;
  int covered = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const hil::SamplingPlan plan{hil::Sampling::kRandom, static_cast<std::uint64_t>(trial), 200, 2, {}};
    std::vector<std::vector<double>> x(2);
    std::vector<double> size, line;
    for (std::int64_t i = 0; i < 200; ++i) {
      const std::vector<double> u = hil::calc_point(plan, i);
      x[0].push_back(std::log(u[0] / (1 - u[0])));  // logistic: with tails
      x[1].push_back(2 * u[1] - 1);
      size.push_back(std::abs(x[0].back()) * (1 + 0.02 * x[1].back()));
      line.push_back(3 * x[0].back() + x[1].back());
    }
    hil::RankedVariables ranked;
    for (const std::vector<double>& variable : x) ranked.add(variable);
    const hil::FirstOrder of_size = ranked.calc_first_orders(size).of_inputs[0];
    // mean and square of |x| are 2 log 2 and π²/3; the other input has 0.02²/3 of the square
    const double square = std::numbers::pi * std::numbers::pi / 3, mean = 2 * std::log(2.0);
    const double exact_size = (square - mean * mean) / (square * (1 + 0.0004 / 3) - mean * mean);
    EXPECT_NEAR(of_size.index, exact_size, 0.01);  // the bin with the kink leaves 5e-4 of a mean
    EXPECT_NEAR(of_size.interval.high, exact_size, 0.01);
    const hil::FirstOrder of_line = ranked.calc_first_orders(line).of_inputs[0];
    const double exact_line = 9 * square / (9 * square + 1.0 / 3);
    EXPECT_NEAR(of_line.index, exact_line, 0.02);
    covered += of_line.interval.low <= exact_line && exact_line <= of_line.interval.high ? 1 : 0;
  }
  EXPECT_GT(covered, 0.85 * kTrials);
}

TEST(Statistics, FirstOrderIndicesOfConstantsAndOfFewValuesAreNoNumbers) {
  hil::RankedVariables ranked;
  std::vector<double> x, few;
  for (int i = 0; i < 100; ++i) x.push_back(i), few.push_back(i < 30 ? i : std::nan(""));
  ranked.add(x);
  EXPECT_TRUE(std::isnan(ranked.calc_first_orders(std::vector<double>(100, 3.0)).of_inputs[0].index));
  EXPECT_TRUE(std::isnan(ranked.calc_first_orders(few).of_inputs[0].index));
  EXPECT_GT(ranked.calc_first_orders(x).of_inputs[0].index, 0.95);
  // A constant input has one bin.
  hil::RankedVariables constant;
  constant.add(std::vector<double>(100, 1.0));
  EXPECT_TRUE(std::isnan(constant.calc_first_orders(x).of_inputs[0].index));
}

// Functions of three inputs in (0, 1) whose indices are known in closed form.
struct KnownFunction {
  const char* name;
  double (*value)(const std::vector<double>& u);
  std::array<double, 3> first, total;
};

constexpr double kIshigamiA = 7, kIshigamiB = 0.1;

double calc_ishigami(const std::vector<double>& u) {
  const auto x = [&](std::size_t k) { return std::numbers::pi * (2 * u[k] - 1); };
  return std::sin(x(0)) + kIshigamiA * std::sin(x(1)) * std::sin(x(1)) +
         kIshigamiB * std::pow(x(2), 4) * std::sin(x(0));
}

// Ishigami and Homma 1990; a sum of uniform inputs; the product of Sobol' 1993 with a = 0, 1, 9.
std::vector<KnownFunction> list_known_functions() {
  constexpr double kPi = std::numbers::pi;
  const double v1 = 0.5 * std::pow(1 + kIshigamiB * std::pow(kPi, 4) / 5, 2), v2 = kIshigamiA * kIshigamiA / 8,
               v13 = kIshigamiB * kIshigamiB * std::pow(kPi, 8) * (1.0 / 18 - 1.0 / 50), v = v1 + v2 + v13;
  const double p0 = 1.0 / 3, p1 = 1.0 / 12, p2 = 1.0 / 300, p = (1 + p0) * (1 + p1) * (1 + p2) - 1;
  return {{"Ishigami", calc_ishigami, {v1 / v, v2 / v, 0}, {(v1 + v13) / v, v2 / v, v13 / v}},
          {"sum",
           [](const std::vector<double>& u) { return 1e3 + 3 * u[0] + 2 * u[1] + u[2]; },
           {9.0 / 14, 4.0 / 14, 1.0 / 14},
           {9.0 / 14, 4.0 / 14, 1.0 / 14}},
          {"product",
           [](const std::vector<double>& u) {
             const auto factor = [&](std::size_t k, double a) { return (std::abs(4 * u[k] - 2) + a) / (1 + a); };
             return factor(0, 0) * factor(1, 1) * factor(2, 9);
           },
           {p0 / p, p1 / p, p2 / p},
           {p0 * (1 + p1) * (1 + p2) / p, p1 * (1 + p0) * (1 + p2) / p, p2 * (1 + p0) * (1 + p1) / p}}};
}

int covers(const hil::Interval& interval, double exact) {
  return interval.low <= exact && exact <= interval.high ? 1 : 0;
}

constexpr int kCampaigns = 300;
constexpr double kLeastCovered = 0.93;  // nominally 0.95

// Seeds 1 to 300: the numbers are always the same.
TEST(Statistics, IntervalsOfSobolIndicesCoverAsOftenAsTheySay) {
  constexpr std::int64_t kRows = 128;
  for (const KnownFunction& function : list_known_functions()) {
    std::array<int, 3> first{}, total{};
    for (std::uint64_t seed = 1; seed <= kCampaigns; ++seed) {
      const hil::SamplingPlan plan{hil::Sampling::kSaltelli, seed, kRows * 5, 3, {}};
      std::vector<std::vector<double>> blocks(5);
      for (std::int64_t i = 0; i < plan.samples; ++i)
        blocks[static_cast<std::size_t>(i % 5)].push_back(function.value(hil::calc_point(plan, i)));
      const auto indices = hil::calc_sobol_indices(blocks[0], blocks[1], std::span(blocks).subspan(2), seed);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] += covers(indices[axis].first_interval.value(), function.first[axis]);
        total[axis] += covers(indices[axis].total_interval.value(), function.total[axis]);
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_GE(first[axis], kLeastCovered * kCampaigns) << function.name << ", input " << axis;
      EXPECT_GE(total[axis], kLeastCovered * kCampaigns) << function.name << ", input " << axis;
    }
  }
}

// An index of 0 had an interval below 0 in most campaigns with a Sobol' sequence.
TEST(Statistics, FirstOrderIntervalsOfASobolSequenceCoverAsOftenAsTheySayAndAnIndexOf0) {
  for (const std::int64_t samples : {128, 1024})
    for (const KnownFunction& function : list_known_functions()) {
      std::array<int, 3> covered{};
      for (std::uint64_t seed = 1; seed <= kCampaigns; ++seed) {
        const hil::SamplingPlan plan{hil::Sampling::kSobol, seed, samples, 3, {}};
        std::vector<std::vector<double>> x(3);
        std::vector<double> y;
        for (std::int64_t i = 0; i < samples; ++i) {
          const std::vector<double> u = hil::calc_point(plan, i);
          for (std::size_t k = 0; k < 3; ++k) x[k].push_back(u[k]);
          y.push_back(function.value(u));
        }
        hil::RankedVariables ranked;
        for (const std::vector<double>& variable : x) ranked.add(variable);
        const hil::FirstOrders orders = ranked.calc_first_orders(y, hil::Evenness::kEven);
        for (std::size_t axis = 0; axis < 3; ++axis)
          covered[axis] += covers(orders.of_inputs[axis].interval, function.first[axis]);
      }
      // Of 128 samples three bins are too few for the ups and downs of sin², which is stated in statistics.h.
      const bool too_few = samples == 128 && function.value == calc_ishigami;
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_GE(covered[axis], too_few && axis == 1 ? 0 : kLeastCovered * kCampaigns)
            << function.name << ", input " << axis << ", samples " << samples;
    }
}

TEST(Statistics, SobolIndicesOfFewRowsAndOfConstantsHaveNoInterval) {
  const std::vector<double> few(hil::kLeastSobolRows - 1, 1.0), same(hil::kLeastSobolRows, 1.0);
  std::vector<double> line;
  for (std::size_t i = 0; i < few.size(); ++i) line.push_back(static_cast<double>(i));
  const std::vector<std::vector<double>> ab_few{few}, ab_same{same};
  EXPECT_TRUE(std::isfinite(hil::calc_sobol_indices(few, line, ab_few, 1)[0].first));
  EXPECT_FALSE(hil::calc_sobol_indices(few, line, ab_few, 1)[0].first_interval);
  EXPECT_FALSE(hil::calc_sobol_indices(same, same, ab_same, 1)[0].first_interval);
  EXPECT_TRUE(std::isnan(hil::calc_sobol_indices(same, same, ab_same, 1)[0].first));
}

// Ishigami's function, whose indices are known in closed form (Ishigami and Homma 1990).
TEST(Statistics, SobolIndicesOfIshigamisFunctionAreInTheirIntervals) {
  const KnownFunction function = list_known_functions()[0];
  const auto& [name, f, first, total] = function;
  const hil::SamplingPlan plan{hil::Sampling::kSaltelli, 1, 2000 * 5, 3, {}};
  std::vector<std::vector<double>> blocks(5);
  for (std::int64_t i = 0; i < plan.samples; ++i)
    blocks[static_cast<std::size_t>(i % 5)].push_back(f(hil::calc_point(plan, i)));
  const std::vector<hil::SobolIndex> indices =
      hil::calc_sobol_indices(blocks[0], blocks[1], std::span(blocks).subspan(2), 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const hil::SobolIndex& index = indices[axis];
    ASSERT_TRUE(index.first_interval && index.total_interval);
    EXPECT_LE(index.first_interval->low, first[axis]) << axis;
    EXPECT_GE(index.first_interval->high, first[axis]) << axis;
    EXPECT_LE(index.total_interval->low, total[axis]) << axis;
    EXPECT_GE(index.total_interval->high, total[axis]) << axis;
    EXPECT_LT(index.first_interval->high - index.first_interval->low, 0.2);
  }
}

}  // namespace
}  // namespace unlatch::test::statistics_test
