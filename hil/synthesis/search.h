// The search of a problem of synthesis: choice of the method, its phases and their shares of the budget, the best of
// all samples. The same samples in the same order for a seed, whatever the number of threads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/synthesis/merit.h"

namespace unlatch::hil {

struct ConstraintStudy {
  bool active = false;           // within a thousandth of its limit
  std::optional<double> shadow;  // change of the optimum for each unit by which the limit is raised, SI
};

struct DesignResult {
  enum class End { kConverged, kBudget, kStopped };
  End end = End::kConverged;
  SearchMethod method = SearchMethod::kLocal;  // the one that was used
  bool exhaustive = false;                     // all of the catalogues were tried
  bool feasible = false;
  std::size_t best = 0;  // sample: the optimum, or the least violation
  Violation violation;   // of that
  std::vector<std::size_t>
      against;                     // constraints that all miss by nearly the largest violation: they bound it together
  std::vector<std::size_t> front;  // samples, by the first objective; of several objectives
  std::int64_t search_runs = 0;
  std::vector<ConstraintStudy> constraints;
  // [variable][objectives, then constraints]; empty of a catalogue. SI for each unit of the variable.
  std::vector<std::vector<double>> sensitivities;
  std::vector<std::vector<std::size_t>> slices;  // [variable]: samples that differ from the best in it alone
};

// Throws ModuleError where the libraries are not installed.
DesignResult search_design(const DesignProblem& problem, DesignEvaluations& evaluations);

}  // namespace unlatch::hil
