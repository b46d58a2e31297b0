// The interface between a search and the libraries that do it, NLopt and pagmo, which are in a module of their own
// (hil/modules): slow to load, needed by `unlatch optimize` alone, and built only where they are installed.
//
// All is scaled: variables 0 … 1, a constraint c is met where c <= 0, objectives are minimised.
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
  double difference = 1e-4;  // of central differences, of a variable's range
  std::uint32_t seed = 1;
  std::size_t population = 0, generations = 0;
  // The samples of these points, in their order. False: the search must end now.
  std::function<bool(const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples)> evaluate;
};

// One optimum near the start: sequential quadratic programming (SLSQP; Kraft 1994), then a search without derivatives
// around what it found (COBYLA; Powell 1994). What they evaluated is what they give.
using LocalSearch = void(const ScaledProblem& problem);
// Over the whole box, one objective: an extended ant colony (GACO; Schlueter et al. 2009). Samples that miss
// constraints are ranked behind all others, by their largest violation (Deb 2000).
using GlobalSearch = void(const ScaledProblem& problem);
// Several objectives: NSGA-II (Deb et al. 2002), the same order of constraints.
using ParetoSearch = void(const ScaledProblem& problem);

// One algorithm alone, by its name: to measure them (bench/optimizers). False: there is none of that name.
using NamedSearch = bool(const char* algorithm, const ScaledProblem& problem);

constexpr const char* kOptimizersModule = "unlatch-optimizers";

}  // namespace unlatch::hil
