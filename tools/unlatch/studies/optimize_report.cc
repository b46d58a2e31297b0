#include "tools/unlatch/studies/optimize_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "hil/study/statistics/statistics.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/unlatch/studies/optimize_verdict.h"

namespace unlatch::tools {
namespace {

using hil::Objective;
using hil::OptimizeConstraint;
using hil::OptimizeProblem;
using hil::OptimizeResult;
using hil::OptimizeSample;
using hil::OptimizeVariable;

void print_check(std::FILE* to, const OptimizeReport& report, std::size_t constraint) {
  constexpr const char* kVerdictTexts[] = {"met", "neither confirmed nor refuted", "NOT MET"};
  const auto& check = *find_check(report, constraint);
  const hil::DispersedCheck& all = *report.result.check;
  const std::string unresolved =
      all.unresolved > 0 ? format(", %lld unresolved", static_cast<long long>(all.unresolved)) : "";
  std::fprintf(to,
               "  %-16s %lld of %s fail%s: probability of failure %.4f to %.4f (95 %%), at most %.4g is allowed: %s\n",
               report.problem.constraints[constraint].name.c_str(), static_cast<long long>(check.failed),
               count(all.samples, "other sample").c_str(), unresolved.c_str(), check.bounds.low, check.bounds.high,
               get_allowed(report, constraint), kVerdictTexts[static_cast<std::size_t>(check.verdict)]);
}

void print_verification(std::FILE* to, const OptimizeReport& report) {
  const auto& [problem, evaluations, result, limits, verification] = report;
  constexpr const char* kInterrupted = "interrupted before its end, so nothing is verified; --resume goes on with it";
  if (verification.end == OptimizeVerification::End::kInterrupted)
    std::fprintf(to, "  verification: %s\n", kInterrupted);
  if (verification.end != OptimizeVerification::End::kDone) return;
  std::fprintf(to, "  patch.yaml run once more: %s, %s\n",
               verification.met ? "all constraints met" : "not all constraints met",
               verification.same_bits ? "same bits" : "OTHER BITS than in the search");
  if (verification.step_error)
    std::fprintf(to, "  at half the step of %.9g s: it is off by %.2g, %s\n", problem.tree->get_nominal().dt,
                 *verification.step_error,
                 is_beyond_tolerance(report) ? "MORE than the tolerance: make that smaller" : "within the tolerance");
  for (std::size_t i = 0; i < problem.constraints.size(); ++i)
    if (find_check(report, i) != nullptr) print_check(to, report, i);
  if (hil::has_probabilities(problem) && result.flights > problem.campaign->samples)
    std::fprintf(to, "  the samples of the search grew from %lld to %lld, until others agreed with its verdict\n",
                 static_cast<long long>(problem.campaign->samples), static_cast<long long>(result.flights));
  if (is_check_missing(report)) std::fprintf(to, "  check of the probabilities: %s\n", kInterrupted);
  if (hil::has_probabilities(problem) && problem.campaign->checks == 0)
    std::fprintf(to, "  no other samples have checked the probabilities (checks: 0)\n");
  if (result.feasible && is_any_open(report))
    std::fprintf(to,
                 "  undecided: other samples neither confirm nor refute the result: raise campaign.checks, "
                 "campaign.samples and campaign.most, or lower the probability\n");
  if (get_status(report) == "not-converged")
    std::fprintf(to,
                 "  not converged: by other samples the result keeps a distance to its limits that a better one would "
                 "not need: raise campaign.samples and campaign.most, or start from here\n");
  if (result.feasible && is_any_refuted(report))
    std::fprintf(
        to,
        "  the samples of the search were too few to decide: raise campaign.samples and campaign.most, or lower "
        "the probability\n");
}

// What fresh samples say of the points of a front: "; fresh samples: 20 confirmed, 2 open", or nothing.
std::string describe_front(const OptimizeReport& report) {
  std::map<std::string, std::size_t> counts;
  for (std::size_t place = 0; place < report.result.front.size(); ++place)
    if (const char* const verdict = find_front_verdict(report, place); verdict != nullptr) ++counts[verdict];
  std::string text;
  for (const auto& [verdict, number] : counts)
    text += (text.empty() ? "; fresh samples: " : ", ") + std::to_string(number) + " " + verdict;
  return text;
}

}  // namespace

void print_problem(std::FILE* to, const OptimizeProblem& problem) {
  std::fprintf(to, "%s: %s\n  scenario %s, method %s, seed %u, at most %s\n", problem.name.c_str(),
               problem.title.c_str(), problem.scenario.c_str(),
               hil::kSearchMethodNames[static_cast<std::size_t>(problem.method)].c_str(), problem.seed,
               count(problem.budget.runs, "run").c_str());
  print_heading(to, "Variables");
  for (const OptimizeVariable& variable : problem.variables) {
    const std::string range = variable.is_catalogue() ? count(variable.catalogue.size(), "value")
                                                      : hil::write_value(variable, variable.lower) + " to " +
                                                            hil::write_value(variable, variable.upper);
    std::string paths;
    for (const std::string& path : variable.paths) paths += (paths.empty() ? "" : ", ") + path;
    std::fprintf(to, "  %-16s %s, from %s: %s\n", variable.name.c_str(), range.c_str(),
                 hil::write_value(variable, variable.start).c_str(), paths.c_str());
  }
  print_heading(to, "Objectives");
  for (const Objective& objective : problem.objectives)
    std::fprintf(to, "  %s %s%s\n", get_sense(objective), objective.text.c_str(),
                 objective.unit.empty() ? "" : (", " + objective.unit).c_str());
  if (!problem.constraints.empty()) print_heading(to, "Constraints");
  const std::vector<double> limits = calc_limits(problem, get_start(problem));
  for (std::size_t i = 0; i < limits.size(); ++i)
    std::fprintf(to, "  %-16s %s\n", problem.constraints[i].name.c_str(),
                 describe_constraint(problem.constraints[i], limits[i]).c_str());
  std::fprintf(to, "\n%s is valid\n", problem.file.c_str());
}

void print_optimize_report(std::FILE* to, const OptimizeReport& report) {
  const auto& [problem, evaluations, result, limits, verification] = report;
  std::fprintf(
      to, "%s: %s, method %s, %s and %lld around the result\n", problem.name.c_str(), get_status(report).c_str(),
      result.exhaustive ? "all combinations" : hil::kSearchMethodNames[static_cast<std::size_t>(result.method)].c_str(),
      count(result.search_runs, "run").c_str(), static_cast<long long>(evaluations.get_runs() - result.search_runs));
  if (const std::string end = get_end(report); end == "seconds" || end == "runs")
    std::fprintf(
        to, "  ended by its budget of %s%s\n",
        end == "runs" ? (count(problem.budget.runs, "run") + " (budget.runs)").c_str()
                      : format("%g s (budget.seconds)", problem.budget.seconds).c_str(),
        end == "runs" && result.search_count > 1
            ? (", the last of " + count(result.search_count, "search") + ", each of which may make so many").c_str()
            : "");
  if (evaluations.get_samples().empty()) return;
  const OptimizeSample& best = evaluations.get_samples()[result.best];
  if (!result.feasible)
    std::fprintf(to, "  %s; least violation: %s\n", describe_failure(report).c_str(),
                 describe_violation(report).c_str());
  for (std::size_t i = 0; i < problem.variables.size(); ++i)
    std::fprintf(to, "  %-16s %s%s\n", problem.variables[i].name.c_str(),
                 hil::write_value(problem.variables[i], best.point[i]).c_str(),
                 !problem.variables[i].is_catalogue() && is_at_bound(problem.variables[i], best.point[i])
                     ? " (at its bound)"
                     : "");
  for (std::size_t i = 0; i < problem.objectives.size(); ++i)
    std::fprintf(to, "  %s %s: %s\n", get_sense(problem.objectives[i]), problem.objectives[i].text.c_str(),
                 std::isfinite(best.objectives[i])
                     ? format("%.9g %s", best.objectives[i], problem.objectives[i].unit.c_str()).c_str()
                     : "no value");
  for (std::size_t i = 0; i < problem.constraints.size(); ++i) {
    const bool active = !result.constraints.empty() && result.constraints[i].active;
    const bool met = is_met(report, i);
    if (!active && met) continue;
    const double value = get_value(report, i);
    std::fprintf(
        to, "  %-16s %s, %s", problem.constraints[i].name.c_str(),
        std::isfinite(value) ? format("%.6g %s", value, problem.constraints[i].unit.c_str()).c_str() : "no value",
        describe_constraint(problem.constraints[i], report.limits[i]).c_str());
    if (i < result.margins.size() && result.margins[i] && result.margins[i]->interval)
      std::fprintf(to, " (margin of the quantile %.4g to %.4g, 95 %%, by %s)", result.margins[i]->interval->low,
                   result.margins[i]->interval->high, result.check ? "other samples" : "the samples of the search");
    if (active && result.constraints[i].shadow)
      std::fprintf(to, "; active: %.6g of the objective for each unit of the limit", *result.constraints[i].shadow);
    if (const double part = best.demand.parts.empty() ? 0 : best.demand.parts[i];
        part > problem.constraints[i].probability && problem.constraints[i].probability > 0)
      std::fprintf(to, "; the search asked for %.4g of its samples, so that others confirm it", part);
    const bool missed = !(get_margin(report, i) >= 0) || is_any_refuted(report);
    std::fprintf(to, "%s\n", met ? "" : missed ? ": not met" : ": not confirmed");
  }
  if (problem.starts > 1) {
    std::string ends;
    for (const hil::LocalResult& search : result.searches) {
      const OptimizeSample& end = evaluations.get_samples()[search.best];
      ends += (ends.empty() ? "" : ", ") + (meets_all(end) ? format("%.6g", end.objectives[0]) : "not met");
    }
    std::fprintf(to, "  best of each local search: %s\n", ends.c_str());
  }
  if (!result.front.empty())
    std::fprintf(to, "  Pareto front: %s in front.csv%s\n", count(result.front.size(), "point").c_str(),
                 describe_front(report).c_str());
  print_verification(to, report);
}

std::string write_patch(const OptimizeProblem& problem, const hil::OptimizePoint& point) {
  const std::string file = std::filesystem::path(problem.scenario).filename().string();
  std::string text =
      "# Written by unlatch optimize: the scenario with the values that it found. It runs as it is.\nunlatch: "
      "1\ninclude: " +
      file + "\nname: " + problem.name + "\n";
  const std::size_t before = text.size();
  const auto add = [&](const std::string& setting) {
    if (text.size() == before) text += "set:\n";
    const std::size_t at = setting.find('=');
    text += "  \"" + setting.substr(0, at) + "\": " + setting.substr(at + 1) + "\n";
  };
  for (const std::string& setting : problem.overrides) add(setting);
  for (const hil::Setting& setting : hil::make_settings(problem, point)) add(to_text(setting));
  return text + "--- # included: " + file + "\n" + problem.tree->get_nominal().text;
}

std::string write_front(const OptimizeReport& report) {
  const OptimizeProblem& problem = report.problem;
  std::string text = "run";
  for (const OptimizeVariable& variable : problem.variables) text += "," + variable.name;
  for (const Objective& objective : problem.objectives) text += ",\"" + objective.text + "\"";
  if (find_front_verdict(report, 0) != nullptr) text += ",verdict";
  text += "\n";
  for (std::size_t place = 0; place < report.result.front.size(); ++place) {
    const std::size_t i = report.result.front[place];
    const OptimizeSample& sample = report.evaluations.get_samples()[i];
    text += std::to_string(i + 1);
    for (const double value : sample.point) text += "," + hil::to_text(value);
    for (const double value : sample.objectives) text += "," + hil::to_text(value);
    if (const char* const verdict = find_front_verdict(report, place); verdict != nullptr)
      text += std::string(",") + verdict;
    text += "\n";
  }
  return text;
}

}  // namespace unlatch::tools
