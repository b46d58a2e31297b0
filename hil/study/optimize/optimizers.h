// Interface between a search and its libraries, NLopt and pagmo. They are in a separate module (hil/scenario/base),
// because they are slow to load, only `unlatch optimize` needs them, and they are built only where they are installed.
//
// All values are scaled: variables 0 … 1, a constraint c is met if c <= 0, objectives are minimised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace unlatch::hil {

struct ScaledSample {
  std::vector<double> objectives, constraints;  // finite
};

struct ScaledProblem {
  std::size_t variables = 0, objectives = 1, constraints = 0;
  std::vector<double> start;
  double difference = 1e-4;  // step of central differences, relative to a variable's range
  std::uint32_t seed = 1;
  bool impatient = false;  // a local search ends where many samples have come no further
  std::size_t population = 0, generations = 0;
  // Samples of these points, in their order. False: the search must end now.
  std::function<bool(const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples)> evaluate;
};

// Finds one optimum near the start: sequential quadratic programming (SLSQP; Kraft 1994), then a search without
// derivatives around its result (COBYLA; Powell 1994). The result is in the evaluated points. True: it has converged.
using LocalSearch = bool(const ScaledProblem& problem);
// Searches the whole box for one objective: an extended ant colony (GACO; Schlueter et al. 2009). Samples that miss
// constraints rank behind all others, by their largest violation (Deb 2000).
using GlobalSearch = void(const ScaledProblem& problem);
// Searches for several objectives: NSGA-II (Deb et al. 2002), with the same ranking of constraints.
using ParetoSearch = void(const ScaledProblem& problem);

// Runs one algorithm alone, by its name, for measurements (bench/optimizers). False: no algorithm has that name.
using NamedSearch = bool(const char* algorithm, const ScaledProblem& problem);

constexpr const char* kOptimizersModule = "unlatch-optimizers";

}  // namespace unlatch::hil
