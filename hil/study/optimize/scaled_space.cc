#include "hil/study/optimize/scaled_space.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {
double place(const OptimizeVariable& variable, double x) {
  if (!variable.is_catalogue())
    return std::clamp(variable.lower + x * (variable.upper - variable.lower), variable.lower, variable.upper);
  return std::min(std::floor(x * static_cast<double>(variable.catalogue.size())), variable.upper);
}

std::vector<std::size_t> list_continuous(const OptimizeProblem& problem) {
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i < problem.variables.size(); ++i)
    if (!problem.variables[i].is_catalogue()) list.push_back(i);
  return list;
}

ScaledProblem make_scaled(const OptimizeProblem& problem, OptimizeEvaluations& evaluations, const OptimizeMerit& merit,
                          std::vector<std::size_t> list, OptimizePoint base, const std::vector<double>& shifts) {
  ScaledProblem scaled;
  scaled.variables = list.size();
  scaled.objectives = problem.objectives.size();
  scaled.constraints = problem.constraints.size();
  scaled.seed = problem.seed;
  for (const std::size_t i : list) {
    const OptimizeVariable& variable = problem.variables[i];
    scaled.start.push_back((base[i] - variable.lower) / (variable.upper - variable.lower));
  }
  scaled.evaluate = [&problem, &evaluations, &merit, &shifts, list = std::move(list), base = std::move(base)](
                        const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples) {
    std::vector<OptimizePoint> real;
    for (const std::vector<double>& point : points) {
      real.push_back(base);
      for (std::size_t k = 0; k < list.size(); ++k) real.back()[list[k]] = place(problem.variables[list[k]], point[k]);
    }
    std::vector<std::int64_t> indices;
    if (!evaluations.evaluate(real, indices)) return false;
    samples.clear();
    for (const std::int64_t index : indices)
      samples.push_back(merit.scale(evaluations.get_samples()[static_cast<std::size_t>(index)], shifts));
    return true;
  };
  return scaled;
}

}  // namespace unlatch::hil
