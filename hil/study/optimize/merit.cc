#include "hil/study/optimize/merit.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace unlatch::hil {
namespace {

bool dominates(const std::vector<double>& a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k] > b[k]) return false;
  return true;  // equal designs: the first stays
}

}  // namespace

// Scales of constraints: the limit, or for a limit of 0 the value at the start.
OptimizeMerit::OptimizeMerit(const OptimizeProblem& problem, const OptimizeSample* start) : problem_(problem) {
  const auto size_of = [](double value) { return std::isfinite(value) && value != 0 ? std::abs(value) : 1.0; };
  for (std::size_t i = 0; i < problem_.objectives.size(); ++i)
    objective_scales_.push_back(size_of(start != nullptr ? start->objectives[i] : 1));
  for (std::size_t i = 0; i < problem_.constraints.size(); ++i) {
    const double limit = problem_.constraints[i].limit;
    constraint_scales_.push_back(limit != 0 ? std::abs(limit) : size_of(start != nullptr ? start->values[i] : 1));
  }
}

ScaledSample OptimizeMerit::scale(const OptimizeSample& sample, const std::vector<double>& shifts) const {
  ScaledSample scaled;
  for (std::size_t i = 0; i < problem_.objectives.size(); ++i) {
    const double value = i < sample.objectives.size() ? sample.objectives[i] / objective_scales_[i] : std::nan("");
    scaled.objectives.push_back(!std::isfinite(value) ? kNoResult : problem_.objectives[i].maximise ? -value : value);
  }
  for (std::size_t i = 0; i < sample.margins.size(); ++i) {
    const double value = kWithin + (shifts.empty() ? 0.0 : shifts[i]) - sample.margins[i] / constraint_scales_[i];
    scaled.constraints.push_back(std::isfinite(value) ? std::min(value, kNoResult) : kNoResult);
  }
  return scaled;
}

double OptimizeMerit::calc_violation(const OptimizeSample& sample, std::size_t constraint) const {
  const double margin = sample.margins[constraint];
  return std::isfinite(margin) ? std::max(0.0, -margin / constraint_scales_[constraint]) : kNoResult;
}

Violation OptimizeMerit::calc_violation(const OptimizeSample& sample) const {
  Violation violation;
  for (std::size_t i = 0; i < sample.margins.size(); ++i)
    if (const double size = calc_violation(sample, i); size > violation.size) violation = {size, i, std::nullopt};
  for (std::size_t i = 0; i < sample.objectives.size() && violation.size < kNoResult; ++i)
    if (!std::isfinite(sample.objectives[i])) violation = {kNoResult, std::nullopt, i};
  return violation;
}

bool OptimizeMerit::is_better(const OptimizeSample& sample, const OptimizeSample& other) const {
  const auto merit = [&](const OptimizeSample& one) {
    const double violation = calc_violation(one).size;
    return std::pair(violation, violation > 0 ? 0.0 : scale(one).objectives[0]);
  };
  return merit(sample) < merit(other);
}

std::vector<std::size_t> OptimizeMerit::find_front(const std::vector<OptimizeSample>& samples) const {
  std::vector<std::pair<std::vector<double>, std::size_t>> points;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (is_feasible(samples[i])) points.emplace_back(scale(samples[i]).objectives, i);
  std::sort(points.begin(), points.end());  // sorted so that no later point dominates an earlier one
  std::vector<std::vector<double>> front;
  std::vector<std::size_t> indices;
  for (const auto& point : points) {
    if (std::any_of(front.begin(), front.end(), [&](const auto& other) { return dominates(other, point.first); }))
      continue;
    front.push_back(point.first);
    indices.push_back(point.second);
  }
  return indices;
}

std::size_t OptimizeMerit::find_middle(const std::vector<OptimizeSample>& samples,
                                       const std::vector<std::size_t>& front) const {
  std::vector<std::vector<double>> points;
  for (const std::size_t i : front) points.push_back(scale(samples[i]).objectives);
  std::vector<double> least = points[0], most = points[0];
  for (const std::vector<double>& point : points)
    for (std::size_t k = 0; k < point.size(); ++k) {
      least[k] = std::min(least[k], point[k]);
      most[k] = std::max(most[k], point[k]);
    }
  std::size_t middle = 0;
  double nearest = HUGE_VAL;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double distance = 0;
    for (std::size_t k = 0; k < least.size(); ++k)
      if (most[k] > least[k]) distance += std::pow((points[i][k] - least[k]) / (most[k] - least[k]), 2);
    if (distance < nearest) {
      nearest = distance;
      middle = front[i];
    }
  }
  return middle;
}

}  // namespace unlatch::hil
