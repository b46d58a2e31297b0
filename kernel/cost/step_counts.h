// What a step has done beside its integrations, from the events before and after it and from its report: rounds in
// which events only began to wait, and rounds after which velocities may jump. No allocation: targets count, too.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "kernel/plan/plan_data.h"
#include "unlatch/step_data.h"

namespace unlatch::cost {

// The rows of all modes of a joint.
inline std::span<const RowSet> get_modes(const PlanData& plan, std::int32_t joint) {
  const std::int32_t first = plan.joints[at(joint)].first_mode;
  auto end = static_cast<std::int32_t>(plan.modes.size());
  for (const PlanJoint& other : plan.joints)
    if (other.first_mode > first && other.first_mode < end) end = other.first_mode;
  return std::span<const RowSet>(plan.modes).subspan(at(first), at(end - first));
}

// The mode that a joint has at the beginning of each round in which an event acts; kNone if it may be any.
inline std::int32_t get_required_mode(const PlanData& plan, const PlanEvent& event, std::int32_t joint) {
  if (event.delay > 0) return kNone;  // its condition was true earlier
  for (std::int32_t i = 0; i < event.flat_parts; ++i) {
    const PlanCondition& part = plan.conditions[at(event.first_condition + i)];
    if (part.kind == Condition::Kind::kMode && part.subject == joint) return part.axis;
  }
  return kNone;
}

// True if an action that sets a mode may add rows: that of an event which acts in one mode alone adds those that this
// mode lacks, or one that another action of the same round has set.
inline bool may_add_rows(const PlanData& plan, const PlanEvent& event, const Action& action) {
  const RowSet rows = plan.get_rows(action.subject, action.mode);
  const auto lacks = [&](RowSet other) { return (rows & ~other) != 0; };
  const std::int32_t required = get_required_mode(plan, event, action.subject);
  if (required == kNone) {
    for (const RowSet other : get_modes(plan, action.subject))
      if (lacks(other)) return true;
    return false;
  }
  if (lacks(plan.get_rows(action.subject, required))) return true;
  for (const PlanEvent& other : plan.events) {
    const std::int32_t own = get_required_mode(plan, other, action.subject);
    if (own != kNone && own != required) continue;
    for (std::int32_t i = 0; i < other.action_count; ++i) {
      const Action& earlier = plan.actions[at(other.first_action + i)];
      if (earlier.kind == Action::Kind::kSetMode && earlier.subject == action.subject &&
          lacks(plan.get_rows(earlier.subject, earlier.mode)))
        return true;
    }
  }
  return false;
}

// True if velocities may jump when the event acts.
inline bool may_jump(const PlanData& plan, const PlanEvent& event) {
  for (std::int32_t i = 0; i < event.action_count; ++i) {
    const Action& action = plan.actions[at(event.first_action + i)];
    if (action.kind == Action::Kind::kImpulse) return true;
    if (action.kind == Action::Kind::kSetMode && may_add_rows(plan, event, action)) return true;
  }
  return false;
}

// Rounds after which velocities may have jumped, at most.
inline std::int64_t count_jumps(const PlanData& plan, std::span<const FiredEvent> fired) {
  std::int64_t count = 0;
  for (const FiredEvent& own : fired) count += may_jump(plan, plan.events[at(own.event)]) ? 1 : 0;
  return count;
}

// Rounds in which events began to wait for their delays, at most: what began to wait has acted or waits still, and
// what waits since one time began together. `before`, `after`: State::events around the step.
inline std::int64_t count_waits(const PlanData& plan, std::span<const EventState> before,
                                std::span<const EventState> after, std::span<const FiredEvent> fired) {
  const auto waits = [](const EventState& own) { return own.phase == EventPhase::kPending; };
  const auto began = [&](std::size_t e) {
    return waits(after[e]) && !(waits(before[e]) && before[e].due == after[e].due);
  };
  const auto begins_with = [&](std::size_t a, std::size_t b) {
    return std::fabs((after[a].due - plan.events[a].delay) - (after[b].due - plan.events[b].delay)) <= plan.get_slack();
  };
  std::int64_t count = 0;
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    if (!(plan.events[e].delay > 0)) continue;
    std::int64_t own = (waits(after[e]) ? 1 : 0) - (waits(before[e]) ? 1 : 0);
    for (const FiredEvent& one : fired) own += at(one.event) == e ? 1 : 0;
    bool together = false;
    for (std::size_t other = 0; began(e) && other < e && !together; ++other)
      together = began(other) && begins_with(other, e);
    count += own - (together ? 1 : 0);
  }
  return count;
}

// Splits at known times, at most: delays that end, and events by time that act or begin to wait.
inline std::int64_t count_timed(const PlanData& plan, std::span<const FiredEvent> fired, std::int64_t waits) {
  std::int64_t count = 0;
  bool may_wait = false;
  for (const FiredEvent& own : fired) {
    const PlanEvent& event = plan.events[at(own.event)];
    count += event.by_time || event.delay > 0 ? 1 : 0;
  }
  for (const PlanEvent& event : plan.events) may_wait = may_wait || (event.by_time && event.delay > 0);
  return count + (may_wait ? waits : 0);
}

}  // namespace unlatch::cost
