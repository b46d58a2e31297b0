#include "tools/unlatch/studies/optimize_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "hil/study/statistics/statistics.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

using hil::Objective;
using hil::OptimizeConstraint;
using hil::OptimizeProblem;
using hil::OptimizeResult;
using hil::OptimizeSample;
using hil::OptimizeVariable;
using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }
const char* get_sense(const Objective& objective) { return objective.maximise ? "maximise" : "minimise"; }

using Verdict = hil::DispersedCheck::Verdict;
constexpr const char* kCheckNames[] = {"confirmed", "open", "refuted"};

// Verdict of fresh samples on a constraint with a probability.
const hil::DispersedCheck::Constraint* find_check(const OptimizeReport& report, std::size_t constraint) {
  if (!(report.problem.constraints[constraint].probability > 0) || !report.result.check) return nullptr;
  return &report.result.check->constraints[constraint];
}

double get_allowed(const OptimizeReport& report, std::size_t constraint) {
  return 1 - report.problem.constraints[constraint].probability;
}

bool is_refuted(const OptimizeReport& report, std::size_t constraint) {
  const auto* const check = find_check(report, constraint);
  return check != nullptr && check->verdict == Verdict::kRefuted;
}

bool is_any_refuted(const OptimizeReport& report) {
  for (std::size_t i = 0; i < report.problem.constraints.size(); ++i)
    if (is_refuted(report, i)) return true;
  return false;
}

// The samples that the problem asks for as a check have not been flown to the end.
bool is_check_missing(const OptimizeReport& report) {
  return report.result.feasible && hil::has_probabilities(report.problem) && report.problem.campaign->checks > 0 &&
         !report.result.check;
}

bool is_finished(const OptimizeReport& report) {
  return report.verification.end == OptimizeVerification::End::kDone && !is_check_missing(report);
}

// The nearest point misses constraints with a probability alone, by the samples of the search, and other samples do not
// show that it misses them: the search had too few samples to say that nothing meets them.
bool is_undecided(const OptimizeReport& report) {
  const OptimizeResult& result = report.result;
  if (result.feasible || report.evaluations.get_samples().empty()) return false;
  const OptimizeSample& best = report.evaluations.get_samples()[result.best];
  bool misses = false;
  for (std::size_t i = 0; i < report.problem.constraints.size(); ++i) {
    if (best.margins.size() <= i || best.margins[i] >= 0) continue;
    if (!std::isfinite(best.margins[i]) || !(report.problem.constraints[i].probability > 0)) return false;
    if (is_refuted(report, i)) return false;
    misses = true;
  }
  return misses;
}

// The result is off by more than the problem's tolerance at the step of the search.
bool is_beyond_tolerance(const OptimizeReport& report) {
  return report.verification.step_error && *report.verification.step_error > report.problem.tolerance;
}

std::string get_status(const OptimizeReport& report) {
  const OptimizeResult& result = report.result;
  if (result.end == OptimizeResult::End::kStopped) return "interrupted";
  if (is_undecided(report)) return "undecided";
  if (!result.feasible) return result.settled ? "infeasible" : "not-found";
  if (is_any_refuted(report)) return "refuted";
  if (!is_finished(report) || !report.verification.met || !report.verification.same_bits || is_beyond_tolerance(report))
    return "unverified";
  return result.end == OptimizeResult::End::kBudget ? "budget" : "optimal";
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

Json build_variables(const OptimizeProblem& problem, const hil::OptimizePoint& point) {
  Json all = Json::object();
  for (std::size_t i = 0; i < problem.variables.size(); ++i) {
    const OptimizeVariable& variable = problem.variables[i];
    Json& one = all[variable.name];
    one["paths"] = variable.paths;
    if (variable.is_catalogue()) {
      one["entry"] = static_cast<std::int64_t>(point[i]);
      one["value"] = variable.numbers.empty() ? Json(hil::write_value(variable, point[i]))
                                              : Json(variable.numbers[static_cast<std::size_t>(point[i])]);
    } else {
      one["value"] = point[i];
      one["at_bound"] = is_at_bound(variable, point[i]);
    }
    one["unit"] = variable.unit;
  }
  return all;
}

Json build_sensitivities(const OptimizeReport& report) {
  Json all = Json::object();
  for (std::size_t i = 0; i < report.result.sensitivities.size(); ++i) {
    const std::vector<double>& row = report.result.sensitivities[i];
    if (row.empty()) continue;
    Json& one = all[report.problem.variables[i].name];
    std::size_t at = 0;
    for (const Objective& objective : report.problem.objectives) one[objective.text] = number(row[at++]);
    for (const OptimizeConstraint& constraint : report.problem.constraints) one[constraint.name] = number(row[at++]);
  }
  return all;
}

Json build_constraints(const OptimizeReport& report, const OptimizeSample& best) {
  Json all = Json::array();
  for (std::size_t i = 0; i < report.problem.constraints.size(); ++i) {
    const OptimizeConstraint& constraint = report.problem.constraints[i];
    Json one{{"id", constraint.name},
             {"unit", constraint.unit},
             {"value", number(best.values[i])},
             {"limit", report.limits[i]},
             {"margin", number(best.margins[i])},
             {"met", best.margins[i] >= 0 && !is_refuted(report, i)}};
    if (!report.result.constraints.empty()) {
      const hil::ConstraintStudy& study = report.result.constraints[i];
      one["active"] = study.active;
      if (study.shadow) one["shadow"] = number(*study.shadow);
    }
    if (constraint.probability > 0) {
      one["probability"] = constraint.probability;
      const auto& interval = i < report.result.intervals.size() ? report.result.intervals[i] : std::nullopt;
      one["margin_interval"] = interval ? Json{number(interval->low), number(interval->high)} : Json(nullptr);
    }
    all.push_back(one);
  }
  return all;
}

Json build_slices(const OptimizeReport& report) {
  Json all = Json::object();
  for (std::size_t i = 0; i < report.result.slices.size(); ++i)
    for (const std::size_t k : report.result.slices[i]) {
      const OptimizeSample& sample = report.evaluations.get_samples()[k];
      Json one{{"value", number(sample.point[i])}};
      for (const double value : sample.objectives) one["objectives"].push_back(number(value));
      one["margins"] = Json::array();
      for (const double value : sample.margins) one["margins"].push_back(number(value));
      all[report.problem.variables[i].name].push_back(one);
    }
  return all;
}

Json build_verification(const OptimizeReport& report) {
  const OptimizeVerification& verification = report.verification;
  Json json{{"finished", is_finished(report)}};
  if (verification.end != OptimizeVerification::End::kDone) return json;
  json["runs"] = 1;
  json["met"] = verification.met;
  json["same_bits"] = verification.same_bits;
  json["hash"] = to_hex(verification.hash);
  if (verification.step_error) json["step_error"] = *verification.step_error;
  for (std::size_t i = 0; i < report.problem.constraints.size(); ++i)
    if (const auto* const check = find_check(report, i))
      json["dispersed"].push_back({{"id", report.problem.constraints[i].name},
                                   {"samples", report.result.check->samples},
                                   {"failed", check->failed},
                                   {"unresolved", report.result.check->unresolved},
                                   {"probability", {check->bounds.low, check->bounds.high}},
                                   {"allowed", get_allowed(report, i)},
                                   {"verdict", kCheckNames[static_cast<std::size_t>(check->verdict)]}});
  return json;
}

// Reason for which no point is the result; `violation` follows.
std::string describe_failure(const OptimizeReport& report) {
  const std::string status = get_status(report);
  if (status == "interrupted") return "no point so far meets all constraints";
  if (status == "infeasible") return "no point meets all constraints";
  if (status == "undecided")
    return "the " + count(report.result.flights, "sample") +
           " of the search are too few to decide: by them the nearest point misses a probability, by " +
           (report.result.check ? count(report.result.check->samples, "other sample") + " it may have it"
                                : std::string("others nothing is known")) +
           "; raise campaign.samples and campaign.most";
  const hil::OptimizeBudget& budget = report.problem.budget;
  const bool by_runs = budget.seconds == 0 || report.result.search_runs >= budget.runs;
  return "no feasible point found within the budget of " +
         (by_runs ? count(budget.runs, "run") + ": raise budget.runs"
                  : format("%g s: raise budget.seconds", budget.seconds)) +
         ", or choose another start";
}

// Values of the violated constraint, and the limit that this point would meet; or what no run gives.
std::string describe_violation(const OptimizeReport& report) {
  const hil::Violation& violation = report.result.violation;
  const OptimizeSample& best = report.evaluations.get_samples()[report.result.best];
  if (violation.objective && best.status == hil::SampleStatus::kDone)
    return "no run that meets all constraints has a value of " + report.problem.objectives[*violation.objective].text;
  if (!violation.constraint || best.status != hil::SampleStatus::kDone)
    return "no run gives all of the results that the problem asks for: the nearest ended '" +
           hil::kSampleStatusNames[static_cast<std::size_t>(best.status)] + "'";
  const OptimizeConstraint& constraint = report.problem.constraints[*violation.constraint];
  const double value = best.values[*violation.constraint];
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

void print_check(std::FILE* to, const OptimizeReport& report, std::size_t constraint) {
  constexpr const char* kTold[] = {"met", "neither shown nor refuted; more `checks` narrow it", "NOT MET"};
  const auto& check = *find_check(report, constraint);
  const hil::DispersedCheck& all = *report.result.check;
  const std::string unresolved =
      all.unresolved > 0 ? format(", %lld unresolved", static_cast<long long>(all.unresolved)) : "";
  std::fprintf(to,
               "  %-16s %lld of %s fail%s: probability of failure %.4f to %.4f (95 %%), at most %.4g is allowed: %s\n",
               report.problem.constraints[constraint].name.c_str(), static_cast<long long>(check.failed),
               count(all.samples, "other sample").c_str(), unresolved.c_str(), check.bounds.low, check.bounds.high,
               get_allowed(report, constraint), kTold[static_cast<std::size_t>(check.verdict)]);
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
  if (is_any_refuted(report))
    std::fprintf(to,
                 "  the samples of the search were too few to decide: raise campaign.samples and campaign.most, or the "
                 "probability\n");
}

}  // namespace

bool is_verified(const OptimizeReport& report) {
  const std::string status = get_status(report);
  return status == "optimal" || status == "budget";
}

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

void write_problem_json(const OptimizeProblem& problem, const std::string& target) {
  Json json{{"schema", 1}, {"problem", problem.name}, {"scenario", problem.scenario}, {"status", "ok"}};
  json["variables"] = build_variables(problem, get_start(problem));
  for (const Objective& objective : problem.objectives)
    json["objectives"].push_back({{"sense", get_sense(objective)}, {"of", objective.text}, {"unit", objective.unit}});
  json["constraints"] = Json::array();
  for (const OptimizeConstraint& constraint : problem.constraints) json["constraints"].push_back(constraint.name);
  write_json(json, target);
}

Json build_optimize_json(const OptimizeReport& report) {
  const auto& [problem, evaluations, result, limits, verification] = report;
  Json json{{"schema", 1},
            {"problem", problem.name},
            {"scenario", problem.scenario},
            {"status", get_status(report)},
            {"method", hil::kSearchMethodNames[static_cast<std::size_t>(result.method)]},
            {"exhaustive", result.exhaustive},
            {"seed", problem.seed},
            {"samples", result.flights},
            {"runs", result.search_runs},
            {"study_runs", evaluations.get_runs() - result.search_runs}};
  if (evaluations.get_samples().empty()) return json;
  const OptimizeSample& best = evaluations.get_samples()[result.best];
  json["feasible"] = result.feasible && !is_any_refuted(report);
  json["run"] = result.best + 1;
  json["variables"] = build_variables(problem, best.point);
  for (std::size_t i = 0; i < problem.objectives.size(); ++i)
    json["objectives"].push_back({{"sense", get_sense(problem.objectives[i])},
                                  {"of", problem.objectives[i].text},
                                  {"value", number(best.objectives[i])},
                                  {"unit", problem.objectives[i].unit}});
  if (problem.step_search && problem.step_search->step)
    json["step"] = {{"tolerance", problem.tolerance},
                    {"step", *problem.step_search->step},
                    {"scenario_step", problem.step_search->given},
                    {"flights", problem.step_search->flights}};
  json["constraints"] = build_constraints(report, best);
  if (!result.feasible) {
    json["violation"] = {
        {"size", result.violation.size}, {"why", describe_failure(report)}, {"text", describe_violation(report)}};
    if (result.violation.constraint)
      json["violation"]["constraint"] = problem.constraints[*result.violation.constraint].name;
    if (result.violation.objective)
      json["violation"]["objective"] = problem.objectives[*result.violation.objective].text;
    for (const std::size_t i : result.against) json["violation"]["against"].push_back(problem.constraints[i].name);
  }
  for (const hil::LocalResult& search : result.searches) {
    const OptimizeSample& end = evaluations.get_samples()[search.best];
    json["searches"].push_back({{"run", search.first + 1},
                                {"best_run", search.best + 1},
                                {"objective", number(end.objectives[0])},
                                {"met", meets_all(end)}});
  }
  json["sensitivities"] = build_sensitivities(report);
  for (const std::size_t i : result.front)
    json["front"].push_back({{"run", i + 1},
                             {"point", evaluations.get_samples()[i].point},
                             {"objectives", evaluations.get_samples()[i].objectives}});
  json["slices"] = build_slices(report);
  json["verification"] = build_verification(report);
  return json;
}

void print_optimize_report(std::FILE* to, const OptimizeReport& report) {
  const auto& [problem, evaluations, result, limits, verification] = report;
  std::fprintf(
      to, "%s: %s, method %s, %s and %lld around the result\n", problem.name.c_str(), get_status(report).c_str(),
      result.exhaustive ? "all combinations" : hil::kSearchMethodNames[static_cast<std::size_t>(result.method)].c_str(),
      count(result.search_runs, "run").c_str(), static_cast<long long>(evaluations.get_runs() - result.search_runs));
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
    const bool met = best.margins[i] >= 0 && !is_refuted(report, i);
    if (!active && met) continue;
    std::fprintf(to, "  %-16s %.6g %s, %s", problem.constraints[i].name.c_str(), best.values[i],
                 problem.constraints[i].unit.c_str(),
                 describe_constraint(problem.constraints[i], report.limits[i]).c_str());
    if (i < result.intervals.size() && result.intervals[i])
      std::fprintf(to, " (margin of the quantile %.4g to %.4g, 95 %%)", result.intervals[i]->low,
                   result.intervals[i]->high);
    if (active && result.constraints[i].shadow)
      std::fprintf(to, "; active: %.6g of the objective for each unit of the limit", *result.constraints[i].shadow);
    std::fprintf(to, "%s\n", met ? "" : ": not met");
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
    std::fprintf(to, "  Pareto front: %s in front.csv\n", count(result.front.size(), "point").c_str());
  print_verification(to, report);
}

std::string write_patch(const OptimizeProblem& problem, const hil::OptimizePoint& point) {
  const std::string file = std::filesystem::path(problem.scenario).filename().string();
  std::string text =
      "# Written by unlatch optimize: the scenario with the values that it found. It runs as it is.\nunlatch: "
      "1\ninclude: " +
      file + "\nname: " + problem.name + "\nset:\n";
  const auto add = [&](const std::string& setting) {
    const std::size_t at = setting.find('=');
    text += "  \"" + setting.substr(0, at) + "\": " + setting.substr(at + 1) + "\n";
  };
  for (const std::string& setting : problem.overrides) add(setting);
  for (const hil::Setting& setting : hil::make_settings(problem, point)) add(to_text(setting));
  return text + "--- # included: " + file + "\n" + problem.tree->get_nominal().text;
}

std::string write_front(const OptimizeProblem& problem, const hil::OptimizeEvaluations& evaluations,
                        const OptimizeResult& result) {
  std::string text = "run";
  for (const OptimizeVariable& variable : problem.variables) text += "," + variable.name;
  for (const Objective& objective : problem.objectives) text += ",\"" + objective.text + "\"";
  text += "\n";
  for (const std::size_t i : result.front) {
    const OptimizeSample& sample = evaluations.get_samples()[i];
    text += std::to_string(i + 1);
    for (const double value : sample.point) text += "," + hil::to_text(value);
    for (const double value : sample.objectives) text += "," + hil::to_text(value);
    text += "\n";
  }
  return text;
}

}  // namespace unlatch::tools
