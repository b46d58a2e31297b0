// Findings on laws that forces read: corners, and intervals of time that the step passes over.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "hil/run/findings/finding_parts.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/table_exit.h"
#include "hil/scenario/base/index.h"
#include "unlatch/model.h"

namespace unlatch::hil {
namespace {

// The axis of a table that a law looks up over time alone, or kNone: the step of its last argument stands before it.
bool is_time(const Model& model, const LawStep& step) {
  if (step.kind != LawStep::Kind::kQuantity) return false;
  const unlatch::Quantity::Kind kind = model.quantities[at(step.subject)].kind;
  return kind == unlatch::Quantity::Kind::kTime || kind == unlatch::Quantity::Kind::kOnTime;
}

void judge_interval(const Table& table, double dt, std::vector<Finding>& findings) {
  const std::vector<double>& knots = table.axes.back().knots;
  double shortest = knots.back() - knots.front();
  for (std::size_t i = 1; i < knots.size(); ++i) shortest = std::min(shortest, knots[i] - knots[i - 1]);
  if (shortest < dt)
    findings.push_back({"step", quoted("table", table.name),
                        format("has an interval of %.4g s, less than a step of %.4g s", shortest, dt)});
}

// Laws of time alone are known beforehand: what the steps would pass over.
void add_passed_over(const Scenario& scenario, const Simulation& simulation, std::vector<Finding>& findings) {
  constexpr std::int64_t kMostTicks = 1000000;
  const Model& model = scenario.model;
  LawWatch watch(model, simulation.plan(), LawWatch::Laws::kOfTime);
  if (watch.is_empty()) return;
  std::vector<double> from(model.quantities.size()), to(model.quantities.size());
  const std::vector<double> commands(simulation.channels().begin(), simulation.channels().end());
  std::map<int, PassedOver> worst;
  const std::int64_t last = std::min(std::llround(scenario.until / scenario.dt), static_cast<long long>(kMostTicks));
  for (std::int64_t tick = 0; tick < last; ++tick) {
    const double begin = static_cast<double>(tick) * scenario.dt, end = static_cast<double>(tick + 1) * scenario.dt;
    std::ranges::fill(from, begin);
    std::ranges::fill(to, end);
    for (const PassedOver& passed : watch.update({begin, end, from, to}, commands)) {
      PassedOver& own = worst[passed.law];
      if (passed.error > own.error) own = passed;
    }
  }
  for (const auto& [law, passed] : worst)
    findings.push_back({"law", quoted("law", model.laws[at(law)].name), describe(model.laws[at(law)], passed)});
}

}  // namespace

void add_law_findings(const Scenario& scenario, const Simulation& simulation, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  add_passed_over(scenario, simulation, findings);
  const std::vector<bool> driving = list_driving_laws(model);
  std::set<int> judged;
  for (std::size_t i = 0; i < model.laws.size(); ++i) {
    if (!driving[i]) continue;
    const std::vector<LawStep>& steps = model.laws[i].steps;
    for (std::size_t k = 0; k < steps.size(); ++k) {
      if (steps[k].kind != LawStep::Kind::kTable) continue;
      const Table& table = model.tables[at(steps[k].subject)];
      const bool is_new = judged.insert(steps[k].subject).second;
      if (is_new && table.interpolation == Table::Interpolation::kLinear)
        findings.push_back({"corner", quoted("table", table.name),
                            "is linear, and forces read it: each knot that is passed is located within the step, which "
                            "costs two or three sub-steps; "
                            "`interpolation: smooth` has no corners"});
      if (is_new && k > 0 && table.axes.size() == 1 && is_time(model, steps[k - 1]))
        judge_interval(table, scenario.dt, findings);
    }
  }
}

}  // namespace unlatch::hil
