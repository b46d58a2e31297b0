// Search of an optimisation problem: choice of the method, its phases and their shares of the budget, the best of all
// samples. A seed gives the same samples in the same order, whatever the number of threads.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hil/study/optimize/merit.h"

namespace unlatch::hil {

struct ConstraintStudy {
  bool active = false;           // within a thousandth of its limit
  std::optional<double> shadow;  // change of the optimum for each unit of relaxation of its limit, SI
};

constexpr double kRoom = 0.03;  // relative to the limit

// A local search: the samples at which it began, and the best that it has found.
struct LocalResult {
  std::size_t first = 0, best = 0;
};

struct OptimizeResult {
  enum class End { kConverged, kBudget, kStopped };
  End end = End::kConverged;
  SearchMethod method = SearchMethod::kLocal;  // the method that was used
  bool exhaustive = false;                     // all combinations of the catalogues were tried
  bool late = false;                           // the search has used up the budget's seconds
  bool feasible = false;             // by the samples of the search, or by fresh ones where those alone deny it
  bool settled = false;              // no point meets all constraints: the search of the least violation has converged
  std::size_t best = 0;              // index of the optimum, or of the least violation
  Violation violation;               // violation of the best sample
  std::vector<std::size_t> against;  // constraints that are all near the largest violation: they limit it together
  std::vector<std::size_t> front;    // samples, by the first objective; for several objectives
  // Of the points of the front, by fresh samples, where a constraint has a probability; empty: not flown.
  std::vector<std::optional<DispersedCheck>> front_checks{};
  std::vector<LocalResult> searches;  // local searches, in their order
  std::int64_t flights = 0;  // dispersed samples by which the best was found; 0: no constraint has a probability
  std::optional<DispersedCheck> check;  // of the best, by fresh samples
  // Margins of the best at the wanted probabilities, by constraint: by the fresh samples, else by those of the search.
  std::vector<std::optional<DispersedMargin>> margins{};
  // Confirmed, but fresh samples leave more than kRoom of a limit that has ended the search: better designs may be
  // near.
  bool has_room = false;
  std::int64_t search_runs = 0;
  std::int64_t search_count = 1;  // searches one after the other, each with the budget's runs
  std::vector<ConstraintStudy> constraints;
  // [variable][objectives, then constraints]; empty for a catalogue. SI for each unit of the variable.
  std::vector<std::vector<double>> sensitivities;
  std::vector<std::vector<std::size_t>> slices;  // [variable]: samples that differ from the best in this variable alone
};

// Runs the search, checks probabilities by fresh samples, and makes the runs around the result (study.h) unless `study`
// is false. `found` is called with each result before fresh samples check it. Throws ModuleError if the libraries are
// not installed.
OptimizeResult search_optimum(
    const OptimizeProblem& problem, OptimizeEvaluations& evaluations, bool study = true,
    const std::function<void(const OptimizePoint&)>& found = [](const OptimizePoint&) {});

}  // namespace unlatch::hil
