#include "tools/unlatch/studies/optimize_verdict.h"

#include <algorithm>
#include <cmath>

#include "hil/study/optimize/confirmation.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

using hil::OptimizeConstraint;
using hil::OptimizeResult;
using hil::OptimizeSample;
using hil::OptimizeVariable;
using Verdict = hil::DispersedCheck::Verdict;

const OptimizeSample* find_best(const OptimizeReport& report) {
  const std::vector<OptimizeSample>& samples = report.evaluations.get_samples();
  return samples.empty() ? nullptr : &samples[report.result.best];
}

// A probability limits the nearest point, and other samples do not show that it misses it.
bool is_undecided(const OptimizeReport& report) {
  const OptimizeSample* const best = find_best(report);
  return best != nullptr && !report.result.feasible &&
         hil::misses_unconfirmed(report.problem, *best, report.result.against, report.result.check);
}

// The nearest point has no verdict: the step does not resolve its run, or so many of its samples that it has no
// quantile.
bool is_unresolved(const OptimizeReport& report) {
  const OptimizeSample* const best = find_best(report);
  if (best == nullptr || report.result.feasible) return false;
  if (best->status == hil::SampleStatus::kUnresolved) return true;
  if (!report.result.check || report.result.check->unresolved == 0) return false;
  for (std::size_t i = 0; i < best->margins.size(); ++i)
    if (report.problem.constraints[i].probability > 0 && std::isnan(best->margins[i])) return true;
  return false;
}

bool is_any(const OptimizeReport& report, Verdict verdict) {
  for (std::size_t i = 0; i < report.problem.constraints.size(); ++i)
    if (const auto* const check = find_check(report, i); check != nullptr && check->verdict == verdict) return true;
  return false;
}

// No samples beside those of the search judge the probabilities: the problem says so.
bool is_unchecked(const OptimizeReport& report) {
  return hil::has_probabilities(report.problem) && report.problem.campaign->checks == 0;
}

}  // namespace

const char* get_sense(const hil::Objective& objective) { return objective.maximise ? "maximise" : "minimise"; }

const hil::DispersedCheck::Constraint* find_check(const OptimizeReport& report, std::size_t constraint) {
  if (!(report.problem.constraints[constraint].probability > 0) || !report.result.check) return nullptr;
  return &report.result.check->constraints[constraint];
}

const char* get_name(Verdict verdict) {
  return verdict == Verdict::kConfirmed ? "confirmed" : verdict == Verdict::kOpen ? "open" : "refuted";
}

const char* find_front_verdict(const OptimizeReport& report, std::size_t place) {
  if (!hil::has_probabilities(report.problem)) return nullptr;
  const auto& checks = report.result.front_checks;
  if (place >= checks.size() || !checks[place]) return "unverified";
  for (const Verdict verdict : {Verdict::kRefuted, Verdict::kOpen})
    if (checks[place]->has(verdict)) return get_name(verdict);
  return get_name(Verdict::kConfirmed);
}

double get_allowed(const OptimizeReport& report, std::size_t constraint) {
  return 1 - report.problem.constraints[constraint].probability;
}

bool is_met(const OptimizeReport& report, std::size_t constraint) {
  const OptimizeSample* const best = find_best(report);
  if (best == nullptr) return false;
  if (!(report.problem.constraints[constraint].probability > 0)) return best->margins[constraint] >= 0;
  const auto* const check = find_check(report, constraint);
  return check != nullptr && check->verdict == Verdict::kConfirmed;
}

double get_margin(const OptimizeReport& report, std::size_t constraint) {
  const bool dispersed = report.problem.constraints[constraint].probability > 0;
  if (!dispersed) return find_best(report)->margins[constraint];
  const auto& margins = report.result.margins;
  if (constraint < margins.size() && margins[constraint]) return margins[constraint]->margin;
  // Interrupted: what the search has, if it asked for the wanted probability.
  const OptimizeSample& best = *find_best(report);
  const bool wanted = best.demand.parts[constraint] == report.problem.constraints[constraint].probability;
  return wanted ? best.margins[constraint] : std::nan("");
}

double get_value(const OptimizeReport& report, std::size_t constraint) {
  const OptimizeConstraint& own = report.problem.constraints[constraint];
  if (!(own.probability > 0)) return find_best(report)->values[constraint];
  const double margin = get_margin(report, constraint);
  return report.limits[constraint] + (own.at_least ? margin : -margin);
}

bool is_any_refuted(const OptimizeReport& report) { return is_any(report, Verdict::kRefuted); }
bool is_any_open(const OptimizeReport& report) { return is_any(report, Verdict::kOpen); }

bool is_check_missing(const OptimizeReport& report) {
  return report.result.feasible && hil::has_probabilities(report.problem) && report.problem.campaign->checks > 0 &&
         !report.result.check;
}

bool is_finished(const OptimizeReport& report) {
  return report.verification.end == OptimizeVerification::End::kDone && !is_check_missing(report);
}

bool is_beyond_tolerance(const OptimizeReport& report) {
  return report.verification.step_error && *report.verification.step_error > report.problem.tolerance;
}

std::string get_status(const OptimizeReport& report) {
  const OptimizeResult& result = report.result;
  if (result.end == OptimizeResult::End::kStopped) return "interrupted";
  if (is_unresolved(report)) return "unresolved";
  if (is_undecided(report)) return "undecided";
  if (!result.feasible) return result.settled ? "infeasible" : "not-found";
  if (is_any_refuted(report)) return "refuted";
  if (is_check_missing(report) || is_unchecked(report)) return "unverified";
  if (is_any_open(report)) return "undecided";
  if (!is_finished(report) || !report.verification.met || !report.verification.same_bits || is_beyond_tolerance(report))
    return "unverified";
  if (result.end == OptimizeResult::End::kBudget) return "budget";
  return result.has_room ? "not-converged" : "optimal";
}

std::string describe_constraint(const OptimizeConstraint& constraint, double limit) {
  if (constraint.both) return "within its two limits";
  const std::string text =
      format("%s %.6g %s", constraint.at_least ? "at least" : "at most", limit, constraint.unit.c_str());
  return constraint.probability > 0 ? text + format(" with probability %g", constraint.probability) : text;
}

bool meets_all(const OptimizeSample& sample) {
  return std::isfinite(sample.objectives[0]) &&
         std::ranges::all_of(sample.margins, [](double margin) { return margin >= 0; });
}

bool is_at_bound(const OptimizeVariable& variable, double value) {
  constexpr double kAt = 1e-6;  // of the range
  const double range = variable.upper - variable.lower;
  return value - variable.lower <= kAt * range || variable.upper - value <= kAt * range;
}

std::string get_end(const OptimizeReport& report) {
  if (report.result.end == OptimizeResult::End::kStopped) return "interrupt";
  if (report.result.late && get_status(report) != "optimal") return "seconds";
  return report.result.end == OptimizeResult::End::kBudget ? "runs" : "convergence";
}

std::string describe_failure(const OptimizeReport& report) {
  const std::string status = get_status(report);
  if (status == "interrupted") return "no point so far meets all constraints";
  if (status == "infeasible") return "no point meets all constraints";
  if (status == "unresolved")
    return "the step does not resolve the nearest point, which neither meets nor misses the constraints: make step.dt "
           "smaller";
  if (status == "undecided")
    return "the " + count(report.result.flights, "sample") +
           " of the search are too few to decide: by them the nearest point misses a probability, by " +
           (report.result.check ? count(report.result.check->samples, "other sample") + " it may have it"
                                : std::string("others nothing is known")) +
           "; raise campaign.samples and campaign.most";
  const hil::OptimizeBudget& budget = report.problem.budget;
  return "no feasible point found within the budget of " +
         (!report.result.late ? count(budget.runs, "run") + ": raise budget.runs"
                              : format("%g s: raise budget.seconds", budget.seconds)) +
         ", or choose another start";
}

std::string describe_violation(const OptimizeReport& report) {
  const hil::Violation& violation = report.result.violation;
  const OptimizeSample& best = report.evaluations.get_samples()[report.result.best];
  if (violation.objective && best.status == hil::SampleStatus::kDone)
    return "no run that meets all constraints has a value of " + report.problem.objectives[*violation.objective].text;
  if (!violation.constraint || best.status != hil::SampleStatus::kDone)
    return "no run gives all of the results that the problem asks for: the nearest ended '" +
           hil::kSampleStatusNames[static_cast<std::size_t>(best.status)] + "'";
  const OptimizeConstraint& constraint = report.problem.constraints[*violation.constraint];
  const double value = get_value(report, *violation.constraint);
  std::string text =
      constraint.name + " must be " + describe_constraint(constraint, report.limits[*violation.constraint]) + "; ";
  text += std::isfinite(value) ? format("the best that was found is %.6g %s", value, constraint.unit.c_str())
                               : "no run has a value of it";
  for (const std::size_t i : report.result.against)
    if (i != violation.constraint) text += ", against " + report.problem.constraints[i].name;
  std::string bounds;
  for (std::size_t i = 0; i < report.problem.variables.size(); ++i)
    if (!report.problem.variables[i].is_catalogue() && is_at_bound(report.problem.variables[i], best.point[i]))
      bounds += (bounds.empty() ? "" : ", ") + report.problem.variables[i].name;
  return bounds.empty() ? text : text + "; at their bounds: " + bounds;
}

bool is_verified(const OptimizeReport& report) {
  const std::string status = get_status(report);
  return status == "optimal" || status == "budget" || status == "not-converged";
}

}  // namespace unlatch::tools
