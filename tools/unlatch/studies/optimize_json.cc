#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/unlatch/studies/optimize_verdict.h"

namespace unlatch::tools {
namespace {

using hil::Objective;
using hil::OptimizeConstraint;
using hil::OptimizeProblem;
using hil::OptimizeSample;
using hil::OptimizeVariable;
using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

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
             {"value", number(get_value(report, i))},
             {"limit", report.limits[i]},
             {"margin", number(get_margin(report, i))},
             {"met", is_met(report, i)}};
    if (!report.result.constraints.empty()) {
      const hil::ConstraintStudy& study = report.result.constraints[i];
      one["active"] = study.active;
      if (study.shadow) one["shadow"] = number(*study.shadow);
    }
    if (constraint.probability > 0) {
      one["probability"] = constraint.probability;
      one["part"] = best.demand.parts[i];
      one["search_margin"] = number(best.margins[i]);
      const auto* const check = find_check(report, i);
      one["verdict"] = check != nullptr ? Json(get_name(check->verdict)) : Json(nullptr);
      const auto interval = i < report.result.margins.size() && report.result.margins[i]
                                ? report.result.margins[i]->interval
                                : std::nullopt;
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

// What fresh samples say of a constraint with a probability.
Json build_check(const OptimizeReport& report, std::size_t constraint, const hil::DispersedCheck& check) {
  const hil::DispersedCheck::Constraint& own = check.constraints[constraint];
  return {{"id", report.problem.constraints[constraint].name},
          {"samples", check.samples},
          {"failed", own.failed},
          {"unresolved", check.unresolved},
          {"probability", {own.bounds.low, own.bounds.high}},
          {"allowed", get_allowed(report, constraint)},
          {"verdict", get_name(own.verdict)}};
}

Json build_front(const OptimizeReport& report) {
  Json front = Json::array();
  for (std::size_t place = 0; place < report.result.front.size(); ++place) {
    const std::size_t i = report.result.front[place];
    const OptimizeSample& sample = report.evaluations.get_samples()[i];
    Json point{{"run", i + 1}, {"point", sample.point}, {"objectives", sample.objectives}};
    if (const char* const verdict = find_front_verdict(report, place); verdict != nullptr) point["verdict"] = verdict;
    if (place < report.result.front_checks.size() && report.result.front_checks[place])
      for (std::size_t k = 0; k < report.problem.constraints.size(); ++k)
        if (report.problem.constraints[k].probability > 0)
          point["dispersed"].push_back(build_check(report, k, *report.result.front_checks[place]));
    front.push_back(std::move(point));
  }
  return front;
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
    if (find_check(report, i) != nullptr) json["dispersed"].push_back(build_check(report, i, *report.result.check));
  return json;
}

}  // namespace

void write_problem_json(const OptimizeProblem& problem, const Json& warnings, const std::string& target) {
  Json json{{"schema", 1}, {"problem", problem.name}, {"scenario", problem.scenario}, {"status", "ok"}};
  json["variables"] = build_variables(problem, get_start(problem));
  for (const Objective& objective : problem.objectives)
    json["objectives"].push_back({{"sense", get_sense(objective)}, {"of", objective.text}, {"unit", objective.unit}});
  json["constraints"] = Json::array();
  for (const OptimizeConstraint& constraint : problem.constraints) json["constraints"].push_back(constraint.name);
  json["warnings"] = warnings;
  write_json(json, target);
}

Json build_optimize_json(const OptimizeReport& report) {
  const auto& [problem, evaluations, result, limits, verification] = report;
  Json json{{"schema", 1},
            {"problem", problem.name},
            {"scenario", problem.scenario},
            {"status", get_status(report)},
            {"ended_by", get_end(report)},
            {"method", hil::kSearchMethodNames[static_cast<std::size_t>(result.method)]},
            {"exhaustive", result.exhaustive},
            {"seed", problem.seed},
            {"samples", result.flights},
            {"runs", result.search_runs},
            {"study_runs", evaluations.get_runs() - result.search_runs}};
  if (evaluations.get_samples().empty()) return json;
  const OptimizeSample& best = evaluations.get_samples()[result.best];
  bool all = result.feasible;
  for (std::size_t i = 0; i < problem.constraints.size(); ++i) all = all && is_met(report, i);
  json["feasible"] = all;
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
  if (!result.front.empty()) json["front"] = build_front(report);
  json["slices"] = build_slices(report);
  json["verification"] = build_verification(report);
  return json;
}

}  // namespace unlatch::tools
