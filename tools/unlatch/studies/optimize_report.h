// The result of `unlatch optimize`: for readers, as JSON, and as a scenario that runs as it is.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "hil/synthesis/search.h"

namespace unlatch::tools {

// The last run, of the file that is handed out, read anew.
struct DesignVerification {
  bool met = false;        // all constraints
  bool same_bits = false;  // as the sample of the search
  std::int64_t hash = 0;
  std::vector<std::int64_t> failures = {};  // of each constraint, of the campaign's other samples; empty: none flown
};

struct DesignReport {
  const hil::DesignProblem& problem;
  const hil::DesignEvaluations& evaluations;
  const hil::DesignResult& result;
  std::optional<DesignVerification> verification;
};

void print_problem(std::FILE* to, const hil::DesignProblem& problem);
void write_problem_json(const hil::DesignProblem& problem, const std::string& target);

void print_design(std::FILE* to, const DesignReport& report);
nlohmann::ordered_json build_design_json(const DesignReport& report);

// A scenario: the problem's `set` and the variables at this point, and the scenario's files within it.
std::string write_patch(const hil::DesignProblem& problem, const hil::DesignPoint& point);
std::string write_front(const hil::DesignProblem& problem, const hil::DesignEvaluations& evaluations,
                        const hil::DesignResult& result);  // CSV

}  // namespace unlatch::tools
