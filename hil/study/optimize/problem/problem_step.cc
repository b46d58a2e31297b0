#include "hil/study/optimize/problem/problem_step.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "hil/scenario/base/philox.h"
#include "hil/study/campaign/samples/campaign_step.h"
#include "hil/study/evaluation/step_settings.h"

namespace unlatch::hil {
namespace {

constexpr std::uint64_t kDesigns = 7;  // beside the start

JudgedValues list_judged(const OptimizeProblem& problem) {
  std::vector<std::size_t> columns;
  for (const Objective& objective : problem.objectives)
    if (objective.is_column) columns.push_back(objective.column);
  for (const OptimizeConstraint& constraint : problem.constraints)
    if (!(constraint.probability > 0)) columns.push_back(constraint.value);
  return JudgedValues(*problem.evaluator, columns);
}

OptimizePoint draw_design(const OptimizeProblem& problem, std::uint64_t number) {
  OptimizePoint point;
  for (const OptimizeVariable& variable : problem.variables) {
    const double u = draw_unit(0, RandomStream::kCorner, number, static_cast<std::uint32_t>(point.size()));
    if (variable.is_catalogue())
      point.push_back(std::floor(u * static_cast<double>(variable.catalogue.size())));
    else
      point.push_back(variable.lower + u * (variable.upper - variable.lower));
  }
  return point;
}

bool is_valid(const OptimizeProblem& problem, const std::vector<Setting>& settings) {
  try {
    (void)problem.tree->read(settings);
    return true;
  } catch (const ScenarioError&) {
    return false;
  }
}

std::vector<StepFlight> list_flights(const OptimizeProblem& problem) {
  std::vector<StepFlight> flights{{"the start", make_settings(problem, get_start(problem))}};
  for (std::uint64_t i = 0; i < kDesigns; ++i) {
    std::vector<Setting> settings = make_settings(problem, draw_design(problem, i));
    if (is_valid(problem, settings)) flights.push_back({"design " + std::to_string(i), std::move(settings)});
  }
  return flights;
}

void set_step(OptimizeProblem& problem, double step) {
  for (const Setting& setting : make_step_settings(problem.tree->get_nominal(), step))
    problem.overrides.push_back(to_text(setting));
  problem.tree = std::make_shared<ScenarioTree>(problem.scenario, problem.overrides);
  problem.evaluator = std::make_shared<SampleEvaluator>(*problem.tree);
  if (!problem.campaign) return;
  OptimizeCampaign& campaign = *problem.campaign;
  campaign.overrides = problem.overrides;
  campaign.nominal = std::make_shared<Campaign>(make_campaign(campaign, {}, {campaign.samples}));
  campaign.evaluator = std::make_shared<SampleEvaluator>(*campaign.nominal->tree);
}

}  // namespace

bool choose_step(OptimizeProblem& problem, int jobs, const std::atomic<bool>& stop) {
  if (!(problem.tolerance > 0)) return true;
  const std::vector<StepFlight> flights = list_flights(problem);
  StepSearch& search = problem.step_search.emplace(
      find_step(*problem.evaluator, list_judged(problem), flights, problem.tolerance, jobs, stop));
  if (problem.campaign && search.step) {
    StepSearch dispersed = search_step(*problem.campaign->nominal, problem.tolerance, jobs, stop);
    const std::optional<double> common = find_common_step(search, dispersed);
    dispersed.flights += search.flights;
    if (!common || (dispersed.step && *dispersed.step < *search.step)) search = std::move(dispersed);
    search.step = common;
  }
  if (!search.step) return false;
  set_step(problem, *search.step);
  return true;
}

std::optional<double> calc_step_error(const OptimizeProblem& problem, const OptimizePoint& point,
                                      const std::atomic<bool>& stop) {
  const std::optional<double> half = halve_step(problem.tree->get_nominal().dt);
  if (!half) return std::nullopt;
  std::vector<Setting> settings = make_settings(problem, point);
  const SampleResult coarse = problem.evaluator->evaluate(settings, stop);
  std::ranges::move(make_step_settings(problem.tree->get_nominal(), *half), std::back_inserter(settings));
  const SampleResult fine = problem.evaluator->evaluate(settings, stop);
  if (stop) return std::nullopt;
  return 2 * list_judged(problem).compare(coarse, fine).size;
}

}  // namespace unlatch::hil
