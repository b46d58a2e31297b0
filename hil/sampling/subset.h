// Subset simulation: the probability of a rare failure, margin < 0, as a product of probabilities that are not rare.
// S.-K. Au, J. L. Beck: Estimation of small failure probabilities in high dimensions by subset simulation,
// Probabilistic Engineering Mechanics 16 (2001) 263-277. Candidates by conditional sampling in standard normal space:
// I. Papaioannou, W. Betz, K. Zwirglmaier, D. Straub: MCMC algorithms for subset simulation, the same 41 (2015) 89-103.
// Formulae: hil/campaign/THEORY.md.
//
// Level 0 are N independent points. The margin that a part p0 of a level's N states does not exceed is its threshold.
// The p0 N states below it are seeds of chains; each chain has 1/p0 states, all below the threshold, and all chains
// together are the N states of the next level. The last level is the one of which p0 N states fail.
//
// Samples are numbered as they may be run: first level 0, then for each level step by step the candidates of all
// chains. A candidate depends on the plan and on the margins of the samples before its step, so those of one step may
// be run anywhere in any order. A class without threads and files; memory: three numbers per axis and state of a level,
// and one per sample.
#pragma once

#include <cstdint>
#include <vector>

namespace unlatch::hil {

struct SubsetPlan {
  std::uint64_t seed = 0;
  std::int64_t samples = 0;  // N, states of a level; a multiple of `chains`
  std::int64_t chains = 0;   // p0 N, from 1 to N/2
  int levels = 1;            // most of them, level 0 included
  std::size_t dimensions = 0;

  [[nodiscard]] std::int64_t get_most_samples() const { return samples + (levels - 1) * (samples - chains); }
};

struct SubsetLevel {
  std::int64_t first = 0, last = 0;  // samples that it ran: from, to before
  double threshold = 0;              // margin; 0 of the last level
  double probability = 0;            // part of its states that is not above; of the last level: that fails
  double deviation = 0;              // coefficient of variation of this probability, NaN if it is 0
  double acceptance = 1;             // part of its candidates that became states
  double spread = 1;                 // standard deviation of a candidate about (1 - spread²)½ times its predecessor
  std::vector<double> margins;       // of its states, sorted
};

struct SubsetEstimate {
  double probability = 0;
  double deviation = 0;      // coefficient of variation, levels taken as independent; NaN if the probability is 0
  double low = 0, high = 1;  // 95 %: lognormal with that coefficient of variation
  bool reached = false;      // false: no level had p0 N failures; only an upper end of the probability is known well
};

class SubsetSimulation {
 public:
  explicit SubsetSimulation(const SubsetPlan& plan);

  // The samples before this one have points; it grows with note().
  [[nodiscard]] std::int64_t get_end() const { return end_; }
  // All levels are complete; what is not noted is not needed.
  [[nodiscard]] bool is_finished() const { return finished_; }
  // Of a sample of level 0 or of the step that is under way; in the unit cube.
  [[nodiscard]] std::vector<double> calc_point(std::int64_t sample) const;
  // Its result, in any order, also before it has a point; -infinity: there is none, which is a failure.
  void note(std::int64_t sample, double margin);

  // Those that are complete.
  [[nodiscard]] const std::vector<SubsetLevel>& levels() const { return levels_; }
  [[nodiscard]] SubsetEstimate calc_estimate() const;

 private:
  struct State {
    std::vector<double> u;  // standard normal
    double margin = 0;
  };
  [[nodiscard]] bool is_step_complete() const;
  [[nodiscard]] std::int64_t get_step_size() const { return levels_.empty() ? plan_.samples : plan_.chains; }
  void end_step();
  void end_level();
  void begin_level(const std::vector<std::size_t>& order);
  [[nodiscard]] std::vector<double> draw_normal(std::int64_t sample) const;
  void plan_step();
  [[nodiscard]] double calc_deviation(double threshold, bool fails, double probability) const;

  const SubsetPlan plan_;
  std::vector<double> margins_;    // by sample
  std::vector<bool> known_;        // by sample
  std::vector<State> states_;      // of this level; those of a step together, in the order of the chains
  std::vector<State> candidates_;  // of this step
  std::int64_t step_first_ = 0;    // sample
  std::int64_t end_ = 0;           // of the step
  std::int64_t step_missing_ = 0;  // samples of the step that are not known
  std::int64_t accepted_ = 0;      // of this level
  double spread_ = 1;
  std::vector<SubsetLevel> levels_;
  bool finished_ = false, reached_ = false;
};

}  // namespace unlatch::hil
