// One search of a problem of synthesis by one algorithm, from one start: optimizers_bench PROBLEM ALGORITHM START RUNS.
// Prints JSON: the number of runs, and [run, objective] at each improvement of the best design that meets all
// constraints. START 1 is the file's; others are random within the bounds, and seed the algorithm. `local` and `global`
// are those of `unlatch optimize`; others are algorithms of its libraries alone. Driven by bench/optimizers.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "hil/modules/module.h"
#include "hil/synthesis/scaled_space.h"
#include "hil/synthesis/search.h"

namespace {

using namespace unlatch;

hil::DesignPoint choose_start(const hil::DesignProblem& problem, std::uint32_t start) {
  std::mt19937_64 random(start);
  hil::DesignPoint point;
  for (const hil::DesignVariable& variable : problem.variables) {
    const double part = static_cast<double>(random() >> 11U) * 0x1p-53;
    point.push_back(start == 1 ? variable.start : variable.lower + part * (variable.upper - variable.lower));
  }
  return point;
}

hil::ScaledProblem make_problem(const hil::DesignProblem& problem, hil::DesignEvaluations& evaluations,
                                const hil::DesignMerit& merit, const hil::DesignPoint& from,
                                const std::vector<double>& shifts) {
  hil::ScaledProblem scaled = make_scaled(problem, evaluations, merit, list_continuous(problem), from, shifts);
  scaled.population = (16 + 4 * scaled.variables + 3) / 4 * 4;  // that of `method: global`
  scaled.generations = 100000;
  return scaled;
}

bool search(const std::string& algorithm, const hil::ScaledProblem& scaled) {
  const auto find = [](const char* name) { return hil::find_function<hil::NamedSearch>(hil::kOptimizersModule, name); };
  return find("unlatch_search_nlopt")(algorithm.c_str(), scaled) ||
         find("unlatch_search_pagmo")(algorithm.c_str(), scaled);
}

void print(const hil::DesignMerit& merit, const std::vector<hil::DesignSample>& samples, std::size_t runs) {
  std::printf("{\"runs\": %zu, \"best\": [", runs);
  bool first = true;
  double best = 0;
  for (std::size_t i = 0; i < runs; ++i) {
    if (!merit.is_feasible(samples[i]) || (!first && !(samples[i].objectives[0] < best))) continue;
    best = samples[i].objectives[0];
    std::printf("%s[%zu, %.12g]", first ? "" : ", ", i + 1, best);
    first = false;
  }
  std::printf("]}\n");
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 5) {
    std::fprintf(stderr, "usage: optimizers_bench PROBLEM ALGORITHM START RUNS\n");
    return 2;
  }
  const std::string algorithm = arguments[2];
  const auto start = static_cast<std::uint32_t>(std::strtoul(arguments[3], nullptr, 10));
  const std::int64_t runs = std::strtoll(arguments[4], nullptr, 10);
  hil::DesignProblem problem = hil::load_design_problem(arguments[1]);
  const hil::DesignPoint from = choose_start(problem, start);
  for (std::size_t i = 0; i < from.size(); ++i) problem.variables[i].start = from[i];
  problem.seed = start;
  problem.starts = 1;
  problem.budget.runs = runs;
  const std::atomic<bool> stop{false};
  hil::DesignEvaluations evaluations(problem, {}, stop);
  if (algorithm == "local" || algorithm == "global") {
    problem.method = algorithm == "local" ? hil::SearchMethod::kLocal : hil::SearchMethod::kGlobal;
    const hil::DesignResult result = search_design(problem, evaluations);
    const hil::DesignMerit merit(problem, &evaluations.get_samples().front());
    print(merit, evaluations.get_samples(), static_cast<std::size_t>(result.search_runs));
    return 0;
  }
  std::vector<std::int64_t> first;
  evaluations.evaluate({from}, first);
  const hil::DesignMerit merit(problem, &evaluations.get_samples().front());
  const std::vector<double> none(problem.constraints.size(), 0.0);
  if (!search(algorithm, make_problem(problem, evaluations, merit, from, none))) {
    std::fprintf(stderr, "optimizers_bench: no algorithm %s\n", algorithm.c_str());
    return 2;
  }
  print(merit, evaluations.get_samples(), evaluations.get_samples().size());
  return 0;
}
