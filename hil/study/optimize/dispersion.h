// A design under the dispersions of a campaign: margins of all samples; the quantile of the margin decides a constraint
// with a probability. All designs use the same samples, so that differences of designs are not those of draws (common
// random numbers; Glasserman and Yao 1992), and the quantile is as smooth in the design as a single run.
#pragma once

#include <memory>

#include "hil/study/optimize/problem/problem.h"
#include "hil/study/statistics/statistics.h"

namespace unlatch::hil {

class DispersedPoint {
 public:
  // Keeps a reference to the problem. Throws ScenarioError if the campaign has a mistake with this design.
  DispersedPoint(const OptimizeProblem& problem, const OptimizePoint& point, const OptimizeFlights& flights);

  [[nodiscard]] std::int64_t count_samples() const { return campaign_.plan.samples; }
  // Runs `number` samples from `first` on, SampleEvaluator::kSideBySide at the most. Threads may run different ones at
  // a time. A sample that fails misses all constraints. False: `stop` ended them.
  bool fly(std::int64_t first, std::size_t number, const std::atomic<bool>& stop);

  // Margins of a constraint with a probability, after all samples, from the least up; -infinity: a sample without a
  // result.
  [[nodiscard]] std::vector<double> sort_margins(std::size_t constraint) const;
  // Limit of a constraint with a probability in the campaign's scenario with this design.
  [[nodiscard]] double get_limit(std::size_t constraint) const;
  // Samples that fail a constraint, without the unresolved ones, which may fail it or not.
  [[nodiscard]] std::int64_t count_failures(std::size_t constraint) const;
  [[nodiscard]] std::int64_t count_unresolved() const;

 private:
  void keep(std::int64_t sample, const SampleResult& result);

  const OptimizeProblem& problem_;
  const Campaign campaign_;
  const SampleEvaluator evaluator_;
  std::vector<std::vector<double>> margins_;  // [constraint][sample]; empty: constraint of the nominal run
  std::vector<char> unresolved_;              // by sample; of threads that write neighbours
};

// The margin that this part of the samples reaches; NaN if it depends on a sample without a result.
double calc_margin(const std::vector<double>& sorted, double part);

// That margin with its interval, 95 %; nothing: there are too few samples for one.
struct DispersedMargin {
  double margin = 0;
  std::optional<Interval> interval{};
};
DispersedMargin describe_margin(const std::vector<double>& sorted, double part);

bool has_probabilities(const OptimizeProblem& problem);

}  // namespace unlatch::hil
