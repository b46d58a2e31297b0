// Findings on laws that forces read: corners, and intervals of time that the step passes over.
#include <algorithm>
#include <set>

#include "hil/run/findings/finding_parts.h"
#include "hil/run/notices/format.h"
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

}  // namespace

void add_law_findings(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
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
