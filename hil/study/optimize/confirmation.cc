#include "hil/study/optimize/confirmation.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {
namespace {

using Shown = DispersedCheck::Verdict;

constexpr std::int64_t kGrowth = 4;  // of the dispersed samples

double divide(std::int64_t count, std::int64_t all) { return static_cast<double>(count) / static_cast<double>(all); }

// The parts of so many samples of the search that lead fresh ones to confirm a design like this one. The difference
// between both counts of failures is that of the draws, which neighbours share.
std::optional<OptimizeDemand> calc_demand(const OptimizeProblem& problem, const OptimizeEvaluations& evaluations,
                                          const OptimizePoint& point, const DispersedCheck& check,
                                          std::int64_t flights) {
  const auto failures = evaluations.count_failures(point, flights);
  if (!failures) return std::nullopt;
  OptimizeDemand demand{flights, evaluations.get_demand().parts};
  for (std::size_t k = 0; k < demand.parts.size(); ++k) {
    const DispersedCheck::Constraint& fresh = check.constraints[k];
    if (!(demand.parts[k] > 0) || fresh.verdict == Shown::kConfirmed) continue;
    const double probability = problem.constraints[k].probability;
    const double draws = divide((*failures)[k], flights) - divide(fresh.failed + check.unresolved, check.samples);
    const std::int64_t most = OptimizeEvaluations::kMoreChecks * problem.campaign->checks;
    demand.parts[k] = std::clamp(1 - calc_confirmable(1 - probability, most) - draws, probability, 1.0);
  }
  return demand;
}

}  // namespace

bool misses_unconfirmed(const OptimizeProblem& problem, const OptimizeSample& sample,
                        std::span<const std::size_t> against, const std::optional<DispersedCheck>& check) {
  bool misses = false;
  for (const std::size_t i : against) {
    if (sample.margins.size() <= i || !std::isfinite(sample.margins[i])) return false;
    if (!(problem.constraints[i].probability > 0)) continue;
    if (check && check->constraints[i].verdict == Shown::kRefuted) return false;
    misses = true;
  }
  return misses;
}

std::optional<OptimizeDemand> choose_demand(const OptimizeProblem& problem, const OptimizeEvaluations& evaluations,
                                            const OptimizeSample& sample, std::span<const std::size_t> against,
                                            const DispersedCheck& check) {
  const OptimizeDemand& now = evaluations.get_demand();
  const std::int64_t more = std::min(kGrowth * now.flights, std::max(problem.campaign->most, now.flights));
  if (!against.empty()) {
    if (more == now.flights || !misses_unconfirmed(problem, sample, against, check)) return std::nullopt;
    return OptimizeDemand{more, now.parts};
  }
  const bool refuted = check.has(Shown::kRefuted);
  if (!refuted && !check.has(Shown::kOpen)) return std::nullopt;
  const OptimizePoint point = sample.point;
  auto next = calc_demand(problem, evaluations, point, check, refuted ? more : now.flights);
  if (next == now) next = calc_demand(problem, evaluations, point, check, more);
  return next == now ? std::nullopt : next;
}

}  // namespace unlatch::hil
