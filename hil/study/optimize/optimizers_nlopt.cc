// NLopt behind the interface of hil/study/optimize/optimizers.h.
#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <nlopt.hpp>
#include <string>

#include "hil/study/optimize/optimizers.h"

namespace unlatch::hil {
namespace {

constexpr double kTolerance = 1e-7;  // relative to a variable's range
constexpr int kMaxEvaluations = 2000;
constexpr std::size_t kStalled = 15;  // evaluations for each variable and one more, without progress
constexpr double kProgress = 1e-5;    // of the scaled violation or objective

// Values and derivatives at one point, by one batch: all differences of a gradient are computed together for all
// functions, by several threads. NLopt asks for the functions one after the other.
class Values {
 public:
  explicit Values(const ScaledProblem& problem) : problem_(problem) {}

  const ScaledSample& get(const std::vector<double>& x) {
    fetch({x});
    return known_.at(x);
  }

  // Derivatives by variable; differences at a bound are one-sided.
  const std::vector<ScaledSample>& get_derivatives(const std::vector<double>& x) {
    if (const auto found = derivatives_.find(x); found != derivatives_.end()) return found->second;
    std::vector<std::vector<double>> points{x};
    for (std::size_t i = 0; i < x.size(); ++i)
      for (const double sign : {-1.0, 1.0}) {
        points.push_back(x);
        points.back()[i] = std::clamp(x[i] + sign * problem_.difference, 0.0, 1.0);
      }
    fetch(points);
    std::vector<ScaledSample> derivatives(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::vector<double>&low = points[2 * i + 1], &high = points[2 * i + 2];
      const ScaledSample &a = known_.at(low), &b = known_.at(high);
      const double width = high[i] - low[i];
      for (std::size_t k = 0; k < a.objectives.size(); ++k)
        derivatives[i].objectives.push_back((b.objectives[k] - a.objectives[k]) / width);
      for (std::size_t k = 0; k < a.constraints.size(); ++k)
        derivatives[i].constraints.push_back((b.constraints[k] - a.constraints[k]) / width);
    }
    return derivatives_[x] = derivatives;
  }

  // Rethrows the problem's exception that ended the search, if there was one.
  void throw_if_failed() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  void fetch(const std::vector<std::vector<double>>& points) {
    std::vector<std::vector<double>> missing;
    for (const std::vector<double>& point : points) {
      if (!std::ranges::all_of(point, [](double x) { return std::isfinite(x); })) throw nlopt::roundoff_limited();
      if (known_.count(point) == 0 && std::find(missing.begin(), missing.end(), point) == missing.end())
        missing.push_back(point);
    }
    if (missing.empty()) return;
    std::vector<ScaledSample> samples;
    if (!evaluate(missing, samples)) throw nlopt::forced_stop();
    for (std::size_t i = 0; i < missing.size(); ++i) known_[missing[i]] = samples[i];
  }

  // Evaluates points and stores an exception: NLopt would mistake it for a lack of progress.
  bool evaluate(const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples) {
    try {
      return problem_.evaluate(points, samples);
    } catch (...) {
      error_ = std::current_exception();
      return false;
    }
  }

  const ScaledProblem& problem_;
  std::exception_ptr error_;
  std::map<std::vector<double>, ScaledSample> known_;
  std::map<std::vector<double>, std::vector<ScaledSample>> derivatives_;
};

// End of a search without derivatives that comes no further: COBYLA goes on around such a point for ever. As long as
// constraints are not met, their violation decides; then COBYLA ends by itself, unless the problem is impatient.
class Progress {
 public:
  explicit Progress(const ScaledProblem& problem)
      : impatient_(problem.impatient), patience_(kStalled * (problem.variables + 1)) {}

  // Returns false if too many samples have come no further.
  bool add(const ScaledSample& sample) {
    double violation = 0;
    for (const double constraint : sample.constraints) violation = std::max(violation, constraint);
    const double objective = sample.objectives[0];
    if (violation < violation_ - kProgress || (violation <= violation_ && objective < objective_ - kProgress)) {
      violation_ = violation;
      objective_ = objective;
      since_ = 0;
    }
    return (violation_ == 0 && !impatient_) || ++since_ <= patience_;
  }

 private:
  const bool impatient_;
  const std::size_t patience_;
  std::size_t since_ = 0;
  double violation_ = HUGE_VAL, objective_ = HUGE_VAL;  // of the best so far
};

struct Objective {
  Values* values;
  Progress* progress;  // null: the algorithm ends by itself
};

struct Constraint {
  Values* values;
  std::size_t index;
};

double calc_objective(const std::vector<double>& x, std::vector<double>& gradient, void* data) {
  const Objective& objective = *static_cast<const Objective*>(data);
  if (!gradient.empty())
    for (std::size_t i = 0; i < x.size(); ++i) gradient[i] = objective.values->get_derivatives(x)[i].objectives[0];
  const ScaledSample& sample = objective.values->get(x);
  if (objective.progress != nullptr && !objective.progress->add(sample)) throw nlopt::roundoff_limited();
  return sample.objectives[0];
}

double calc_constraint(const std::vector<double>& x, std::vector<double>& gradient, void* data) {
  const Constraint& constraint = *static_cast<const Constraint*>(data);
  if (!gradient.empty())
    for (std::size_t i = 0; i < x.size(); ++i)
      gradient[i] = constraint.values->get_derivatives(x)[i].constraints[constraint.index];
  return constraint.values->get(x).constraints[constraint.index];
}

enum class SearchEnd { kConverged, kTooLong, kMustEnd };

// Runs a search; `x` becomes its last point. Rethrows exceptions of the problem.
SearchEnd search(nlopt::algorithm algorithm, const ScaledProblem& problem, Values& values, double step,
                 Progress* progress, std::vector<double>& x) {
  nlopt::opt optimizer(algorithm, static_cast<unsigned>(problem.variables));
  optimizer.set_lower_bounds(0.0);
  optimizer.set_upper_bounds(1.0);
  Objective objective{&values, progress};
  optimizer.set_min_objective(calc_objective, &objective);
  std::vector<Constraint> constraints(problem.constraints);
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    constraints[i] = {&values, i};
    optimizer.add_inequality_constraint(calc_constraint, &constraints[i], 0);
  }
  optimizer.set_xtol_abs(kTolerance);
  optimizer.set_maxeval(kMaxEvaluations);
  if (step > 0) optimizer.set_initial_step(step);
  double value = 0;
  SearchEnd end = SearchEnd::kConverged;
  try {
    if (optimizer.optimize(x, value) == nlopt::MAXEVAL_REACHED) end = SearchEnd::kTooLong;
  } catch (const nlopt::forced_stop&) {
    values.throw_if_failed();
    return SearchEnd::kMustEnd;
  } catch (const nlopt::roundoff_limited&) {  // converged to rounding
  } catch (const std::runtime_error&) {       // NLOPT_FAILURE: no progress from here
  }
  for (double& coordinate : x) coordinate = std::clamp(coordinate, 0.0, 1.0);
  return end;
}

}  // namespace

extern "C" bool unlatch_search_local(const ScaledProblem& problem) {
  constexpr double kAround = 0.02;  // relative to the ranges: the first steps of the second search
  Values values(problem);
  std::vector<double> x = problem.start;
  if (search(nlopt::LD_SLSQP, problem, values, 0, nullptr, x) == SearchEnd::kMustEnd) return false;
  Progress progress(problem);
  return search(nlopt::LN_COBYLA, problem, values, kAround, &progress, x) == SearchEnd::kConverged;
}

extern "C" bool unlatch_search_nlopt(const char* algorithm, const ScaledProblem& problem) {
  const std::map<std::string, nlopt::algorithm> known{
      {"slsqp", nlopt::LD_SLSQP}, {"mma", nlopt::LD_MMA}, {"cobyla", nlopt::LN_COBYLA}, {"isres", nlopt::GN_ISRES}};
  const auto found = known.find(algorithm);
  if (found == known.end()) return false;
  nlopt::srand(problem.seed);
  Values values(problem);
  std::vector<double> x = problem.start;
  search(found->second, problem, values, 0, nullptr, x);
  return true;
}

}  // namespace unlatch::hil
