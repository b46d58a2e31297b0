// The result of `unlatch optimize`: for readers, as JSON, and as a scenario that runs as it is.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "hil/study/optimize/search.h"

namespace unlatch::tools {

// The last run, of the file that is handed out, read anew.
struct OptimizeVerification {
  enum class End { kNotFlown, kInterrupted, kDone };
  End end = End::kNotFlown;
  bool met = false;        // all constraints of the nominal run
  bool same_bits = false;  // as the sample of the search
  std::int64_t hash = 0;
  std::optional<double> step_error = {};  // of a problem with a tolerance: of the result at its step, relative
};

struct OptimizeReport {
  const hil::OptimizeProblem& problem;
  const hil::OptimizeEvaluations& evaluations;
  const hil::OptimizeResult& result;
  std::vector<double> limits;  // of the constraints, at the result
  OptimizeVerification verification;
};

// Returns true if the result meets all constraints, and its verification has confirmed the search.
bool is_verified(const OptimizeReport& report);

void print_problem(std::FILE* to, const hil::OptimizeProblem& problem);
void write_problem_json(const hil::OptimizeProblem& problem, const nlohmann::ordered_json& warnings,
                        const std::string& target);

void print_optimize_report(std::FILE* to, const OptimizeReport& report);
nlohmann::ordered_json build_optimize_json(const OptimizeReport& report);

// A scenario: the problem's `set` and the variables at this point, and the scenario's files within it.
std::string write_patch(const hil::OptimizeProblem& problem, const hil::OptimizePoint& point);
std::string write_front(const OptimizeReport& report);  // CSV

}  // namespace unlatch::tools
