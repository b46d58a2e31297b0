// Facts about samples that are distributed to workers, and about the threads that run them.
#include "hil/study/campaign/samples/handout.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>

#include "hil/study/campaign/samples/runner.h"
#include "hil/study/campaign/samples/sample_pool.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::handout_test {
namespace {

namespace fs = std::filesystem;

using hil::Handout;

// Simulates workers that need `cost` s for a sample each, one after the other; returns the samples of each. `end`: s,
// of the last one.
std::vector<std::vector<std::int64_t>> simulate(Handout& handout, const std::vector<double>& cost, double& end) {
  constexpr double kTurn = 0.001;  // s
  struct Worker {
    std::vector<std::int64_t> waiting, ran;
    double busy_until = 0;
  };
  std::vector<Worker> workers(cost.size());
  for (std::size_t w = 0; w < cost.size(); ++w) handout.join(static_cast<int>(w), 1);
  int turn = 0;
  for (; !handout.is_finished() && turn < 1000000; ++turn) {
    const double now = turn * kTurn;
    for (std::size_t w = 0; w < cost.size(); ++w) {
      Worker& worker = workers[w];
      if (!worker.waiting.empty() && now >= worker.busy_until) {
        EXPECT_TRUE(handout.take(static_cast<int>(w), worker.waiting.front()));
        worker.ran.push_back(worker.waiting.front());
        worker.waiting.erase(worker.waiting.begin());
        worker.busy_until = now + cost[w];
      }
      const bool idle = worker.waiting.empty();
      for (const std::int64_t sample : handout.assign(static_cast<int>(w), now)) worker.waiting.push_back(sample);
      if (idle) worker.busy_until = now + cost[w];
    }
  }
  end = turn * kTurn;
  std::vector<std::vector<std::int64_t>> ran;
  for (const Worker& worker : workers) ran.push_back(worker.ran);
  return ran;
}

TEST(Handout, EverySampleThatIsMissingIsGivenOnce) {
  Handout handout(10, 60, {3, 12, 59, 60, 200});
  double end = 0;
  std::vector<std::int64_t> all;
  for (const auto& ran : simulate(handout, {0.01, 0.02, 0.005}, end)) all.insert(all.end(), ran.begin(), ran.end());
  std::sort(all.begin(), all.end());
  std::vector<std::int64_t> expected(50);
  std::iota(expected.begin(), expected.end(), 10);
  std::erase(expected, 12);
  std::erase(expected, 59);
  EXPECT_EQ(all, expected);
}

TEST(Handout, SlowWorkersGetFewerAndAreNotWaitedForLong) {
  Handout handout(0, 2000, {});
  double end = 0;
  const auto ran = simulate(handout, {0.01, 0.01, 1.0}, end);
  EXPECT_LT(ran[2].size(), 20u);
  EXPECT_GT(ran[0].size(), 900u);
  EXPECT_LT(end, 2000 * 0.01 / 2 + 2.1);  // at most the two that the slow worker had at the end
}

TEST(Handout, WhatAWorkerWasNotGivenIsNotTaken) {
  Handout handout(0, 4, {});
  handout.join(0, 1);
  handout.join(1, 1);
  const std::vector<std::int64_t> given = handout.assign(0, 0);
  ASSERT_FALSE(given.empty());
  EXPECT_FALSE(handout.take(1, given[0]));  // another worker's sample
  EXPECT_FALSE(handout.take(7, given[0]));  // unknown worker
  EXPECT_FALSE(handout.take(0, -1));
  EXPECT_FALSE(handout.take(0, 4));
  EXPECT_TRUE(handout.take(0, given[0]));
  EXPECT_FALSE(handout.take(0, given[0]));  // twice
  EXPECT_FALSE(handout.is_finished());
}

TEST(Handout, ExtendedItGivesWhatIsMissingThere) {
  Handout handout(0, 3, {1, 4, 7});
  handout.join(0, 20);
  EXPECT_EQ(handout.assign(0, 0), (std::vector<std::int64_t>{0, 2}));
  handout.extend(6);
  handout.extend(5);
  EXPECT_EQ(handout.assign(0, 0), (std::vector<std::int64_t>{3, 5}));
  for (const std::int64_t sample : {0, 2, 3, 5}) EXPECT_TRUE(handout.take(0, sample));
  EXPECT_TRUE(handout.is_finished());
  handout.extend(8);
  EXPECT_EQ(handout.assign(0, 0), (std::vector<std::int64_t>{6}));
}

TEST(Handout, NothingMissingIsFinished) { EXPECT_TRUE(Handout(0, 2, {1, 0}).is_finished()); }

class SamplePoolTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "s.yaml") << kGoodScenario;
    campaign_ = hil::load_campaign_text(
        "unlatch_campaign: 1\nname: c\nscenario: s.yaml\nset: {step.until: 0.05 s}\nsamples: 12\nparameters:\n"
        "  m: {path: bodies.core.mass, uniform: {min: 90 kg, max: 110 kg}}\n",
        "c.yaml", folder_.string());
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::vector<hil::PlannedSample> plan(const std::vector<std::int64_t>& numbers) const {
    std::vector<hil::PlannedSample> samples;
    for (const std::int64_t number : numbers) samples.push_back({number, draw_inputs(campaign_, number)});
    return samples;
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / ("pool_" + std::to_string(getpid()));
  hil::Campaign campaign_;
};

TEST_F(SamplePoolTest, GivesTheRecordsOfTheSamplesItGot) {
  const hil::SampleEvaluator evaluator(*campaign_.tree);
  hil::SamplePool pool(campaign_, evaluator, 2);
  const std::vector<hil::PlannedSample> samples = plan({7, 1, 4, 11});
  pool.add(samples);
  std::map<std::int64_t, std::uint64_t> hashes;
  while (hashes.size() < samples.size())
    for (const hil::SampleRecord& record : pool.take(std::chrono::milliseconds(1)))
      EXPECT_TRUE(hashes.emplace(record.sample, calc_hash(record)).second);
  const std::atomic<bool> never{false};
  for (const hil::PlannedSample& sample : samples)
    EXPECT_EQ(hashes.at(sample.sample), calc_hash(run_together(campaign_, evaluator, {sample}, never).front()));
}

TEST_F(SamplePoolTest, EndsWithSamplesThatWait) {
  const hil::SampleEvaluator evaluator(*campaign_.tree);
  hil::SamplePool pool(campaign_, evaluator, 1);
  pool.add(plan(std::vector<std::int64_t>(1000, 3)));
}

TEST_F(SamplePoolTest, HandsOnWhatASampleThrew) {
  campaign_.parameters[0].choices.resize(1);
  const hil::SampleEvaluator evaluator(*campaign_.tree);
  hil::SamplePool pool(campaign_, evaluator, 2);
  const std::vector<hil::PlannedSample> samples{{0, {7}}};  // no such choice: the error belongs to no sample
  pool.add(samples);
  EXPECT_ANY_THROW((void)pool.take(std::chrono::minutes(1)));
}

}  // namespace
}  // namespace unlatch::test::handout_test
