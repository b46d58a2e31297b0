// One search of an optimisation problem by one algorithm, from one start: optimizers_bench PROBLEM ALGORITHM START
// RUNS. Prints JSON: the number of runs, and [run, objectives...] of each design that meets all constraints and that
// none before it equals or exceeds in all objectives. START 1 is the file's; others are random within the bounds, and
// seed the algorithm. `local`, `global`, `pareto` and `auto` are those of `unlatch optimize`; others are algorithms of
// its libraries alone. Driven by bench/optimizers.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <string>

#include "hil/scenario/base/module.h"
#include "hil/study/optimize/scaled_space.h"
#include "hil/study/optimize/search.h"

namespace {

using namespace unlatch;

hil::OptimizePoint choose_start(const hil::OptimizeProblem& problem, std::uint32_t start) {
  std::mt19937_64 random(start);
  hil::OptimizePoint point;
  for (const hil::OptimizeVariable& variable : problem.variables) {
    const double part = static_cast<double>(random() >> 11U) * 0x1p-53;
    point.push_back(start == 1 ? variable.start : place(variable, part));
  }
  return point;
}

hil::ScaledProblem make_problem(const hil::OptimizeProblem& problem, hil::OptimizeEvaluations& evaluations,
                                const hil::OptimizeMerit& merit, const hil::OptimizePoint& from,
                                const std::vector<double>& shifts) {
  std::vector<std::size_t> all(problem.variables.size());
  std::iota(all.begin(), all.end(), 0U);
  hil::ScaledProblem scaled = make_scaled(problem, evaluations, merit, all, from, shifts);
  // Populations of `method: global` and `method: pareto`. Repeated points cost no run.
  scaled.population = problem.objectives.size() > 1 ? 40 : (16 + 4 * scaled.variables + 3) / 4 * 4;
  scaled.generations = 100 * static_cast<std::size_t>(problem.budget.runs) / scaled.population + 1;
  return scaled;
}

bool search(const std::string& algorithm, const hil::ScaledProblem& scaled) {
  const auto find = [](const char* name) { return hil::find_function<hil::NamedSearch>(hil::kOptimizersModule, name); };
  return find("unlatch_search_nlopt")(algorithm.c_str(), scaled) ||
         find("unlatch_search_pagmo")(algorithm.c_str(), scaled);
}

void print(const hil::OptimizeMerit& merit, const std::vector<hil::OptimizeSample>& samples) {
  std::printf("{\"runs\": %zu, \"best\": [", samples.size());
  std::vector<std::vector<double>> front;  // scaled, minimised
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!merit.is_feasible(samples[i])) continue;
    const std::vector<double> one = merit.scale(samples[i]).objectives;
    const auto is_as_good = [&](const std::vector<double>& other) {
      return std::ranges::equal(other, one, std::less_equal<>());
    };
    if (std::ranges::any_of(front, is_as_good)) continue;
    std::printf("%s[%zu", front.empty() ? "" : ", ", i + 1);
    for (const double objective : samples[i].objectives)
      std::printf(", %.*g", one.size() > 1 ? 7 : 12, objective);  // a front has many points
    std::printf("]");
    front.push_back(one);
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
  hil::OptimizeProblem problem = hil::load_optimize_problem(arguments[1]);
  const hil::OptimizePoint from = choose_start(problem, start);
  for (std::size_t i = 0; i < from.size(); ++i) problem.variables[i].start = from[i];
  problem.seed = start;
  problem.starts = 1;
  problem.budget.runs = std::strtoll(arguments[4], nullptr, 10);
  const std::atomic<bool> stop{false};
  hil::OptimizeEvaluations evaluations(problem, {}, stop);
  const auto method = std::ranges::find(hil::kSearchMethodNames, algorithm);
  if (method != hil::kSearchMethodNames.end()) {
    problem.method = static_cast<hil::SearchMethod>(method - hil::kSearchMethodNames.begin());
    search_optimum(problem, evaluations, false);
    print(hil::OptimizeMerit(problem, &evaluations.get_samples().front()), evaluations.get_samples());
    return 0;
  }
  std::vector<std::int64_t> first;
  evaluations.evaluate({from}, first);
  const hil::OptimizeMerit merit(problem, &evaluations.get_samples().front());
  const std::vector<double> none(problem.constraints.size(), 0.0);
  if (!search(algorithm, make_problem(problem, evaluations, merit, from, none))) {
    std::fprintf(stderr, "optimizers_bench: no algorithm %s\n", algorithm.c_str());
    return 2;
  }
  print(merit, evaluations.get_samples());
  return 0;
}
