// What a search asks of designs under dispersions: how many samples each flies, and which part of them meets each
// constraint with a probability. Fresh samples judge the result. The best design for given samples is one that these
// flatter, and where a limit is active its probability of failure is next to the allowed one: a search that asks for
// the probability itself ends at results that no number of fresh samples confirms. So it asks for more where they do
// not.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/study/optimize/problem/problem.h"

namespace unlatch::hil {

struct OptimizeDemand {
  std::int64_t flights = 0;     // 0: no constraint has a probability
  std::vector<double> parts{};  // by constraint; 0 of one without a probability

  friend bool operator==(const OptimizeDemand&, const OptimizeDemand&) = default;
  friend bool operator<(const OptimizeDemand& a, const OptimizeDemand& b) {
    return a.flights != b.flights ? a.flights < b.flights : a.parts < b.parts;
  }
};

// Demand of the first search: the problem's samples and probabilities.
OptimizeDemand get_first_demand(const OptimizeProblem& problem);

// Samples of a first search from whose result that of the demand goes on: an eighth, but no fewer than 32, nor than
// kCoarseFailures failures have at the limit of each probability. 0: the demand has hardly more.
std::int64_t choose_coarse(const OptimizeProblem& problem, const OptimizeDemand& demand);
inline constexpr double kCoarseFailures = 4;

// Probability of failure that so many samples almost surely show to be allowed: their greatest count of failures whose
// upper bound (Clopper and Pearson 1934, 95 %) is within `allowed`, less twice its standard deviation. With fewer
// `deviations` less surely: with none half of the sets of samples show it.
inline constexpr double kSure = 2;
double calc_confirmable(double allowed, std::int64_t samples, double deviations = kSure);

}  // namespace unlatch::hil
