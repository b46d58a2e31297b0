#include "hil/study/optimize/confirmation.h"

#include <algorithm>
#include <cmath>

#include "hil/study/statistics/statistics.h"

namespace unlatch::hil {
namespace {

using Shown = DispersedCheck::Verdict;

constexpr std::int64_t kGrowth = 4;  // of the dispersed samples
constexpr double kLeastPart = 0.01;  // of them that a search asks for

double divide(std::int64_t count, std::int64_t all) { return static_cast<double>(count) / static_cast<double>(all); }

std::int64_t count_below(const std::vector<double>& sorted, double margin) {
  return std::ranges::lower_bound(sorted, margin) - sorted.begin();
}

// The margin of this design to which its limit may be moved so that almost all sets of fresh samples confirm it.
double calc_confirmable_margin(const OptimizeProblem& problem, std::size_t constraint, const DispersedCheck& check,
                               double deviations) {
  const std::int64_t most = OptimizeEvaluations::kMoreChecks * problem.campaign->checks;
  const double failing = calc_confirmable(1 - problem.constraints[constraint].probability, most, deviations);
  return calc_quantile(check.constraints[constraint].margins, failing);
}

// The parts of so many samples of the search that lead fresh ones to confirm a design like this one: those that reach,
// at this design, the margin that fresh samples would confirm. The difference between both is that of the draws, which
// neighbours share.
std::optional<OptimizeDemand> calc_demand(const OptimizeProblem& problem, const OptimizeEvaluations& evaluations,
                                          const OptimizePoint& point, const DispersedCheck& check, std::int64_t flights,
                                          double deviations) {
  const auto margins = evaluations.fly_margins(point, flights);
  if (!margins) return std::nullopt;
  OptimizeDemand demand{flights, evaluations.get_demand().parts};
  for (std::size_t k = 0; k < demand.parts.size(); ++k) {
    if (!(demand.parts[k] > 0)) continue;
    const double probability = problem.constraints[k].probability,
                 margin = calc_confirmable_margin(problem, k, check, deviations);
    double failing = 0;
    if (std::isfinite(margin)) {
      // A quantile at a sample: between two that are far from each other it would be of neither.
      failing = divide(count_below((*margins)[k], margin), std::max<std::int64_t>(1, flights - 1));
    } else {  // too many fresh samples have no result: no limit helps, another design must
      const std::int64_t most = OptimizeEvaluations::kMoreChecks * problem.campaign->checks;
      failing = calc_confirmable(1 - probability, most) + divide(count_below((*margins)[k], 0), flights) -
                divide(count_below(check.constraints[k].margins, 0), check.samples);
    }
    demand.parts[k] = std::clamp(1 - failing, std::max(kLeastPart, 2 * probability - 1), 1.0);
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

bool is_denied_by_search_alone(const OptimizeProblem& problem, const OptimizeSample& sample,
                               const DispersedCheck& check) {
  if (check.has(Shown::kOpen) || check.has(Shown::kRefuted)) return false;
  for (std::size_t i = 0; i < sample.margins.size(); ++i)
    if (!(problem.constraints[i].probability > 0) && !(sample.margins[i] >= 0)) return false;
  return !sample.objectives.empty() &&
         std::ranges::all_of(sample.objectives, [](double value) { return std::isfinite(value); });
}

double calc_room(const OptimizeProblem& problem, std::size_t constraint, const DispersedCheck& check,
                 double deviations) {
  if (!(problem.constraints[constraint].probability > 0) || check.constraints[constraint].verdict != Shown::kConfirmed)
    return 0;
  const double margin = calc_confirmable_margin(problem, constraint, check, deviations);
  return std::isfinite(margin) ? std::max(0.0, margin) : 0.0;
}

std::optional<OptimizeDemand> choose_demand(const OptimizeProblem& problem, const OptimizeEvaluations& evaluations,
                                            const OptimizeSample& sample, std::span<const std::size_t> against,
                                            std::optional<double> deviations, const DispersedCheck& check) {
  const OptimizeDemand& now = evaluations.get_demand();
  const std::int64_t more = std::min(kGrowth * now.flights, std::max(problem.campaign->most, now.flights));
  const OptimizePoint point = sample.point;
  const auto correct = [&](std::int64_t flights) {
    auto next = calc_demand(problem, evaluations, point, check, flights, deviations.value_or(kSure));
    if (next == now) next = calc_demand(problem, evaluations, point, check, more, deviations.value_or(kSure));
    return next == now ? std::nullopt : next;
  };
  if (!against.empty()) {
    if (is_denied_by_search_alone(problem, sample, check)) return correct(now.flights);
    if (more == now.flights || !misses_unconfirmed(problem, sample, against, check)) return std::nullopt;
    return OptimizeDemand{more, now.parts};
  }
  if (check.has(Shown::kRefuted)) return correct(more);
  if (check.has(Shown::kOpen)) return correct(now.flights);
  return deviations ? correct(more) : std::nullopt;
}

}  // namespace unlatch::hil
