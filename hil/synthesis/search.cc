#include "hil/synthesis/search.h"

#include <algorithm>
#include <cmath>

#include "hil/modules/module.h"
#include "hil/synthesis/optimizers.h"

namespace unlatch::hil {
namespace {

constexpr double kWithin = 1e-6;   // constraints are kept by this part of their limit, so that an optimum meets them
constexpr double kActive = 1e-3;   // of the limit
constexpr double kNoResult = 100;  // scaled: of a run that gives none
constexpr double kShift = 0.01;    // of the limit, for its shadow
constexpr double kSensitivity = 1e-4;  // of a variable's range
constexpr double kForPolish = 0.25;    // of the budget, after a global search
constexpr std::int64_t kStudyRuns = 400;

class Search {
 public:
  Search(const DesignProblem& problem, DesignEvaluations& evaluations) : problem_(problem), evaluations_(evaluations) {}

  DesignResult run() {
    evaluations_.set_limit(problem_.budget.runs);
    evaluations_.set_deadline(problem_.budget.seconds);
    std::vector<std::int64_t> first;
    scale(evaluations_.evaluate({get_start()}, first));
    if (!first.empty() && first[0] >= 0) look();
    result_.search_runs = evaluations_.get_runs();
    if (evaluations_.was_stopped())
      result_.end = DesignResult::End::kStopped;
    else if (spent_)
      result_.end = DesignResult::End::kBudget;
    if (evaluations_.get_samples().empty()) return result_;
    take_best();
    if (!evaluations_.was_stopped()) study();
    return result_;
  }

 private:
  [[nodiscard]] DesignPoint get_start() const {
    DesignPoint point;
    for (const DesignVariable& variable : problem_.variables) point.push_back(variable.start);
    return point;
  }

  // A constraint's unit is its limit; that of one whose limit is 0 its value at the start.
  void scale(bool known) {
    const DesignSample* const start = known ? &evaluations_.get_samples().front() : nullptr;
    const auto size_of = [](double value) { return std::isfinite(value) && value != 0 ? std::abs(value) : 1.0; };
    for (std::size_t i = 0; i < problem_.objectives.size(); ++i)
      objective_scales_.push_back(size_of(start ? start->objectives[i] : 1));
    for (std::size_t i = 0; i < problem_.constraints.size(); ++i) {
      const double limit = problem_.constraints[i].limit;
      constraint_scales_.push_back(limit != 0 ? std::abs(limit) : size_of(start ? start->values[i] : 1));
    }
    shifts_.assign(problem_.constraints.size(), 0.0);
  }

  [[nodiscard]] bool has_catalogue() const {
    return std::any_of(problem_.variables.begin(), problem_.variables.end(),
                       [](const auto& v) { return v.is_catalogue(); });
  }
  [[nodiscard]] std::vector<std::size_t> list_continuous() const {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < problem_.variables.size(); ++i)
      if (!problem_.variables[i].is_catalogue()) list.push_back(i);
    return list;
  }

  void look() {
    const bool several = problem_.objectives.size() > 1;
    result_.method = several ? SearchMethod::kPareto : problem_.method;
    if (try_all()) return;
    if (several) return search_pareto();
    const bool automatic = problem_.method == SearchMethod::kAuto;
    if (problem_.method == SearchMethod::kGlobal || (automatic && has_catalogue())) return search_global();
    result_.method = SearchMethod::kLocal;
    search_local(get_start());
    if (automatic && !spent_ && !is_feasible(find_best())) search_global();
  }

  // Catalogues alone, all of their combinations within the budget.
  bool try_all() {
    if (!list_continuous().empty()) return false;
    double count = 1;
    for (const DesignVariable& variable : problem_.variables) count *= static_cast<double>(variable.catalogue.size());
    if (count > static_cast<double>(problem_.budget.runs)) return false;
    std::vector<DesignPoint> points{DesignPoint(problem_.variables.size(), 0.0)};
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      std::vector<DesignPoint> more;
      for (const DesignPoint& point : points)
        for (std::size_t k = 0; k < problem_.variables[i].catalogue.size(); ++k) {
          more.push_back(point);
          more.back()[i] = static_cast<double>(k);
        }
      points = std::move(more);
    }
    std::vector<std::int64_t> indices;
    for (std::size_t at = 0; at < points.size() && !spent_; at += 64) {
      const auto begin = points.begin() + static_cast<std::ptrdiff_t>(at);
      const std::vector<DesignPoint> batch(
          begin, points.begin() + static_cast<std::ptrdiff_t>(std::min(points.size(), at + 64)));
      spent_ = !evaluations_.evaluate(batch, indices);
    }
    if (result_.method == SearchMethod::kAuto) result_.method = SearchMethod::kGlobal;
    result_.exhaustive = !spent_;
    return true;
  }

  // The continuous variables around `from`, catalogues as they are there.
  void search_local(const DesignPoint& from) {
    const std::vector<std::size_t> list = list_continuous();
    if (list.empty() || spent_) return;
    ScaledProblem scaled = prepare(list, from);
    const auto search = find_function<LocalSearch>(kOptimizersModule, "unlatch_search_local");
    search(scaled);
    if (spent_ || is_feasible(find_best())) return;
    // Nothing meets all constraints yet: the least t that no violation exceeds, then the problem again from there.
    ScaledProblem least = prepare(list, from);
    least.variables = list.size() + 1;
    least.start.push_back(1);
    const auto evaluate = least.evaluate;
    least.evaluate = [&](const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples) {
      std::vector<std::vector<double>> real = points;
      for (std::vector<double>& point : real) point.pop_back();
      if (!evaluate(real, samples)) return false;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double t = points[i].back() - kLeastTarget;
        samples[i].objectives = {t};
        for (double& constraint : samples[i].constraints) constraint = constraint / kLargest - t;
      }
      return true;
    };
    search(least);
    if (spent_ || !is_feasible(find_best())) return;
    ScaledProblem again = prepare(list, evaluations_.get_samples()[find_best()].point);
    search(again);
  }

  void search_global() {
    result_.method = SearchMethod::kGlobal;
    const auto all = static_cast<double>(problem_.budget.runs);
    const bool polish = !list_continuous().empty();
    if (polish)
      evaluations_.set_limit(std::max(evaluations_.get_runs(), static_cast<std::int64_t>((1 - kForPolish) * all)));
    evolve("unlatch_search_global", 16 + 4 * problem_.variables.size());
    evaluations_.set_limit(problem_.budget.runs);
    if (!polish || evaluations_.was_stopped()) return;
    spent_ = false;
    search_local(evaluations_.get_samples()[find_best()].point);
  }

  void search_pareto() { evolve("unlatch_search_pareto", 40); }

  void evolve(const char* function, std::size_t population) {
    std::vector<std::size_t> list(problem_.variables.size());
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = i;
    ScaledProblem scaled = prepare(list, get_start());
    scaled.population = (population + 3) / 4 * 4;
    // Repeated points cost nothing, so that there may be more generations than the budget has runs for.
    scaled.generations = 2 * static_cast<std::size_t>(problem_.budget.runs) / scaled.population + 1;
    find_function<GlobalSearch>(kOptimizersModule, function)(scaled);
  }

  // x: 0 … 1 of the variables in `list`; the others as in `base`.
  ScaledProblem prepare(const std::vector<std::size_t>& list, const DesignPoint& base) {
    ScaledProblem scaled;
    scaled.variables = list.size();
    scaled.objectives = problem_.objectives.size();
    scaled.constraints = problem_.constraints.size();
    scaled.seed = problem_.seed;
    for (const std::size_t i : list) {
      const DesignVariable& variable = problem_.variables[i];
      scaled.start.push_back((base[i] - variable.lower) / (variable.upper - variable.lower));
    }
    scaled.evaluate = [this, list, base](const std::vector<std::vector<double>>& points,
                                         std::vector<ScaledSample>& samples) {
      std::vector<DesignPoint> real;
      for (const std::vector<double>& point : points) {
        real.push_back(base);
        for (std::size_t k = 0; k < list.size(); ++k)
          real.back()[list[k]] = place(problem_.variables[list[k]], point[k]);
      }
      std::vector<std::int64_t> indices;
      if (!evaluations_.evaluate(real, indices)) {
        spent_ = true;
        return false;
      }
      samples.clear();
      for (const std::int64_t index : indices)
        samples.push_back(scale(evaluations_.get_samples()[static_cast<std::size_t>(index)]));
      return true;
    };
    return scaled;
  }

  static double place(const DesignVariable& variable, double x) {
    if (!variable.is_catalogue())
      return std::clamp(variable.lower + x * (variable.upper - variable.lower), variable.lower, variable.upper);
    return std::min(std::floor(x * static_cast<double>(variable.catalogue.size())), variable.upper);
  }

  [[nodiscard]] ScaledSample scale(const DesignSample& sample) const {
    ScaledSample scaled;
    for (std::size_t i = 0; i < sample.objectives.size(); ++i) {
      const double value = sample.objectives[i] / objective_scales_[i];
      scaled.objectives.push_back(!std::isfinite(value) ? kNoResult : problem_.objectives[i].maximise ? -value : value);
    }
    for (std::size_t i = 0; i < sample.margins.size(); ++i) {
      const double value = kWithin + shifts_[i] - sample.margins[i] / constraint_scales_[i];
      scaled.constraints.push_back(std::isfinite(value) ? std::min(value, kNoResult) : kNoResult);
    }
    return scaled;
  }

  [[nodiscard]] Violation calc_violation(std::size_t index) const {
    const DesignSample& sample = evaluations_.get_samples()[index];
    Violation violation;
    for (std::size_t i = 0; i < sample.margins.size(); ++i) {
      const double size =
          std::isfinite(sample.margins[i]) ? std::max(0.0, -sample.margins[i] / constraint_scales_[i]) : kNoResult;
      if (size > violation.size) violation = {size, i};
    }
    for (const double objective : sample.objectives)
      if (!std::isfinite(objective)) violation.size = std::max(violation.size, kNoResult);
    return violation;
  }
  [[nodiscard]] bool is_feasible(std::size_t index) const { return calc_violation(index).size == 0; }

  // Of all samples so far: least violation, then the objective, then the first.
  [[nodiscard]] std::size_t find_best() const {
    std::size_t best = 0;
    const auto merit = [&](std::size_t i) {
      const double violation = calc_violation(i).size;
      return std::pair(violation, violation > 0 ? 0.0 : scale(evaluations_.get_samples()[i]).objectives[0]);
    };
    for (std::size_t i = 1; i < evaluations_.get_samples().size(); ++i)
      if (merit(i) < merit(best)) best = i;
    return best;
  }

  void take_best() {
    result_.best = find_best();
    result_.violation = calc_violation(result_.best);
    result_.feasible = result_.violation.size == 0;
    if (problem_.objectives.size() > 1 && result_.feasible) take_front();
  }

  // Samples that none dominates; the best is the one nearest to the corner of the least of each objective.
  void take_front() {
    const std::size_t n = problem_.objectives.size();
    std::vector<std::pair<std::vector<double>, std::size_t>> points;
    for (std::size_t i = 0; i < evaluations_.get_samples().size(); ++i)
      if (is_feasible(i)) points.emplace_back(scale(evaluations_.get_samples()[i]).objectives, i);
    std::sort(points.begin(), points.end());
    const auto dominates = [&](const std::vector<double>& a, const std::vector<double>& b) {
      for (std::size_t k = 0; k < n; ++k)
        if (a[k] > b[k]) return false;
      return true;  // equal ones: the first stays
    };
    std::vector<std::vector<double>> front;
    for (const auto& [objectives, index] : points) {
      if (std::any_of(front.begin(), front.end(), [&](const auto& other) { return dominates(other, objectives); }))
        continue;
      front.push_back(objectives);
      result_.front.push_back(index);
    }
    std::vector<double> least = front[0], most = front[0];
    for (const std::vector<double>& point : front)
      for (std::size_t k = 0; k < n; ++k) {
        least[k] = std::min(least[k], point[k]);
        most[k] = std::max(most[k], point[k]);
      }
    double nearest = INFINITY;
    for (std::size_t i = 0; i < front.size(); ++i) {
      double distance = 0;
      for (std::size_t k = 0; k < n; ++k)
        if (most[k] > least[k])
          distance +=
              (front[i][k] - least[k]) / (most[k] - least[k]) * ((front[i][k] - least[k]) / (most[k] - least[k]));
      if (distance < nearest) {
        nearest = distance;
        result_.best = result_.front[i];
      }
    }
  }

  // Differences around the best, and for each active constraint the optimum with its limit moved.
  void study() {
    evaluations_.set_limit(evaluations_.get_runs() + kStudyRuns);
    evaluations_.set_deadline(0);
    const DesignSample best = evaluations_.get_samples()[result_.best];
    result_.sensitivities.resize(problem_.variables.size());
    std::vector<DesignPoint> points;
    const std::vector<std::size_t> list = list_continuous();
    for (const std::size_t i : list)
      for (const double sign : {-1.0, 1.0}) {
        const DesignVariable& variable = problem_.variables[i];
        points.push_back(best.point);
        points.back()[i] = std::clamp(best.point[i] + sign * kSensitivity * (variable.upper - variable.lower),
                                      variable.lower, variable.upper);
      }
    std::vector<std::int64_t> indices;
    if (!evaluations_.evaluate(points, indices)) return;
    for (std::size_t k = 0; k < list.size(); ++k) {
      const auto& samples = evaluations_.get_samples();
      const DesignSample &a = samples[static_cast<std::size_t>(indices[2 * k])],
                         &b = samples[static_cast<std::size_t>(indices[2 * k + 1])];
      const double width = b.point[list[k]] - a.point[list[k]];
      for (std::size_t i = 0; i < a.objectives.size(); ++i)
        result_.sensitivities[list[k]].push_back((b.objectives[i] - a.objectives[i]) / width);
      for (std::size_t i = 0; i < a.values.size(); ++i)
        result_.sensitivities[list[k]].push_back((b.values[i] - a.values[i]) / width);
    }
    result_.constraints.resize(problem_.constraints.size());
    for (std::size_t i = 0; i < problem_.constraints.size(); ++i) {
      ConstraintStudy& study = result_.constraints[i];
      study.active = result_.feasible && best.margins[i] <= kActive * constraint_scales_[i];
      if (study.active && problem_.objectives.size() == 1 && !list.empty() && !problem_.constraints[i].both)
        study.shadow = calc_shadow(i, best);
    }
  }

  // Best of the optimum with the limit easier by kShift of its size, less this optimum.
  std::optional<double> calc_shadow(std::size_t constraint, const DesignSample& best) {
    shifts_[constraint] = -kShift;
    ScaledProblem scaled = prepare(list_continuous(), best.point);
    double found = scale(best).objectives[0];
    const auto evaluate = scaled.evaluate;
    scaled.evaluate = [&](const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples) {
      if (!evaluate(points, samples)) return false;
      for (const ScaledSample& sample : samples) {
        const bool met =
            std::all_of(sample.constraints.begin(), sample.constraints.end(), [](double c) { return c <= kWithin; });
        if (met) found = std::min(found, sample.objectives[0]);
      }
      return true;
    };
    find_function<LocalSearch>(kOptimizersModule, "unlatch_search_local")(scaled);
    shifts_[constraint] = 0;
    if (evaluations_.was_stopped()) return std::nullopt;
    const double change =
        (found - scale(best).objectives[0]) * objective_scales_[0] * (problem_.objectives[0].maximise ? -1 : 1);
    const double raised =
        kShift * constraint_scales_[constraint] * (problem_.constraints[constraint].at_least ? -1 : 1);
    return change / raised;
  }

  static constexpr double kLargest = 10;       // violation that t of search_local() covers
  static constexpr double kLeastTarget = 0.1;  // t may fall below 0, where all are met

  const DesignProblem& problem_;
  DesignEvaluations& evaluations_;
  DesignResult result_;
  std::vector<double> objective_scales_, constraint_scales_, shifts_;
  bool spent_ = false;
};

}  // namespace

DesignResult search_design(const DesignProblem& problem, DesignEvaluations& evaluations) {
  return Search(problem, evaluations).run();
}

}  // namespace unlatch::hil
