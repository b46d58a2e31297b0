#include "kernel/compile/events.h"

#include <algorithm>

namespace unlatch {
namespace {

// Appends a guard in postfix order. Returns the number of values that its evaluation keeps at once.
std::int32_t compile_condition(const Model& model, const Condition& c, PlanDraft& plan) {
  std::int32_t depth = 1, subject = c.subject;
  for (std::size_t i = 0; i < c.parts.size(); ++i)
    depth = std::max(depth, static_cast<std::int32_t>(i) + compile_condition(model, c.parts[i], plan));
  if (!get_traits(c.kind).by_guards) {
    subject = add_quantity(get_quantity(model, c), plan);
    plan.quantities.back().guarded = true;
    plan.quantities.back().threshold = c.threshold;
  }
  plan.conditions.push_back(
      {c.kind, subject, c.axis, static_cast<std::int32_t>(c.parts.size()), c.threshold, c.below, kNone, {}});
  return depth;
}

bool is_elementary(const Condition& c) { return c.parts.empty(); }
// True of conditions that are true or false and cannot change within a sub-step: kAll reads them first. kEngaged is
// left out: it is read in its place.
bool is_switch(const Model& model, const Condition& c) {
  return c.kind != Condition::Kind::kQuantity && c.kind != Condition::Kind::kEngaged && is_elementary(c) &&
         get_traits(get_quantity(model, c).kind).holds;
}

}  // namespace

void compile_events(const Model& model, const DraftWithQuantities& draft) {
  PlanDraft& plan = draft.plan;
  for (const Event& event : model.events) {
    Condition when = event.when;
    const bool all = when.kind == Condition::Kind::kAll &&
                     std::all_of(when.parts.begin(), when.parts.end(), is_elementary) && !when.parts.empty();
    if (all)
      std::stable_partition(when.parts.begin(), when.parts.end(),
                            [&](const Condition& c) { return is_switch(model, c); });
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
        .timed = false,
    };
    for (const Action& action : event.then)
      if (action.kind == Action::Kind::kEngage) {
        out.engages = action.subject;
        out.engaged = action.value != 0 ? 1 : 0;
      }
    const std::int32_t place = static_cast<std::int32_t>(plan.events.size());
    if (event.repeat) plan.repeating_events.push_back(place);
    if (event.delay > 0 || out.by_time) plan.timed_events.push_back(place);
    plan.guard_depth = std::max(plan.guard_depth, compile_condition(model, when, plan));
    out.condition_count = static_cast<std::int32_t>(plan.conditions.size()) - out.first_condition;
    plan.actions.insert(plan.actions.end(), event.then.begin(), event.then.end());
    plan.events.push_back(out);
  }
}

bool has_commanded_guards(const PlanDraft& plan) {
  return std::ranges::any_of(plan.quantities, [](const PlanQuantity& quantity) {
    return quantity.guarded && (get_traits(quantity.kind).reads & kReadsInputs) != 0;
  });
}

}  // namespace unlatch
