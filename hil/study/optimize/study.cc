#include "hil/study/optimize/study.h"

#include <algorithm>
#include <cmath>

#include "hil/scenario/base/module.h"
#include "hil/study/optimize/scaled_space.h"

namespace unlatch::hil {
namespace {

constexpr double kActive = 1e-3;       // relative to the limit
constexpr double kShift = 0.01;        // relative to the limit, for the shadow price
constexpr double kSensitivity = 1e-4;  // relative to a variable's range
constexpr int kSlice = 21;             // points from bound to bound
constexpr std::int64_t kShadowRuns = 100;

class Study {
 public:
  Study(const OptimizeProblem& problem, OptimizeEvaluations& evaluations, const OptimizeMerit& merit,
        OptimizeResult& result)
      : problem_(problem),
        evaluations_(evaluations),
        merit_(merit),
        result_(result),
        best_(evaluations.get_samples()[result.best]) {}

  void run() {
    evaluations_.end_progress();
    evaluations_.set_deadline(problem_.budget.seconds);
    const std::int64_t most = evaluations_.get_runs() + std::min(kStudyRuns, problem_.budget.runs);
    evaluations_.set_limit(most);
    add_sensitivities();
    result_.constraints.resize(problem_.constraints.size());
    for (std::size_t i = 0; i < problem_.constraints.size(); ++i) {
      ConstraintStudy& study = result_.constraints[i];
      study.active = result_.feasible && best_.margins[i] <= kActive * merit_.constraint_scale(i);
      evaluations_.set_limit(std::min(most, evaluations_.get_runs() + kShadowRuns));
      if (study.active && problem_.objectives.size() == 1 && !list_continuous(problem_).empty() &&
          !problem_.constraints[i].both)
        study.shadow = calc_shadow(i);
    }
    evaluations_.set_limit(most);
    add_slices();
  }

 private:
  const OptimizeSample& get(std::int64_t index) const {
    return evaluations_.get_samples()[static_cast<std::size_t>(index)];
  }

  void add_sensitivities() {
    result_.sensitivities.resize(problem_.variables.size());
    const std::vector<std::size_t> list = list_continuous(problem_);
    std::vector<OptimizePoint> points;
    for (const std::size_t i : list)
      for (const double sign : {-1.0, 1.0}) {
        const OptimizeVariable& variable = problem_.variables[i];
        points.push_back(best_.point);
        points.back()[i] = std::clamp(best_.point[i] + sign * kSensitivity * (variable.upper - variable.lower),
                                      variable.lower, variable.upper);
      }
    std::vector<std::int64_t> indices;
    if (!evaluations_.evaluate(points, indices)) return;
    for (std::size_t k = 0; k < list.size(); ++k) {
      const OptimizeSample &a = get(indices[2 * k]), &b = get(indices[2 * k + 1]);
      const double width = b.point[list[k]] - a.point[list[k]];
      std::vector<double>& row = result_.sensitivities[list[k]];
      for (std::size_t i = 0; i < a.objectives.size(); ++i) row.push_back((b.objectives[i] - a.objectives[i]) / width);
      for (std::size_t i = 0; i < a.values.size(); ++i) row.push_back((b.values[i] - a.values[i]) / width);
    }
  }

  // Adds slices through the result, one variable at a time; of a catalogue its entries.
  void add_slices() {
    result_.slices.resize(problem_.variables.size());
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const OptimizeVariable& variable = problem_.variables[i];
      std::vector<OptimizePoint> points;
      for (int k = 0; k < kSlice; ++k) {
        const double x = variable.lower + (variable.upper - variable.lower) * k / (kSlice - 1);
        points.push_back(best_.point);
        points.back()[i] = variable.is_catalogue() ? std::round(x) : x;
      }
      points.push_back(best_.point);
      std::sort(points.begin(), points.end(), [&](const auto& a, const auto& b) { return a[i] < b[i]; });
      points.erase(std::unique(points.begin(), points.end()), points.end());
      std::vector<std::int64_t> indices;
      if (!evaluations_.evaluate(points, indices)) return;
      result_.slices[i].assign(indices.begin(), indices.end());
    }
  }

  // Improvement of the optimum if the limit is relaxed by kShift of its size.
  std::optional<double> calc_shadow(std::size_t constraint) {
    std::vector<double> shifts(problem_.constraints.size(), 0.0);
    shifts[constraint] = -kShift;
    const double before = merit_.scale(best_).objectives[0];
    double found = before;
    ScaledProblem scaled = make_scaled(problem_, evaluations_, merit_, list_continuous(problem_), best_.point, shifts);
    const auto evaluate = scaled.evaluate;
    scaled.evaluate = [&](const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples) {
      if (!evaluate(points, samples)) return false;
      for (const ScaledSample& sample : samples)
        if (std::all_of(sample.constraints.begin(), sample.constraints.end(),
                        [](double c) { return c <= OptimizeMerit::kWithin; }))
          found = std::min(found, sample.objectives[0]);
      return true;
    };
    find_function<LocalSearch>(kOptimizersModule, "unlatch_search_local")(scaled);
    if (evaluations_.was_stopped()) return std::nullopt;
    const double change = (found - before) * merit_.objective_scale(0) * (problem_.objectives[0].maximise ? -1 : 1);
    const double raised =
        kShift * merit_.constraint_scale(constraint) * (problem_.constraints[constraint].at_least ? -1 : 1);
    return change / raised;
  }

  const OptimizeProblem& problem_;
  OptimizeEvaluations& evaluations_;
  const OptimizeMerit& merit_;
  OptimizeResult& result_;
  const OptimizeSample best_;
};

}  // namespace

void study_result(const OptimizeProblem& problem, OptimizeEvaluations& evaluations, const OptimizeMerit& merit,
                  OptimizeResult& result) {
  Study(problem, evaluations, merit, result).run();
}

}  // namespace unlatch::hil
