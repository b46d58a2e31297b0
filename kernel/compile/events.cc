#include "kernel/compile/events.h"

#include <algorithm>

namespace unlatch {
namespace {

// Appends a guard in postfix order; returns how many values its evaluation keeps at once.
std::int32_t compile_condition(const Condition& c, PlanData& plan) {
  std::int32_t depth = 1;
  for (std::size_t i = 0; i < c.parts.size(); ++i)
    depth = std::max(depth, static_cast<std::int32_t>(i) + compile_condition(c.parts[i], plan));
  plan.conditions.push_back(
      {c.kind, c.subject, c.axis, static_cast<std::int32_t>(c.parts.size()), c.threshold, c.below, kNone, {}});
  return depth;
}

bool is_elementary(const Condition& c) { return c.parts.empty(); }
// Conditions that hold or do not, and cannot change within a sub-step: a new one is added here, so that an `all` reads
// it first. kEngaged is not among them: it is read in its place.
bool is_switch(const Condition& c) {
  return c.kind == Condition::Kind::kMode || c.kind == Condition::Kind::kSignal || c.kind == Condition::Kind::kClosed;
}

}  // namespace

void compile_events(const Model& model, PlanData& plan) {
  for (const Event& event : model.events) {
    Condition when = event.when;
    const bool all = when.kind == Condition::Kind::kAll &&
                     std::all_of(when.parts.begin(), when.parts.end(), is_elementary) && !when.parts.empty();
    if (all) std::stable_partition(when.parts.begin(), when.parts.end(), is_switch);
    PlanEvent out{
        .first_condition = static_cast<std::int32_t>(plan.conditions.size()),
        .condition_count = 0,
        .first_action = static_cast<std::int32_t>(plan.actions.size()),
        .action_count = static_cast<std::int32_t>(event.then.size()),
        .flat_parts = all ? static_cast<std::int32_t>(when.parts.size()) : (is_elementary(when) ? 1 : 0),
        .delay = event.delay,
        .repeat = event.repeat,
        .engages = kNone,
        .engaged = 0,
        .by_time = when.kind == Condition::Kind::kTime && !when.below,
        .crossing = event.crossing,
    };
    for (const Action& action : event.then)
      if (action.kind == Action::Kind::kEngage) {
        out.engages = action.subject;
        out.engaged = action.value != 0 ? 1 : 0;
      }
    const std::int32_t place = static_cast<std::int32_t>(plan.events.size());
    if (event.repeat) plan.repeating_events.push_back(place);
    if (event.delay > 0 || out.by_time) plan.timed_events.push_back(place);
    plan.guard_depth = std::max(plan.guard_depth, compile_condition(when, plan));
    out.condition_count = static_cast<std::int32_t>(plan.conditions.size()) - out.first_condition;
    plan.actions.insert(plan.actions.end(), event.then.begin(), event.then.end());
    plan.events.push_back(out);
  }
}

// A new kind of condition that reads inputs is added here, or commands do not reach its guard at their tick.
bool has_commanded_guards(const PlanData& plan) {
  return std::ranges::any_of(plan.conditions,
                             [](const PlanCondition& c) { return c.kind == Condition::Kind::kCommand; });
}

}  // namespace unlatch
