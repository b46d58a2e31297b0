// pagmo behind the interface of hil/study/optimize/optimizers.h.
#include <algorithm>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/gaco.hpp>
#include <pagmo/algorithms/ihs.hpp>
#include <pagmo/algorithms/maco.hpp>
#include <pagmo/algorithms/moead.hpp>
#include <pagmo/algorithms/nsga2.hpp>
#include <pagmo/algorithms/nspso.hpp>
#include <pagmo/algorithms/pso_gen.hpp>
#include <pagmo/algorithms/sade.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/batch_evaluators/member_bfe.hpp>
#include <pagmo/bfe.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <string>

#include "hil/study/optimize/optimizers.h"

namespace unlatch::hil {
namespace {

struct MustEnd {};

// Samples that miss a constraint rank behind all that meet them, by their largest violation.
constexpr double kBehind = 1e6;

pagmo::vector_double rank(const ScaledSample& sample) {
  double violation = 0;
  for (const double constraint : sample.constraints) violation = std::max(violation, constraint);
  if (violation <= 0) return sample.objectives;
  return pagmo::vector_double(sample.objectives.size(), kBehind * (1 + violation));
}

struct Box {
  const ScaledProblem* problem = nullptr;

  [[nodiscard]] pagmo::vector_double batch_fitness(const pagmo::vector_double& all) const {
    const std::size_t n = problem->variables;
    std::vector<std::vector<double>> points;
    for (std::size_t at = 0; at < all.size(); at += n)
      points.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at),
                          all.begin() + static_cast<std::ptrdiff_t>(at + n));
    std::vector<ScaledSample> samples;
    if (!problem->evaluate(points, samples)) throw MustEnd();
    pagmo::vector_double fitness;
    for (const ScaledSample& sample : samples) {
      const pagmo::vector_double ranked = rank(sample);
      fitness.insert(fitness.end(), ranked.begin(), ranked.end());
    }
    return fitness;
  }
  [[nodiscard]] pagmo::vector_double fitness(const pagmo::vector_double& point) const { return batch_fitness(point); }
  [[nodiscard]] std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    const std::size_t n = problem == nullptr ? 1 : problem->variables;
    return {pagmo::vector_double(n, 0.0), pagmo::vector_double(n, 1.0)};
  }
  [[nodiscard]] pagmo::vector_double::size_type get_nobj() const {
    return problem == nullptr ? 1 : problem->objectives;
  }
  template <typename Archive>
  void serialize(Archive&, unsigned) {}
};

template <typename Algorithm>
void evolve(const ScaledProblem& problem, const Algorithm& algorithm) {
  try {
    pagmo::population population(pagmo::problem(Box{&problem}), pagmo::bfe{pagmo::member_bfe{}}, problem.population,
                                 problem.seed);
    algorithm.evolve(population);
  } catch (const MustEnd&) {
  }
}

// Evolves with each generation as one batch.
template <typename Algorithm>
void evolve_in_batches(const ScaledProblem& problem, Algorithm algorithm) {
  algorithm.set_bfe(pagmo::bfe{pagmo::member_bfe{}});
  evolve(problem, algorithm);
}

}  // namespace

extern "C" void unlatch_search_global(const ScaledProblem& problem) {
  const auto kernel = static_cast<unsigned>(problem.population);
  evolve_in_batches(problem, pagmo::gaco(static_cast<unsigned>(problem.generations), kernel, 1.0, 0.0, 0.01, 1, 7,
                                         100000, 100000, 0.0, false, problem.seed));
}

extern "C" void unlatch_search_pareto(const ScaledProblem& problem) {
  evolve_in_batches(problem,
                    pagmo::nsga2(static_cast<unsigned>(problem.generations), 0.95, 10.0, 0.1, 50.0, problem.seed));
}

extern "C" bool unlatch_search_pagmo(const char* algorithm, const ScaledProblem& problem) {
  const std::string name = algorithm;
  const auto generations = static_cast<unsigned>(problem.generations);
  if (name == "gaco")
    unlatch_search_global(problem);
  else if (name == "nsga2")
    unlatch_search_pareto(problem);
  else if (name == "moead")
    evolve(problem, pagmo::moead(generations, "grid", "tchebycheff", 20, 1.0, 0.5, 20.0, 0.9, 2, true, problem.seed));
  else if (name == "nspso")
    evolve_in_batches(problem,
                      pagmo::nspso(generations, 0.6, 2.0, 2.0, 1.0, 0.5, 60, "crowding distance", false, problem.seed));
  else if (name == "maco")
    evolve_in_batches(problem, pagmo::maco(generations, static_cast<unsigned>(problem.population), 1.0, 1, 7, 100000,
                                           0.0, false, problem.seed));
  else if (name == "sga")
    evolve(problem,
           pagmo::sga(generations, 0.9, 1.0, 0.02, 1.0, 2, "exponential", "polynomial", "tournament", problem.seed));
  else if (name == "ihs")  // one point in each of its generations
    evolve(problem, pagmo::ihs(generations * static_cast<unsigned>(problem.population), 0.85, 0.35, 0.99, 1e-5, 1.0,
                               problem.seed));
  else if (name == "sade")
    evolve(problem, pagmo::sade(generations, 2, 1, 0.0, 0.0, false, problem.seed));
  else if (name == "cmaes")
    evolve(problem, pagmo::cmaes(generations, -1, -1, -1, -1, 0.5, 0.0, 0.0, false, true, problem.seed));
  else if (name == "pso")
    evolve_in_batches(problem, pagmo::pso_gen(generations, 0.7298, 2.05, 2.05, 0.5, 5, 2, 4, false, problem.seed));
  else
    return false;
  return true;
}

}  // namespace unlatch::hil
