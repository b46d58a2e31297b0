// The search of a problem of synthesis: scaling, choice of the method, the best of all samples, and what is known about
// it there. The same samples in the same order for a seed, whatever the number of threads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/synthesis/evaluations.h"

namespace unlatch::hil {

// Largest violation of a sample's constraints, each as a part of its limit: 0 if all are met.
struct Violation {
  double size = 0;
  std::size_t constraint = 0;  // the one
};

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
  std::size_t best = 0;            // sample: the optimum, or the least violation
  Violation violation;             // of that
  std::vector<std::size_t> front;  // samples, by the first objective; of several objectives
  std::int64_t search_runs = 0;
  std::vector<ConstraintStudy> constraints;
  // [variable][objectives, then constraints]; empty of a catalogue. SI for each unit of the variable.
  std::vector<std::vector<double>> sensitivities;
};

// Throws ModuleError where the libraries are not installed.
DesignResult search_design(const DesignProblem& problem, DesignEvaluations& evaluations);

}  // namespace unlatch::hil
