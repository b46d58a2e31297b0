// The verdict on the result of an optimisation, and the words for it. No result is optimal unless its run, read anew,
// and fresh samples of each of its probabilities confirm it.
#pragma once

#include <string>

#include "tools/unlatch/studies/optimize_report.h"

namespace unlatch::tools {

// "optimal", "infeasible" …: the table of OPTIMIZE.md.
std::string get_status(const OptimizeReport& report);
// What ended the search: "convergence", "runs" or "seconds" of the budget, "interrupt".
std::string get_end(const OptimizeReport& report);

// Verdict of fresh samples on a constraint with a probability; null: it has none, or they were not flown to the end.
const hil::DispersedCheck::Constraint* find_check(const OptimizeReport& report, std::size_t constraint);
// Verdict of fresh samples on a point of the front: "confirmed", "open", "refuted"; "unverified": they were not flown;
// null: no constraint has a probability.
const char* find_front_verdict(const OptimizeReport& report, std::size_t place);
const char* get_name(hil::DispersedCheck::Verdict verdict);
double get_allowed(const OptimizeReport& report, std::size_t constraint);  // probability of failure

// Margin of a constraint at the result; with a probability that of the wanted one, by fresh samples, or by those of the
// search where no others were flown. NaN: there is none.
double get_margin(const OptimizeReport& report, std::size_t constraint);
// The value to which that margin belongs.
double get_value(const OptimizeReport& report, std::size_t constraint);

// The result meets the constraint; one with a probability if fresh samples confirm it.
bool is_met(const OptimizeReport& report, std::size_t constraint);
bool meets_all(const hil::OptimizeSample& sample);  // by the samples of the search
bool is_any_refuted(const OptimizeReport& report);
bool is_any_open(const OptimizeReport& report);
bool is_finished(const OptimizeReport& report);          // the verification
bool is_check_missing(const OptimizeReport& report);     // fresh samples were not flown to the end
bool is_beyond_tolerance(const OptimizeReport& report);  // at the step of the search

bool is_at_bound(const hil::OptimizeVariable& variable, double value);
const char* get_sense(const hil::Objective& objective);
std::string describe_constraint(const hil::OptimizeConstraint& constraint, double limit);
// Reason for which no point is the result; the violation follows.
std::string describe_failure(const OptimizeReport& report);
// Values of the violated constraint, and the limit that this point would meet; or what no run gives.
std::string describe_violation(const OptimizeReport& report);

}  // namespace unlatch::tools
