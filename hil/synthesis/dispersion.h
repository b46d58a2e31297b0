// A design under the dispersions of a campaign: margins of all samples, of which a probability is met by the quantile.
// All designs fly the same samples, so that differences of designs are not those of draws (common random numbers;
// Glasserman and Yao 1992), and the quantile is as smooth in the design as a single run.
#pragma once

#include <memory>

#include "hil/synthesis/problem.h"

namespace unlatch::hil {

class DispersedDesign {
 public:
  // `check`: the samples that verify a result. Refers to the problem. Throws ScenarioError: with this design the
  // campaign has a mistake.
  DispersedDesign(const DesignProblem& problem, const DesignPoint& point, bool check);

  [[nodiscard]] std::int64_t count_samples() const { return campaign_.plan.samples; }
  // `number` samples from `first` on, SampleEvaluator::kSideBySide at the most. Threads may fly different ones at a
  // time. One that faults meets nothing. False: `stop` ended them.
  bool fly(std::int64_t first, std::size_t number, const std::atomic<bool>& stop);

  // Of a constraint with a probability, after all samples: the margin that this part of them has at least; NaN if a
  // sample without a result decides it.
  [[nodiscard]] double calc_margin(std::size_t constraint) const;
  [[nodiscard]] std::int64_t count_failures(std::size_t constraint) const;

 private:
  void keep(std::int64_t sample, const SampleResult& result);

  const DesignProblem& problem_;
  const Campaign campaign_;
  const SampleEvaluator evaluator_;
  std::vector<std::vector<double>> margins_;  // [constraint][sample]; empty: of the nominal run
};

bool has_probabilities(const DesignProblem& problem);

}  // namespace unlatch::hil
