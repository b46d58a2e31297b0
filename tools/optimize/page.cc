#include "tools/optimize/page.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/pages/embed.h"
#include "tools/pages/pages.h"

UNLATCH_EMBED_PAGE(unlatch_optimize_page);

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostRuns = 20'000;  // of a plot

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json to_list(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

Json build_variables(const hil::OptimizeProblem& problem) {
  Json list = Json::array();
  for (const hil::OptimizeVariable& variable : problem.variables) {
    Json one{{"name", variable.name},   {"unit", variable.unit},   {"lower", variable.lower},
             {"upper", variable.upper}, {"start", variable.start}, {"catalogue", Json::array()},
             {"paths", variable.paths}};
    if (variable.is_catalogue())
      for (std::size_t i = 0; i < variable.catalogue.size(); ++i)
        one["catalogue"].push_back(hil::write_value(variable, static_cast<double>(i)));
    list.push_back(std::move(one));
  }
  return list;
}

// The requirement limits the size of its quantity.
bool is_of_size(const hil::OptimizeProblem& problem, const hil::OptimizeConstraint& constraint) {
  const hil::Scenario& scenario = problem.tree->get_nominal();
  const auto at = find_requirement(scenario, constraint.id);
  return at && scenario.requirements[*at].take == hil::Requirement::Take::kPeak;
}

Json build_constraints(const hil::OptimizeProblem& problem) {
  Json list = Json::array();
  for (const hil::OptimizeConstraint& constraint : problem.constraints)
    list.push_back({{"name", constraint.name},
                    {"unit", constraint.unit},
                    {"at_least", constraint.at_least},
                    {"both", constraint.both},
                    {"of_size", is_of_size(problem, constraint)},
                    {"probability", constraint.probability}});
  return list;
}

Json build_runs(const hil::OptimizeEvaluations& evaluations, std::size_t count) {
  const std::size_t every = (count + kMostRuns - 1) / kMostRuns;
  Json list = Json::array();
  for (std::size_t i = 0; i < count; i += every) {
    const hil::OptimizeSample& sample = evaluations.get_samples()[i];
    list.push_back({{"run", i + 1},
                    {"point", to_list(sample.point)},
                    {"objectives", to_list(sample.objectives)},
                    {"values", to_list(sample.values)},
                    {"margins", to_list(sample.margins)}});
  }
  return list;
}

Json build_flight(const std::vector<OptimizeCurve>& curves) {
  Json list = Json::array();
  for (const OptimizeCurve& curve : curves)
    list.push_back({{"name", curve.name},
                    {"unit", curve.unit},
                    {"times", to_list(curve.times)},
                    {"values", to_list(curve.values)}});
  return list;
}

}  // namespace

std::string build_optimize_page(const OptimizePage& page) {
  const auto searched = static_cast<std::size_t>(page.result.search_runs);
  const Json data{{"title", page.problem.title},
                  {"result", page.summary},
                  {"manifest", page.manifest},
                  {"patch", page.patch},
                  {"variables", build_variables(page.problem)},
                  {"constraints", build_constraints(page.problem)},
                  {"runs", build_runs(page.evaluations, std::min(searched, page.evaluations.get_samples().size()))},
                  {"before", build_flight(page.before)},
                  {"after", build_flight(page.after)}};
  return build_page(UNLATCH_EMBEDDED_PAGE(unlatch_optimize_page), data);
}

}  // namespace unlatch::tools
