#include "hil/study/optimize/dispersion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/study/statistics/statistics.h"

namespace unlatch::hil {

DispersedPoint::DispersedPoint(const OptimizeProblem& problem, const OptimizePoint& point,
                               const OptimizeFlights& flights)
    : problem_(problem),
      campaign_(make_campaign(*problem.campaign, make_settings(problem, point), flights)),
      evaluator_(*campaign_.tree),
      unresolved_(static_cast<std::size_t>(flights.samples)) {
  for (const OptimizeConstraint& constraint : problem.constraints)
    margins_.emplace_back(constraint.probability > 0 ? static_cast<std::size_t>(count_samples()) : 0);
}

bool DispersedPoint::fly(std::int64_t first, std::size_t number, const std::atomic<bool>& stop) {
  std::vector<SampleTask> tasks;
  for (std::size_t i = 0; i < number; ++i)
    tasks.push_back({make_settings(campaign_, draw_inputs(campaign_, first + static_cast<std::int64_t>(i)))});
  const std::vector<SampleResult> results = evaluator_.evaluate(tasks, stop);
  for (const SampleResult& result : results)
    if (result.status == SampleStatus::kInterrupted) return false;
  for (std::size_t i = 0; i < number; ++i) keep(first + static_cast<std::int64_t>(i), results[i]);
  return true;
}

void DispersedPoint::keep(std::int64_t sample, const SampleResult& result) {
  unresolved_[static_cast<std::size_t>(sample)] = result.status == SampleStatus::kUnresolved ? 1 : 0;
  for (std::size_t i = 0; i < margins_.size(); ++i) {
    if (margins_[i].empty()) continue;
    const auto column = evaluator_.find(problem_.constraints[i].id + ".margin");
    const double margin = result.status == SampleStatus::kDone && column ? result.values[*column] : std::nan("");
    margins_[i][static_cast<std::size_t>(sample)] =
        std::isfinite(margin) ? margin : -std::numeric_limits<double>::infinity();
  }
}

std::vector<double> DispersedPoint::sort_margins(std::size_t constraint) const {
  std::vector<double> sorted = margins_[constraint];
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

double DispersedPoint::get_limit(std::size_t constraint) const {
  return hil::get_limit(campaign_.tree->get_nominal().requirements[problem_.constraints[constraint].requirement]);
}

std::int64_t DispersedPoint::count_failures(std::size_t constraint) const {
  const std::vector<double>& margins = margins_[constraint];
  std::int64_t failures = 0;
  for (std::size_t i = 0; i < margins.size(); ++i) failures += margins[i] < 0 && unresolved_[i] == 0 ? 1 : 0;
  return failures;
}

std::int64_t DispersedPoint::count_unresolved() const { return std::ranges::count(unresolved_, char{1}); }

double calc_margin(const std::vector<double>& sorted, double part) {
  const double margin = calc_quantile(sorted, 1 - part);
  return std::isfinite(margin) ? margin : std::nan("");
}

DispersedMargin describe_margin(const std::vector<double>& sorted, double part) {
  return {calc_margin(sorted, part), calc_quantile_interval(sorted, 1 - part)};
}

bool has_probabilities(const OptimizeProblem& problem) {
  return std::any_of(problem.constraints.begin(), problem.constraints.end(),
                     [](const OptimizeConstraint& constraint) { return constraint.probability > 0; });
}

}  // namespace unlatch::hil
