#include "hil/study/optimize/problem/problem.h"

#include <algorithm>
#include <cmath>

#include "hil/run/run.h"
#include "hil/scenario/text/expression.h"
#include "hil/scenario/yaml/scenario_error.h"
#include "hil/study/campaign/samples/result_file.h"

namespace unlatch::hil {
namespace {

double get_number(const OptimizeVariable& variable, double value) {
  if (!variable.is_catalogue()) return value;
  return variable.numbers.empty() ? value : variable.numbers.at(static_cast<std::size_t>(value));
}

}  // namespace

const std::vector<std::string> kSearchMethodNames{"auto", "local", "global", "pareto"};

std::string write_value(const OptimizeVariable& variable, double value) {
  if (variable.is_catalogue())
    return to_text(Setting{"", variable.catalogue.at(static_cast<std::size_t>(value))}).substr(1);
  return to_text(value) + (variable.unit.empty() ? "" : " " + variable.unit);
}

OptimizePoint get_start(const OptimizeProblem& problem) {
  OptimizePoint start;
  for (const OptimizeVariable& variable : problem.variables) start.push_back(variable.start);
  return start;
}

std::vector<Setting> make_settings(const OptimizeProblem& problem, const OptimizePoint& point) {
  std::vector<Setting> settings;
  for (std::size_t i = 0; i < problem.variables.size(); ++i) {
    const OptimizeVariable& variable = problem.variables[i];
    const YamlNode value = variable.is_catalogue() ? variable.catalogue.at(static_cast<std::size_t>(point[i]))
                                                   : make_scalar(write_value(variable, point[i]));
    for (std::size_t k = 0; k < variable.paths.size(); ++k)
      if (std::ranges::find(problem.of_objectives, variable.paths[k]) == problem.of_objectives.end())
        settings.push_back({variable.paths[k], variable.columns.empty() ? value : value.items.at(variable.columns[k])});
  }
  return settings;
}

Campaign make_campaign(const OptimizeCampaign& campaign, const std::vector<Setting>& design,
                       const OptimizeFlights& flights) {
  std::vector<std::string> overrides = campaign.overrides;
  for (const Setting& setting : design) overrides.push_back(to_text(setting));
  Campaign made = load_campaign_text(campaign.text, campaign.file, campaign.folder, overrides);
  made.plan.samples = flights.samples;
  made.plan.seed += flights.stream;
  return made;
}

std::uint64_t calc_fingerprint(const OptimizeProblem& problem) {
  std::string all = UNLATCH_VERSION;
  const auto add = [&](const std::string& text) { (all += '\0') += text; };
  const auto add_scenario = [&](const Scenario& scenario) {
    add(scenario.text);
    for (const std::string& text : scenario.overrides) add(text);
    add(std::to_string(build_simulation(scenario)->get_model_hash()));  // includes the binary files that it names
  };
  add(problem.text);
  add_scenario(problem.tree->get_nominal());
  if (problem.campaign) {
    add(std::to_string(get_shape(*problem.campaign->nominal, *problem.campaign->evaluator).fingerprint));
    add_scenario(problem.campaign->nominal->tree->get_nominal());
  }
  return calc_digest(all);
}

double get_limit(const Requirement& requirement) {
  return std::isfinite(requirement.least) ? requirement.least : requirement.most;
}

std::vector<double> calc_limits(const OptimizeProblem& problem, const OptimizePoint& point) {
  std::vector<double> limits;
  for (const OptimizeConstraint& constraint : problem.constraints) limits.push_back(constraint.limit);
  const auto take = [&](const Scenario& scenario, bool dispersed) {
    for (std::size_t i = 0; i < limits.size(); ++i)
      for (const Requirement& requirement : scenario.requirements)
        if (requirement.id == problem.constraints[i].id && (problem.constraints[i].probability > 0) == dispersed)
          limits[i] = get_limit(requirement);
  };
  try {
    const std::vector<Setting> settings = make_settings(problem, point);
    take(problem.tree->read(settings), false);
    if (problem.campaign)
      take(make_campaign(*problem.campaign, settings, {problem.campaign->samples}).tree->get_nominal(), true);
  } catch (const ScenarioError&) {  // the design's run has reported it
  }
  return limits;
}

namespace {

Constants list_constants(const OptimizeProblem& problem, const OptimizePoint& point) {
  Constants constants;
  for (std::size_t i = 0; i < problem.variables.size(); ++i) {
    const OptimizeVariable& variable = problem.variables[i];
    if (!variable.is_catalogue() || !variable.numbers.empty())
      constants[variable.name] = {get_number(variable, point[i]), variable.dimension};
    for (std::size_t k = 0; k < variable.titles.size(); ++k)
      constants[variable.titles[k]] = variable.row_numbers.at(static_cast<std::size_t>(point[i]))[k];
  }
  return constants;
}

}  // namespace

Quantity calc_expression(const OptimizeProblem& problem, const Objective& objective, const OptimizePoint& point) {
  return evaluate_expression(objective.text, list_constants(problem, point));
}

// The expression is one without the name, too, if it does not read it.
bool reads_variable(const OptimizeProblem& problem, const std::string& text, const std::string& name) {
  if (problem.evaluator->find(text)) return false;
  const auto is_expression = [&](const Constants& constants) {
    try {
      (void)evaluate_expression(text, constants);
      return true;
    } catch (const ExpressionError&) {
      return false;
    }
  };
  Constants constants = list_constants(problem, get_start(problem));
  if (!is_expression(constants)) return true;  // a mistake of its own, which is reported
  constants.erase(name);
  return !is_expression(constants);
}

}  // namespace unlatch::hil
