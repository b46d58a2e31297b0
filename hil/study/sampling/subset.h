// Subset simulation: the probability of a rare failure, margin < 0, as a product of probabilities that are not rare.
// S.-K. Au, J. L. Beck: Estimation of small failure probabilities in high dimensions by subset simulation,
// Probabilistic Engineering Mechanics 16 (2001) 263-277. Candidates by conditional sampling in standard normal space:
// I. Papaioannou, W. Betz, K. Zwirglmaier, D. Straub: MCMC algorithms for subset simulation, the same 41 (2015) 89-103.
// Formulae: hil/study/campaign/THEORY.md.
//
// Level 0 consists of N independent points. The threshold of a level is the margin that a part p0 of its N states does
// not exceed. The p0 N states within it are seeds of chains; each chain has 1/p0 states, all within the threshold, and
// all chains together are the N states of the next level. The last level is the one of which p0 N states fail.
//
// Many states may have the same margin, that of the threshold. Then those within it are more than p0 N, their part of
// all is the level's probability, and the seeds are chosen among all of them alike, whatever their margins; or, where
// that would lead hardly further, the next level is drawn from what lies strictly below, with the part of that.
//
// Samples are numbered in the order in which they may be run: first level 0, then for each level, step by step, the
// candidates of all chains. A candidate depends on the plan and on the margins of the samples before its step, so those
// of one step may be run on any machine in any order. The class uses no threads or files; memory: three numbers per
// axis and state of a level, and one per sample.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/study/statistics/statistics.h"

namespace unlatch::hil {

struct SubsetPlan {
  std::uint64_t seed = 0;
  std::int64_t samples = 0;  // N, states of a level; a multiple of `chains`
  std::int64_t chains = 0;   // p0 N, from 1 to N/2
  int levels = 1;            // number of levels at most, level 0 included
  std::size_t dimensions = 0;

  [[nodiscard]] std::int64_t get_most_samples() const { return samples + (levels - 1) * (samples - chains); }
};

struct SubsetLevel {
  std::int64_t first = 0, last = 0;  // samples of the level: from, to before
  double threshold = 0;              // margin; 0 for the last level
  std::int64_t failed = 0;           // its states that fail
  double probability = 0;       // part of its states that is not above the threshold; for the last level: that fails
  double deviation = 0;         // coefficient of variation of this probability, NaN if it is 0
  double acceptance = 1;        // accepted part of its candidates
  double spread = 1;            // standard deviation of a candidate about (1 - spread²)½ times its predecessor
  std::vector<double> margins;  // margins of its states, sorted
};

struct SubsetEstimate {
  double probability = 0;
  double deviation = 0;      // coefficient of variation, levels taken as independent; NaN if the probability is 0
  double low = 0, high = 1;  // 95 %: lognormal with that coefficient of variation; of level 0 alone Clopper-Pearson
  bool reached = false;      // the last level had p0 N failures, or all of it below margins that are equal fails
  bool decided = false;      // false: too few failures for an estimate, which is 0; `high` is an upper bound
  bool tied = false;         // so many margins are equal that no level leads further
};

class SubsetSimulation {
 public:
  explicit SubsetSimulation(const SubsetPlan& plan);

  // Number of samples that have points; it grows with note().
  [[nodiscard]] std::int64_t get_end() const { return end_; }
  // True once all levels are complete; samples without a result are then not needed.
  [[nodiscard]] bool is_finished() const { return finished_; }
  // Point in the unit cube, for a sample of level 0 or of the present step.
  [[nodiscard]] std::vector<double> calc_point(std::int64_t sample) const;
  // Notes a result, in any order, also before the sample has a point; -infinity: no value, which is a failure.
  void note(std::int64_t sample, double margin);

  // Complete levels.
  [[nodiscard]] const std::vector<SubsetLevel>& levels() const { return levels_; }
  [[nodiscard]] SubsetEstimate calc_estimate() const;
  // 95 % bounds by Clopper and Pearson of the independent samples of level 0, which hold whatever the chains have not
  // found. There is a complete level.
  [[nodiscard]] Interval calc_first_bounds() const;

 private:
  struct State {
    std::vector<double> u;  // standard normal coordinates
    double margin = 0;
  };
  [[nodiscard]] std::int64_t get_step_size() const { return levels_.empty() ? plan_.samples : plan_.chains; }
  void end_step();
  void end_level();
  // What follows a level.
  struct Next {
    bool ends = true, reached = false, tied = false;
    double threshold = 0;   // of the next level's states: not above it
    std::size_t count = 0;  // states of this level that are not above it
  };
  [[nodiscard]] Next choose_next(const std::vector<double>& sorted) const;
  // `order`: states from the smallest margin up, the first `count` within the threshold.
  void begin_level(const std::vector<std::size_t>& order, std::size_t count);
  [[nodiscard]] std::int64_t get_least_failures() const;
  [[nodiscard]] std::vector<double> draw_normal(std::int64_t sample) const;
  void plan_step();
  [[nodiscard]] double calc_deviation(double threshold, bool fails, double probability) const;

  const SubsetPlan plan_;
  std::vector<double> margins_;    // by sample
  std::vector<bool> known_;        // by sample
  std::vector<State> states_;      // states of this level; those of a step together, in the order of the chains
  std::vector<State> candidates_;  // candidates of this step
  std::int64_t step_first_ = 0;    // first sample of the step
  std::int64_t end_ = 0;           // end of the step
  std::int64_t step_missing_ = 0;  // samples of the step without a result
  std::int64_t accepted_ = 0;      // accepted candidates of this level
  double spread_ = 1;
  double shared_ = 1;  // chains that begin at the same state, on average
  std::vector<SubsetLevel> levels_;
  bool finished_ = false, reached_ = false, tied_ = false;
};

}  // namespace unlatch::hil
