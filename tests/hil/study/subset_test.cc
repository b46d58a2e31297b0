// Facts about subset simulation: known probabilities, the same bits in any order, and the spread of its estimates.
// Oracle: closed forms, named at each margin below. tests/tools/studies/campaign_statistics_test.py compares with
// OpenTURNS.
#include "hil/study/sampling/subset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>

#include "hil/scenario/base/normal.h"

namespace unlatch::test::subset_test {
namespace {

using hil::SubsetEstimate;
using hil::SubsetPlan;
using hil::SubsetSimulation;

using Margin = std::function<double(const std::vector<double>&)>;  // function of standard normal numbers

Margin in_normal_space(const Margin& margin) {
  return [margin](const std::vector<double>& point) {
    std::vector<double> u;
    for (const double p : point) u.push_back(hil::calc_normal_quantile(p));
    return margin(u);
  };
}

// Runs all samples that may be run, until none is left; returns the number of samples.
std::int64_t run(SubsetSimulation& subset, const Margin& margin) {
  std::int64_t next = 0;
  for (; next < subset.get_end(); ++next) subset.note(next, margin(subset.calc_point(next)));
  return next;
}

// Plane at the distance beta from the origin: P = Φ(−beta) in any dimension.
Margin make_plane(double beta) {
  return in_normal_space([beta](const std::vector<double>& u) {
    double sum = 0;
    for (const double x : u) sum += x;
    return beta - sum / std::sqrt(static_cast<double>(u.size()));
  });
}

// Outside of a circle: P(u1² + u2² > r²) = exp(−r²/2); no direction is preferred.
Margin make_circle(double radius) {
  return in_normal_space([radius](const std::vector<double>& u) {
    double square = 0;
    for (std::size_t i = 0; i < 2; ++i) square += u[i] * u[i];
    return radius - std::sqrt(square);
  });
}

// Two failure regions far from each other, a series system: 1 − (1 − Φ(−beta))² for two axes.
Margin make_corner(double beta) {
  return in_normal_space([beta](const std::vector<double>& u) { return beta - std::max(u[0], u[1]); });
}

struct Case {
  const char* name;
  std::size_t dimensions;
  Margin margin;
  double probability;
};

std::vector<Case> list_cases() {
  const double radius = std::sqrt(-2 * std::log(1e-5));
  const double beta = 4.3;
  const double one = hil::calc_normal_cdf(-beta);
  return {{"plane", 10, make_plane(4.264890793922825), 1e-5},
          {"circle", 6, make_circle(radius), 1e-5},
          {"corner", 2, make_corner(beta), 2 * one - one * one}};
}

constexpr int kRepetitions = 200;

// Over many seeds: the mean is the probability, the spread is about the one that each run reports, and its interval
// contains the probability about as often as stated.
TEST(Subset, EstimatesOneInAHundredThousandWithFiveThousandRuns) {
  for (const Case& test : list_cases()) {
    SCOPED_TRACE(test.name);
    double sum = 0, square = 0, deviations = 0;
    int within = 0;
    std::int64_t runs = 0;
    for (int seed = 1; seed <= kRepetitions; ++seed) {
      SubsetSimulation subset({static_cast<std::uint64_t>(seed), 900, 90, 8, test.dimensions});
      const std::int64_t count = run(subset, test.margin);
      const SubsetEstimate estimate = subset.calc_estimate();
      ASSERT_TRUE(subset.is_finished());
      EXPECT_LE(count, 5000) << "seed " << seed;
      EXPECT_TRUE(estimate.reached) << "seed " << seed;
      runs += count;
      sum += estimate.probability;
      square += estimate.probability * estimate.probability;
      deviations += estimate.deviation;
      within += estimate.low <= test.probability && test.probability <= estimate.high ? 1 : 0;
    }
    const double mean = sum / kRepetitions, spread = std::sqrt(square / kRepetitions - mean * mean) / mean;
    std::printf("%s: mean / exact %.3f, spread %.3f, said %.3f, within %d of %d, %.0f runs\n", test.name,
                mean / test.probability, spread, deviations / kRepetitions, within, kRepetitions,
                static_cast<double>(runs) / kRepetitions);
    // Four standard errors of the mean of these seeds; a bias of some percent is known, of the order of 1 / N.
    EXPECT_NEAR(mean / test.probability, 1, 4 * spread / std::sqrt(kRepetitions));
    EXPECT_LT(spread, 0.8);
    // The deviation neglects the correlation of levels: Au and Beck, section 5.
    EXPECT_GT(deviations / kRepetitions, 0.6 * spread);
    EXPECT_GE(within, kRepetitions * 80 / 100);
  }
}

TEST(Subset, AProbabilityThatIsNotRareIsThatOfIndependentSamples) {
  SubsetSimulation subset({7, 1000, 100, 8, 3});
  const Margin margin = make_plane(0.5);
  EXPECT_EQ(run(subset, margin), 1000);
  int failed = 0;
  for (std::int64_t i = 0; i < 1000; ++i) failed += margin(subset.calc_point(i)) < 0 ? 1 : 0;
  const SubsetEstimate estimate = subset.calc_estimate();
  EXPECT_EQ(estimate.probability, failed / 1000.0);
  EXPECT_NEAR(estimate.deviation, std::sqrt((1 - estimate.probability) / (estimate.probability * 1000)), 1e-12);
}

// Workers give results in any order, and a resumed file in any other.
TEST(Subset, TheOrderOfResultsChangesNothing) {
  const Margin margin = make_circle(3);
  const SubsetPlan plan{3, 200, 20, 6, 4};
  SubsetSimulation straight(plan);
  const std::int64_t count = run(straight, margin);
  std::vector<double> margins(static_cast<std::size_t>(count));
  SubsetSimulation again(plan);
  for (std::int64_t i = 0; i < count; ++i) {
    margins[static_cast<std::size_t>(i)] = margin(again.calc_point(i));
    again.note(i, margins[static_cast<std::size_t>(i)]);
  }
  std::mt19937 random(11);
  SubsetSimulation mixed(plan);
  for (std::int64_t begin = 0; begin < count;) {
    std::vector<std::int64_t> open(static_cast<std::size_t>(mixed.get_end() - begin));
    std::iota(open.begin(), open.end(), begin);
    begin = mixed.get_end();
    std::shuffle(open.begin(), open.end(), random);
    for (const std::int64_t sample : open) {
      EXPECT_EQ(margin(mixed.calc_point(sample)), margins[static_cast<std::size_t>(sample)]);
      mixed.note(sample, margins[static_cast<std::size_t>(sample)]);
    }
  }
  SubsetSimulation resumed(plan);  // all at once, with one missing until the end
  std::vector<std::int64_t> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), std::int64_t{0});
  std::shuffle(all.begin(), all.end(), random);
  for (const std::int64_t sample : all)
    if (sample != 5) resumed.note(sample, margins[static_cast<std::size_t>(sample)]);
  EXPECT_FALSE(resumed.is_finished());
  EXPECT_EQ(resumed.get_end(), 200);
  resumed.note(5, margins[5]);
  for (const SubsetSimulation* other : {&again, &mixed, &resumed}) {
    EXPECT_TRUE(other->is_finished());
    EXPECT_EQ(other->calc_estimate().probability, straight.calc_estimate().probability);
    EXPECT_EQ(other->calc_estimate().deviation, straight.calc_estimate().deviation);
    EXPECT_EQ(other->levels().size(), straight.levels().size());
  }
}

// Every state of a level, not only the last, has the distribution of the inputs below its threshold: moments of a
// half-line's normal distribution, with the density phi(b)/Φ(−b) at its edge.
TEST(Subset, StatesOfALevelKeepTheDistributionOfTheInputs) {
  double sum = 0, count = 0, expected = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SubsetSimulation subset({seed, 1000, 100, 3, 1});
    (void)run(subset, in_normal_space([](const std::vector<double>& u) { return 9 - u[0]; }));
    const hil::SubsetLevel& level = subset.levels().at(1);  // u above 9 − threshold of level 0
    const double edge = 9 - subset.levels().at(0).threshold;
    for (const double margin : level.margins) sum += 9 - margin, ++count;
    constexpr double kDensity0 = 0.3989422804014327;
    expected += kDensity0 * std::exp(-0.5 * edge * edge) / hil::calc_normal_cdf(-edge);
  }
  EXPECT_NEAR(sum / count, expected / 100, 0.01);  // standard error: 0.4 of one state, some 0.003 of these
}

TEST(Subset, ASampleWithoutAResultIsAFailure) {
  SubsetSimulation subset({1, 100, 10, 5, 2});
  run(subset, [](const std::vector<double>& point) { return point[0] < 0.3 ? std::nan("") : 1 + point[0]; });
  EXPECT_NEAR(subset.calc_estimate().probability, 0.3, 0.15);
  EXPECT_TRUE(subset.calc_estimate().reached);
}

TEST(Subset, MarginsThatAreAllAlikeEndIt) {
  SubsetSimulation subset({1, 100, 10, 50, 2});
  EXPECT_EQ(run(subset, [](const std::vector<double>&) { return 1.0; }), 100);
  EXPECT_TRUE(subset.is_finished());
  const SubsetEstimate estimate = subset.calc_estimate();
  EXPECT_FALSE(estimate.reached);
  EXPECT_FALSE(estimate.decided);
  EXPECT_TRUE(estimate.tied);
  EXPECT_EQ(estimate.probability, 0);
  EXPECT_EQ(estimate.low, 0);
  EXPECT_NEAR(estimate.high, 1 - std::pow(0.025, 1.0 / 100), 1e-12);  // none of 100 independent samples
}

// Margins that are equal for a part of the samples that is not rare: an outcome that is discrete, a value that is cut.
std::vector<Case> list_tied_cases() {
  const auto cut = [](double most, double beta) {
    return in_normal_space([=](const std::vector<double>& u) { return std::min(most, beta - u[0]); });
  };
  const auto stairs = [](double beta) {
    return in_normal_space([=](const std::vector<double>& u) { return std::floor(beta - u[0]) + 0.5; });
  };
  const auto outcome = [](double probability) {
    return [probability](const std::vector<double>& point) { return point[0] < probability ? -1.0 : 1.0; };
  };
  // A plane; of three samples above its 5 % two have the margin of these 5 %.
  const auto shelf = [](double beta) {
    return in_normal_space([=](const std::vector<double>& u) {
      const double margin = beta - u[0], edge = beta - 1.6448536269514722;
      return margin > edge && u[1] < 0.4307272992954576 ? edge : margin;
    });
  };
  return {{"outcome", 2, outcome(0.04), 0.04},
          {"frequent outcome", 2, outcome(0.3), 0.3},
          {"cut at 4 %", 3, cut(1.968, 3.719016485455709), 1e-4},
          {"cut at 30 %", 3, cut(3.2, 3.719016485455709), 1e-4},
          {"stairs", 2, stairs(4.264890793922825), 1e-5},
          {"shelf", 2, shelf(3.719016485455709), 1e-4}};
}

// Where margins tie, intervals hold the probability as often as where they differ.
TEST(Subset, IntervalsHoldTheProbabilityWhereMarginsTie) {
  constexpr int kSeeds = 80;
  for (const Case& test : list_tied_cases()) {
    SCOPED_TRACE(test.name);
    double sum = 0;
    int within = 0, decided = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      SubsetSimulation subset({static_cast<std::uint64_t>(seed), 1000, 100, 8, test.dimensions});
      run(subset, test.margin);
      const SubsetEstimate estimate = subset.calc_estimate();
      ASSERT_TRUE(subset.is_finished());
      decided += estimate.decided ? 1 : 0;
      sum += estimate.probability;
      within += estimate.low <= test.probability && test.probability <= estimate.high ? 1 : 0;
    }
    std::printf("%s: %d of %d decided, mean / exact %.3f, within %d\n", test.name, decided, kSeeds,
                sum / decided / test.probability, within);
    EXPECT_GE(decided, kSeeds * 3 / 4);  // of the last stair 1.8 % fail: some seeds have too few of them
    EXPECT_NEAR(sum / decided / test.probability, 1, 0.15);
    EXPECT_GE(within, kSeeds * 88 / 100);
  }
}

// Two outcomes, one in ten thousand: a thousand samples cannot show it, and no level leads to it.
TEST(Subset, ARareOutcomeIsUndecidedOrWithinItsBounds) {
  int decided = 0;
  for (int seed = 1; seed <= kRepetitions; ++seed) {
    SubsetSimulation subset({static_cast<std::uint64_t>(seed), 1000, 100, 8, 2});
    run(subset, [](const std::vector<double>& point) { return point[0] < 1e-4 ? -1.0 : 1.0; });
    const SubsetEstimate estimate = subset.calc_estimate();
    decided += estimate.decided ? 1 : 0;
    EXPECT_TRUE(estimate.tied);
    EXPECT_EQ(estimate.reached, estimate.decided);
    EXPECT_EQ(estimate.decided, estimate.probability > 0);
    EXPECT_LE(estimate.low, 1e-4) << "seed " << seed;
    EXPECT_GE(estimate.high, 1e-4) << "seed " << seed;
  }
  EXPECT_LT(decided, kRepetitions / 5);  // one in ten has a failure
}

// A fifth of the states within the threshold lie strictly below it: so do a fifth of the seeds, and of the next level.
TEST(Subset, StatesOfALevelAreDrawnFromAllThatAreWithinItsThreshold) {
  double below = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SubsetSimulation subset({seed, 1000, 100, 2, 2});
    // 0 … 1: 6 %; 1: 24 %; above: 70 %
    (void)run(subset, [](const std::vector<double>& point) {
      return point[0] < 0.06 ? 0.01 + point[0] : point[0] < 0.3 ? 1 : 1 + point[0];
    });
    ASSERT_EQ(subset.levels().size(), 2U);
    EXPECT_EQ(subset.levels()[0].threshold, 1);
    for (const double margin : subset.levels()[1].margins) below += margin < 1 ? 1 : 0, ++count;
  }
  EXPECT_NEAR(below / count, 0.06 / 0.3, 0.02);  // of 60 levels of 100 chains; 0.6 where the least states are the seeds
}

TEST(Subset, ItEndsWithItsLastLevel) {
  const SubsetPlan plan{1, 100, 10, 3, 2};
  SubsetSimulation subset(plan);
  EXPECT_EQ(run(subset, make_plane(12)), plan.get_most_samples());
  EXPECT_TRUE(subset.is_finished());
  EXPECT_EQ(subset.levels().size(), 3u);
  EXPECT_FALSE(subset.calc_estimate().reached);
}

// Numbers of any origin, such as a manipulated folder of results, cause no crash and no endless loop.
TEST(Subset, AnyNumbersAreBorne) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 300; ++trial) {
    SubsetSimulation subset({random(), 20, trial % 2 == 0 ? 2 : 10, 4, 2});
    for (int i = 0; i < 400; ++i) {
      const double odd[] = {0,
                            -0.0,
                            1,
                            -1,
                            std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity(),
                            std::nan(""),
                            1e-300};
      subset.note(static_cast<std::int64_t>(random() % 120) - 10, odd[random() % 8]);
      if (!subset.is_finished()) (void)subset.calc_point(subset.get_end() - 1);
    }
    const SubsetEstimate estimate = subset.calc_estimate();
    EXPECT_GE(estimate.probability, 0);
    EXPECT_LE(estimate.probability, 1);
  }
}

}  // namespace
}  // namespace unlatch::test::subset_test
