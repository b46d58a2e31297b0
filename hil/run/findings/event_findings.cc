#include <algorithm>

#include "hil/run/findings/finding_parts.h"
#include "hil/scenario/base/index.h"
#include "hil/scenario/earliest.h"

namespace unlatch::hil {
namespace {

// Name of an event in Scenario::marks.
std::string name_event(const Event& event) {
  return quoted("event", event.name) + (event.subject.empty() ? "" : " of '" + event.subject + "'");
}

bool has_kind(const Condition& c, Condition::Kind kind) {
  return c.kind == kind ||
         std::any_of(c.parts.begin(), c.parts.end(), [kind](const Condition& part) { return has_kind(part, kind); });
}
bool lies_before_start(const Condition& c) {
  if (c.kind == Condition::Kind::kTime) return !c.below && c.threshold < 0;
  return std::any_of(c.parts.begin(), c.parts.end(), lies_before_start);
}

}  // namespace

void add_event_findings(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  const EarliestTimes earliest(model);
  for (std::size_t e = 0; e < model.events.size(); ++e) {
    const Event& event = model.events[e];
    const std::string where = name_event(event);
    if (const std::string why = earliest.explain(e, scenario.until); !why.empty())
      findings.push_back({"never", where, why});
    if (lies_before_start(event.when)) findings.push_back({"start", where, "waits for a time before the start"});
  }
  // A trial step shows which guards are true already; only guards on time matter.
  Simulation trial(model, {.dt = scenario.dt}, scenario.rates);
  for (const FiredEvent& fired : trial.step().events) {
    const Event& event = model.events[at(fired.event)];
    if (fired.time > 0 || has_kind(event.when, Condition::Kind::kTime)) continue;
    const std::string where = name_event(event);
    findings.push_back({"start", where, "holds at the start already, and acts at t = 0"});
  }
}

}  // namespace unlatch::hil
