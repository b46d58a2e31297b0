// Facts about optimisation: batches of samples, their journal, and the points that the optimisers evaluate.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "hil/scenario/base/module.h"
#include "hil/study/evaluation/side_by_side.h"
#include "hil/study/optimize/demand.h"
#include "hil/study/optimize/evaluations.h"
#include "hil/study/optimize/optimizers.h"
#include "hil/study/statistics/binomial.h"
#include "hil/study/statistics/statistics.h"

namespace unlatch::test::optimize_test {
namespace {

using hil::OptimizeEvaluations;
using hil::OptimizePoint;
using hil::ScaledProblem;
using hil::ScaledSample;
using testing::ElementsAre;
using Points = std::vector<std::vector<double>>;

// --- Work on several threads ----------------------------------------------------------------------------------------

TEST(SideBySide, AllThreadsWorkAtTheSameTime) {
  constexpr int kThreads = 8;
  constexpr std::chrono::minutes kLongest{1};  // run one after the other, the first would wait for ever
  std::mutex mutex;
  std::condition_variable changed;
  int begun = 0;
  bool together = true;
  const std::atomic<bool> stop{false};
  hil::run_side_by_side(kThreads, kThreads, stop, [&](std::size_t) {
    std::unique_lock lock(mutex);
    ++begun;
    changed.notify_all();
    together = changed.wait_for(lock, kLongest, [&] { return begun == kThreads; }) && together;
  });
  EXPECT_TRUE(together);
}

TEST(SideBySide, EachPieceIsDoneOnce) {
  const std::atomic<bool> stop{false};
  for (const int jobs : {1, 3, 100}) {
    std::vector<std::atomic<int>> done(50);
    hil::run_side_by_side(done.size(), jobs, stop, [&](std::size_t i) { ++done[i]; });
    for (const std::atomic<int>& one : done) EXPECT_EQ(one, 1);
  }
}

TEST(SideBySide, AnExceptionLeavesTheRestAndIsThrown) {
  const std::atomic<bool> stop{false};
  for (const int jobs : {1, 4}) {
    std::atomic<int> done{0};
    const auto work = [&](std::size_t) {
      ++done;
      throw std::runtime_error("no");
    };
    EXPECT_THROW(hil::run_side_by_side(1000, jobs, stop, work), std::runtime_error);
    EXPECT_LE(done, jobs);
  }
}

// --- The optimisers -------------------------------------------------------------------------------------------------

// Least sum of squares with sum(x) >= 1, starting far from it; stores the requested batches.
struct Quadratic {
  static constexpr std::size_t kVariables = 5;
  std::vector<Points> batches;
  ScaledProblem problem;

  Quadratic() {
    problem.variables = kVariables;
    problem.constraints = 2;
    problem.start.assign(kVariables, 0.7);
    problem.evaluate = [this](const Points& points, std::vector<ScaledSample>& samples) {
      batches.push_back(points);
      samples.clear();
      for (const std::vector<double>& x : points) {
        double sum = 0, squares = 0;
        for (const double one : x) {
          sum += one;
          squares += one * one;
        }
        samples.push_back({{squares}, {1 - sum, x[0] - 0.15}});
      }
      return true;
    };
  }
};

hil::LocalSearch* find_local() {
  try {
    return hil::find_function<hil::LocalSearch>(hil::kOptimizersModule, "unlatch_search_local");
  } catch (const hil::ModuleError&) {
    return nullptr;  // built without NLopt or pagmo
  }
}

std::size_t count_differences(const std::vector<double>& a, const std::vector<double>& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i] ? 1 : 0;
  return count;
}

TEST(OptimizeSearch, AllDifferencesOfAGradientAreOneBatch) {
  hil::LocalSearch* const search = find_local();
  if (search == nullptr) GTEST_SKIP() << "built without NLopt or pagmo";
  Quadratic quadratic;
  search(quadratic.problem);
  std::size_t gradients = 0;
  for (const Points& batch : quadratic.batches) {
    if (batch.size() == 1) continue;  // a single value
    ++gradients;
    // 2 n differences, for the objective and both constraints; and the point itself, unless it was evaluated before.
    EXPECT_THAT(batch.size(), testing::AnyOf(2 * Quadratic::kVariables, 2 * Quadratic::kVariables + 1));
    const Points differences(batch.end() - 2 * Quadratic::kVariables, batch.end());
    for (std::size_t i = 0; i < differences.size(); i += 2) {
      EXPECT_EQ(count_differences(differences[i], differences[i + 1]), 1U);
      EXPECT_LT(differences[i][i / 2], differences[i + 1][i / 2]);
    }
  }
  EXPECT_GT(gradients, 1U);
}

// NLopt mistakes an exception in a function for a search without progress.
TEST(OptimizeSearch, AnExceptionInAFlightEndsTheLocalSearchAndIsThrown) {
  hil::LocalSearch* const search = find_local();
  if (search == nullptr) GTEST_SKIP() << "built without NLopt or pagmo";
  for (const std::size_t after : {0U, 1U, 2U, 40U}) {
    Quadratic quadratic;
    const auto evaluate = quadratic.problem.evaluate;
    quadratic.problem.evaluate = [&](const Points& points, std::vector<ScaledSample>& samples) {
      if (quadratic.batches.size() >= after) throw hil::JournalError("no space");
      return evaluate(points, samples);
    };
    EXPECT_THROW(search(quadratic.problem), hil::JournalError);
    EXPECT_EQ(quadratic.batches.size(), after);
  }
}

// --- Batches and their journal --------------------------------------------------------------------------------------

constexpr const char* kScenario = R"(unlatch: 1
name: push
step: {dt: 10 ms, until: 0.1 s}
bodies: {block: {mass: 1 kg, inertia: [1, 1, 1]}}
elements:
  push: {type: force, body: block, direction: [1, 0, 0], profile: 1 N}
requirements:
  - {id: far, position: {body: block, along: [1, 0, 0]}, take: final, at_least: 1 mm}
)";
constexpr const char* kProblem = R"(unlatch_optimize: 1
name: push
scenario: s.yaml
variables:
  force: {path: elements.push.profile, between: [0 N, 5 N]}
objectives: [{minimise: force}]
)";

class OptimizeJournal : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("journal-") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "s.yaml") << kScenario;
    problem_ = hil::load_optimize_problem_text(kProblem, "p.yaml", folder_.string());
    journal_ = (folder_ / "history.csv").string();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string read() const {
    std::ifstream file(journal_);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // Number of runs in the journal.
  [[nodiscard]] std::int64_t count_rows() const {
    const std::string text = read();
    return std::count(text.begin(), text.end(), '\n') - 1;
  }
  [[nodiscard]] OptimizeEvaluations::Options resume(int jobs = 1) const { return {journal_, true, jobs}; }

  std::filesystem::path folder_;
  std::string journal_;
  hil::OptimizeProblem problem_;
  std::atomic<bool> stop_{false};
  std::vector<std::int64_t> indices_;
};

const std::vector<OptimizePoint> kPoints{{0.5}, {1}, {1.5}, {2}, {2.5}, {3}, {3.5}, {4}};

TEST_F(OptimizeJournal, FilesWithTheEarlierNameOfTheKeyAreRead) {
  std::string text = kProblem;
  const std::string key = "unlatch_optimize";
  text.replace(text.find(key), key.size(), "unlatch_synthesis");
  EXPECT_EQ(hil::load_optimize_problem_text(text, "p.yaml", folder_.string()).name, problem_.name);
}

TEST_F(OptimizeJournal, IsTheSameForAnyNumberOfThreads) {
  std::vector<std::string> texts;
  for (const int jobs : {1, 3, 8}) {
    OptimizeEvaluations evaluations(problem_, {journal_, false, jobs}, stop_);
    EXPECT_TRUE(evaluations.evaluate(kPoints, indices_));
    EXPECT_THAT(indices_, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
    texts.push_back(read());
  }
  EXPECT_EQ(texts[0], texts[1]);
  EXPECT_EQ(texts[0], texts[2]);
}

TEST_F(OptimizeJournal, KeepsWhatABatchHadWhenItWasStopped) {
  std::vector<OptimizePoint> points = kPoints;  // as many as a thread runs side by side, and four more
  points.insert(points.end(), {{4.5}, {5}, {5.5}, {6}});
  int seen = 0;
  OptimizeEvaluations evaluations(problem_, {journal_, false, 1}, stop_, [&] {
    if (++seen == 3) stop_ = true;
  });
  EXPECT_FALSE(evaluations.evaluate(points, indices_));
  EXPECT_THAT(indices_, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, -1, -1, -1, -1));
  EXPECT_EQ(count_rows(), 8);
  stop_ = false;
  OptimizeEvaluations next(problem_, resume(4), stop_);
  EXPECT_TRUE(next.evaluate(points, indices_));
  EXPECT_EQ(next.get_taken(), 8);
  EXPECT_EQ(count_rows(), 12);
}

TEST_F(OptimizeJournal, LosesNothingWhenASearchThatGoesOnEndsAtOnce) {
  {
    OptimizeEvaluations evaluations(problem_, {journal_, false, 1}, stop_);
    EXPECT_TRUE(evaluations.evaluate(kPoints, indices_));
  }
  const std::string whole = read();
  OptimizeEvaluations(problem_, resume(), stop_);
  EXPECT_EQ(read(), whole);
  {
    OptimizeEvaluations evaluations(problem_, resume(), stop_);
    EXPECT_TRUE(evaluations.evaluate({{0.5}, {1}}, indices_));
    EXPECT_EQ(evaluations.get_taken(), 2);
  }
  EXPECT_EQ(read(), whole);
}

TEST_F(OptimizeJournal, EndsWithTheRunsOfItsSearch) {
  {
    OptimizeEvaluations evaluations(problem_, {journal_, false, 1}, stop_);
    EXPECT_TRUE(evaluations.evaluate(kPoints, indices_));
  }
  {
    OptimizeEvaluations evaluations(problem_, resume(), stop_);
    EXPECT_TRUE(evaluations.evaluate({{0.5}, {1}}, indices_));
    evaluations.finish_journal();
    EXPECT_EQ(count_rows(), 2);
    EXPECT_TRUE(evaluations.evaluate({{4.5}}, indices_));
    EXPECT_EQ(count_rows(), 3);
  }
  OptimizeEvaluations evaluations(problem_, resume(), stop_);
  EXPECT_TRUE(evaluations.evaluate({{0.5}, {1}, {4.5}}, indices_));
  EXPECT_EQ(evaluations.get_taken(), 3);
}

TEST_F(OptimizeJournal, GoesOnFromAHeadingThatWasCutOff) {
  { const OptimizeEvaluations evaluations(problem_, {journal_, false, 1}, stop_); }
  const std::string heading = read();
  for (const std::size_t part : {std::size_t{0}, std::size_t{5}, heading.size() - 1}) {
    std::ofstream(journal_) << heading.substr(0, part);
    OptimizeEvaluations evaluations(problem_, resume(), stop_);
    EXPECT_TRUE(evaluations.evaluate(kPoints, indices_));
    EXPECT_EQ(read().substr(0, heading.size()), heading);
    EXPECT_EQ(count_rows(), 8);
  }
  std::ofstream(journal_) << "of something else\n";
  EXPECT_THROW(OptimizeEvaluations(problem_, resume(), stop_), hil::JournalError);
}

TEST_F(OptimizeJournal, AFullDiskIsThrown) {
  EXPECT_THROW(OptimizeEvaluations(problem_, {"/dev/full", false, 1}, stop_), hil::JournalError);
}

// --- Probabilities ---------------------------------------------------------------------------------------------------

// A design whose probability of failure is the confirmable one is confirmed by almost all sets of samples: the count of
// failures is within two deviations of its mean with 97.7 % probability.
TEST(OptimizeDemand, WhatIsConfirmableIsConfirmedByAlmostAllSamples) {
  for (const double allowed : {0.01, 0.1, 0.45})
    for (const std::int64_t samples : {400, 4096, 32000}) {
      const double p = hil::calc_confirmable(allowed, samples);
      EXPECT_LT(p, allowed);
      if (p == 0) continue;
      const std::int64_t most = hil::calc_binomial_quantile(0.97, samples, p);
      EXPECT_LE(hil::calc_clopper_pearson(most, samples).high, allowed) << allowed << " of " << samples;
    }
  EXPECT_EQ(hil::calc_confirmable(0.01, 100), 0);  // not even no failure at all shows it: 1 - 0.025^(1/100) = 0.036
}

}  // namespace
}  // namespace unlatch::test::optimize_test
