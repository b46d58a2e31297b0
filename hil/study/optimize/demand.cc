#include "hil/study/optimize/demand.h"

#include <algorithm>
#include <cmath>

#include "hil/study/optimize/dispersion.h"
#include "hil/study/statistics/statistics.h"

namespace unlatch::hil {

OptimizeDemand get_first_demand(const OptimizeProblem& problem) {
  if (!has_probabilities(problem)) return {};
  OptimizeDemand demand{problem.campaign->samples, {}};
  for (const OptimizeConstraint& constraint : problem.constraints) demand.parts.push_back(constraint.probability);
  return demand;
}

std::int64_t choose_coarse(const OptimizeProblem& problem, const OptimizeDemand& demand) {
  constexpr std::int64_t kPart = 8, kLeast = 32, kWorth = 4;
  std::int64_t flights = std::max(kLeast, demand.flights / kPart);
  for (const OptimizeConstraint& constraint : problem.constraints)
    if (constraint.probability > 0)
      flights = std::max(flights, static_cast<std::int64_t>(std::ceil(kCoarseFailures / (1 - constraint.probability))));
  return kWorth * flights <= demand.flights ? flights : 0;
}

double calc_confirmable(double allowed, std::int64_t samples, double deviations) {
  const auto confirms = [&](std::int64_t failed) { return calc_clopper_pearson(failed, samples).high <= allowed; };
  if (!confirms(0)) return 0;
  std::int64_t low = 0, high = samples;  // the first is confirmed, the second is not
  while (high - low > 1) {
    const std::int64_t middle = low + (high - low) / 2;
    (confirms(middle) ? low : high) = middle;
  }
  const auto most = static_cast<double>(low);
  return std::max(0.0, most - deviations * std::sqrt(most)) / static_cast<double>(samples);
}

}  // namespace unlatch::hil
