#include "kernel/step/events.h"

#include <algorithm>
#include <cmath>

#include "kernel/dynamics/balance.h"
#include "kernel/dynamics/kinematics.h"
#include "kernel/dynamics/loads.h"
#include "kernel/step/guards.h"
#include "kernel/step/integrator.h"
#include "kernel/step/lane_state.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_due(const Plan& plan, std::size_t e, double now, const State& state, const Workspace& ws) {
  const double slack = kSameInstant * plan.options.dt;
  const EventState& event = state.events[e];
  if (event.phase == EventPhase::kPending) return event.due <= now + slack;
  if (event.phase != EventPhase::kArmed) return false;
  return ws.guards[e] >= -(plan.events[e].by_time ? slack : ws.tolerances[e]);
}

bool is_any_due(const Plan& plan, double now, const State& state, const Workspace& ws) {
  const double *guards = ws.guards.data(), *tolerances = ws.tolerances.data();
  for (const std::int32_t e : plan.timed_events)
    if (is_due(plan, at(e), now, state, ws)) return true;
  for (std::size_t e = 0; e < plan.events.size(); ++e)
    if (guards[e] >= -tolerances[e] && is_due(plan, e, now, state, ws)) return true;
  return false;
}

// Rows that the new mode adds hold from now on where they are.
void close_rows(const Plan& plan, State& state, const Workspace& ws, int joint, RowSet added) {
  JointState& memory = state.joints[at(joint)];
  const Vec3 displacement = get_joint_frame(plan, state, ws, joint).displacement;
  if (has_row(added, kX)) memory.offset.x = displacement.x;
  if (has_row(added, kY)) memory.offset.y = displacement.y;
  if (has_row(added, kZ)) memory.offset.z = displacement.z;
  if ((added & kRotationRows) != 0) memory.locked = calc_relative_attitude(plan, ws, joint);
}

// Returns the rows that the action adds.
RowSet apply(const Plan& plan, const Action& action, double now, State& state, const Workspace& ws) {
  switch (action.kind) {
    case Action::Kind::kSetMode: {
      const RowSet before = get_active_rows(plan, state, action.subject);
      state.joints[at(action.subject)].mode = action.mode;
      const RowSet added = get_active_rows(plan, state, action.subject) & static_cast<RowSet>(~before);
      if (added != 0) close_rows(plan, state, ws, action.subject, added);
      return added;
    }
    case Action::Kind::kSwitch:
    case Action::Kind::kRamp: {
      ElementState& element = state.elements[at(action.subject)];
      const double scale = calc_scale(element, now);
      if (scale == 0 && action.value != 0) element.switched_on = now;
      const bool ramp = action.kind == Action::Kind::kRamp;
      element = {element.switched_on, ramp ? scale : action.value, action.value, now, ramp ? action.duration : 0};
      return 0;
    }
    case Action::Kind::kRaise:
      state.signals[at(action.subject)] = action.value;
      return 0;
  }
  return 0;
}

// One round: marks the events that are due, then lets them act. Returns how many acted.
int act_once(const Plan& plan, double now, State& state, Workspace& ws, RowSet& added) {
  int count = 0;
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    ws.acting[e] = 0;
    if (!is_due(plan, e, now, state, ws)) continue;
    EventState& event = state.events[e];
    if (event.phase == EventPhase::kArmed && plan.events[e].delay > 0) {
      event = {EventPhase::kPending, now + plan.events[e].delay};
      continue;
    }
    event = {EventPhase::kSpent, 0};
    ws.acting[e] = 1;
  }
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    if (ws.acting[e] == 0) continue;
    ++count;
    if (at(ws.fired_count) < ws.fired.size()) ws.fired[at(ws.fired_count++)] = {static_cast<std::int32_t>(e), now};
    for (int i = 0; i < plan.events[e].action_count; ++i)
      added |= apply(plan, plan.actions[at(plan.events[e].first_action + i)], now, state, ws);
  }
  return count;
}

Balance difference(const Balance& a, const Balance& b) {
  return {a.momentum - b.momentum, a.angular_momentum - b.angular_momentum, a.kinetic - b.kinetic};
}

}  // namespace

double calc_next_due(const Plan& plan, const State& state, double now) noexcept {
  const double slack = kSameInstant * plan.options.dt;
  double next = HUGE_VAL;
  for (const std::int32_t e : plan.timed_events) {
    const PlanEvent& event = plan.events[at(e)];
    const EventState& now_is = state.events[at(e)];
    const double time = plan.conditions[at(event.first_condition)].threshold;
    if (now_is.phase == EventPhase::kPending)
      next = std::min(next, now_is.due);
    else if (now_is.phase == EventPhase::kArmed && event.by_time && time > now + slack)
      next = std::min(next, time);
  }
  return next;
}

StepStatus act(const Plan& plan, const Inputs& inputs, double now, State& state, Workspace& ws, int& node) noexcept {
  // Every event acts or becomes pending at most once, so there are at most twice as many rounds as events.
  for (std::size_t round = 0; round <= 2 * plan.events.size(); ++round) {
    if (!is_any_due(plan, now, state, ws)) return StepStatus::kOk;
    const Balance before = calc_balance(plan, state, ws);
    RowSet added = 0;
    const int count = act_once(plan, now, state, ws, added);
    if (count == 0) return StepStatus::kOk;

    Balance entitled{{0, 0, 0}, {0, 0, 0}, 0};
    load_modes(plan, state, ws);
    forget_sizes(ws);
    if (added != 0) {
      if (node = apply_impulse(plan, state, ws); node != kNone) return StepStatus::kSingular;
      entitled = calc_impulse_entitlement(plan, state, ws);
      update_rates(plan, ws);
    }
    if (at(ws.audit_count) < ws.audits.size())
      ws.audits[at(ws.audit_count++)] = {now, before, difference(calc_balance(plan, state, ws), before), entitled};
    if (node = evaluate_lanes(plan, inputs, state, now, ws); node != kNone) return StepStatus::kSingular;
    for (double& tolerance : ws.tolerances) tolerance = 0;
    update_guards(plan, inputs, state, now, ws, ws.guards);
  }
  return StepStatus::kTooManyEvents;
}

void rearm(const Plan& plan, State& state, const Workspace& ws) noexcept {
  for (const std::int32_t e : plan.repeating_events)
    if (state.events[at(e)].phase == EventPhase::kSpent && ws.guards[at(e)] < 0)
      state.events[at(e)].phase = EventPhase::kArmed;
}

}  // namespace unlatch
