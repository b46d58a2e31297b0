#include "kernel/events/events.h"

#include <algorithm>
#include <cmath>

#include "kernel/dynamics/balance.h"
#include "kernel/dynamics/energy.h"
#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/elements/kinds/load.h"
#include "kernel/elements/kinds/one_sided/one_sided.h"
#include "kernel/events/guards.h"
#include "kernel/events/impulses.h"
#include "kernel/events/limits.h"
#include "kernel/events/rigid_pairs.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/load_state.h"
#include "kernel/joints/kinematics.h"
#include "kernel/quantities/quantities.h"

namespace unlatch {
namespace {

bool is_due(const PlanData& plan, std::size_t e, double now, const State& state, const Evaluation& ev,
            std::span<const double> tolerances) {
  const double slack = plan.get_slack();
  const EventState& event = state.events[e];
  if (event.phase == EventPhase::kPending) return event.due <= now + slack;
  if (event.phase != EventPhase::kArmed) return false;
  return ev.guards[e] >= -(plan.events[e].by_time ? slack : tolerances[e]);
}

bool is_any_due(const PlanData& plan, double now, const State& state, const Evaluation& ev,
                std::span<const double> tolerances) {
  const double* guards = ev.guards.data();
  for (const std::int32_t e : plan.timed_events)
    if (is_due(plan, at(e), now, state, ev, tolerances)) return true;
  for (std::size_t e = 0; e < plan.events.size(); ++e)
    if (guards[e] >= -tolerances[e] && is_due(plan, e, now, state, ev, tolerances)) return true;
  for (std::size_t i = plan.events.size(); i < ev.guards.size(); ++i)
    if (guards[i] >= -tolerances[i]) return true;
  return false;
}

// Closes and opens the pairs of shapes of compliant contacts that are due; returns their number. The present distance,
// which the search leaves next to zero, must be on the right side of the one at which the pair changes back.
int change_pairs(const PlanData& plan, State& state, const Evaluation& ev, std::span<const double> tolerances) {
  constexpr double kApart = 1e-12;  // m
  int count = 0;
  const std::span<const double> guards = get_pair_guards(plan, ev.guards), below = get_pair_guards(plan, tolerances);
  for (std::size_t i = 0; i < state.contacts.size(); ++i) {
    if (!(guards[i] >= -below[i]) || plan.contacts[at(plan.contact_pairs[i].contact)].rigid) continue;
    ContactState& pair = state.contacts[i];
    if (pair.closed != 0)
      pair = {0, std::min(0.0, (pair.edge + guards[i]) - kApart)};
    else
      pair = {1, std::max(0.0, (pair.edge - guards[i]) + kApart)};
    ++count;
  }
  return count;
}

// The rows that the new mode adds hold from now on at their present displacement and attitude.
void close_rows(const PlanData& plan, State& state, const Evaluation& ev, int joint, RowSet added) {
  JointState& memory = state.joints[at(joint)];
  const Vec3 displacement = JointView(plan, ev, joint).get_displacement();
  if (has_row(added, kX)) memory.offset.x = displacement.x;
  if (has_row(added, kY)) memory.offset.y = displacement.y;
  if (has_row(added, kZ)) memory.offset.z = displacement.z;
  if ((added & kRotationRows) != 0) memory.locked = calc_relative_attitude(plan, ev, joint);
}

// Returns the rows that the action adds.
RowSet apply(const PlanData& plan, const Action& action, double now, State& state, const Evaluation& ev) {
  switch (action.kind) {
    case Action::Kind::kSetMode: {
      const RowSet before = get_active_rows(plan, state, action.subject);
      state.joints[at(action.subject)].mode = action.mode;
      const RowSet added = get_active_rows(plan, state, action.subject) & static_cast<RowSet>(~before);
      if (added != 0) close_rows(plan, state, ev, action.subject, added);
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
    case Action::Kind::kEngage:
      state.engaged[at(action.subject)] = action.value != 0 ? 1 : 0;
      return 0;
    case Action::Kind::kImpulse:
      return 0;  // impulses of a round act together, after it
  }
  return 0;
}

// One round: closes and opens pairs of shapes, marks the events that are due, then executes them. Returns their number,
// or kFailedTouch. `added`: the number of rows that their actions add.
int act_once(Run& run, double now, std::size_t round, std::span<const double> tolerances, RowSet& added) {
  const PlanData& plan = run.plan;
  State& state = run.state();
  const Evaluation& ev = run.ev();
  EventSearch& search = run.search();
  EventRecord& events = run.events();
  const int rigid = change_rigid_pairs(run, now, round, tolerances);
  if (rigid == kFailedTouch) return kFailedTouch;
  const int changes = change_pairs(plan, state, ev, tolerances) + rigid;
  events.change_count += changes;
  int count = changes;
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    search.acting[e] = 0;
    if (!is_due(plan, e, now, state, ev, tolerances)) continue;
    EventState& event = state.events[e];
    if (event.phase == EventPhase::kArmed && plan.events[e].delay > 0) {
      event = {EventPhase::kPending, now + plan.events[e].delay};
      continue;
    }
    event = {EventPhase::kSpent, plan.events[e].timed ? now : 0};
    search.acting[e] = 1;
  }
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    if (search.acting[e] == 0) continue;
    ++count;
    if (at(events.fired_count) < events.fired.size())
      events.fired[at(events.fired_count++)] = {static_cast<std::int32_t>(e), now};
    for (int i = 0; i < plan.events[e].action_count; ++i)
      added |= apply(plan, plan.actions[at(plan.events[e].first_action + i)], now, state, ev);
  }
  return count;
}

Balance difference(const Balance& a, const Balance& b) {
  return {a.momentum - b.momentum, a.angular_momentum - b.angular_momentum, a.kinetic - b.kinetic};
}

// Applies the impulse that closes added rows and, if the round has `struck`, the impulses of actions. `allowed`: the
// change that these may make. False if a pivot vanished.
bool strike(Run& run, bool struck, Balance& allowed) {
  const PlanData& plan = run.plan;
  Evaluation& ev = run.ev();
  Balance strikes{{0, 0, 0}, {0, 0, 0}, 0};
  Source source = Source::kNothing;
  if (struck) {
    strikes = calc_impulses(plan, run.inputs, run.search().acting, ev);
    source = set_impulses(plan, run.inputs, run.search().acting, ev);
  }
  if (run.node = apply_impulse(plan, source, run.state(), ev); run.node != kNone) return false;
  allowed = calc_allowed_change(plan, run.state(), ev);
  update_velocities(plan, ev);  // w_W of markers; other bodies have theirs
  if (!struck) return true;
  allowed.momentum += strikes.momentum;
  allowed.angular_momentum += strikes.angular_momentum;
  allowed.kinetic += strikes.kinetic + calc_impulses(plan, run.inputs, run.search().acting, ev).kinetic;
  return true;
}

std::size_t count_rigid_rounds(const PlanData& plan) {
  return at(calc_rigid_rounds(plan.rigid_pairs, (count_rigid_rows(plan) - plan.rigid_pairs) / 2));
}

// Logs the state behind a round. `first`: of the instant.
void log_round(Run& run, double now, bool first, bool decisive) {
  RoundKnot* round = run.log->get_last_round();
  const bool shares = !first && !decisive && round != nullptr && !round->decisive;
  if (!shares) round = run.log->add_round();
  if (round == nullptr) return;
  update_readings(run.get_instant(now), run.ev(), run.data.unread.data());
  fill_knot(run, now, round->knot);
  round->fired = at(run.events().fired_count);
  round->decisive = decisive;
}

// All rounds at one instant at which something is due. Out of line: at most instants nothing is.
[[gnu::noinline]] StepStatus act_in_rounds(Run& run, double now, std::span<const double> tolerances) {
  const PlanData& plan = run.plan;
  const State& state = run.state();
  Evaluation& ev = run.ev();
  EventRecord& events = run.events();
  // An event acts or becomes pending at most once. A pair of shapes changes at most twice: by itself, and because its
  // contact was switched. So there are at most twice as many rounds as events and pairs.
  // Rigid contacts may take several pivots each.
  begin_rigid_pairs(run);
  for (std::size_t round = 0; round <= 2 * ev.guards.size() + count_rigid_rounds(plan); ++round) {
    if (round > 0 && !is_any_due(plan, now, state, ev, tolerances) && !wants_rigid_pair(run)) return StepStatus::kOk;
    const Balance before = calc_balance(plan, state, ev);
    const EnergyFlow flow_before = calc_energy_flow(plan, state, now, ev, {0, 0, 0});
    const std::int32_t fired = events.fired_count;
    RowSet added = 0;
    const int count = act_once(run, now, round, tolerances, added);
    if (count == 0) return StepStatus::kOk;
    if (count == kFailedTouch) return StepStatus::kRigidContact;
    load_modes(plan, state, ev);
    Balance allowed{{0, 0, 0}, {0, 0, 0}, 0};
    const bool struck = has_impulses(plan, run.search().acting);
    const bool jumped = added != 0 || struck;
    if (jumped && !strike(run, struck, allowed)) return StepStatus::kSingular;
    const bool blow = has_rigid_impulse(run, jumped);
    if (blow) {
      if (run.node = strike_rigid_pairs(run, now, allowed); run.node != kNone) return StepStatus::kSingular;
    } else if (run.node = stop_rigid_slips(run, now, allowed); run.node != kNone) {
      return StepStatus::kSingular;
    }
    const Balance jump = difference(calc_balance(plan, state, ev), before);
    const Instant instant = run.get_instant(now);
    if (run.node = evaluate(instant, Changed::kModes, ev); run.node != kNone) return StepStatus::kSingular;
    if (at(events.audit_count) < events.audits.size())
      events.audits[at(events.audit_count++)] = {
          now, before, jump, allowed, flow_before, calc_energy_flow(plan, state, now, ev, {0, 0, 0})};
    tolerances = run.data.exact;
    update_guards(instant, ev, run.search().stack);
    store_rigid_forces(plan, ev, run.state());
    if (blow) rearm(plan, run.state(), ev);  // a bounce has a touch and a lift at one instant
    if (run.log != nullptr) log_round(run, now, round == 0, jumped || blow || events.fired_count != fired);
  }
  return ev.rigid.failed == kNone ? StepStatus::kTooManyEvents : StepStatus::kRigidContact;
}

// A repeating event is armed once its guard is negative. Of the two events that engage and disengage a one-sided force,
// each is armed once the other has acted, also where the motion turned back there and left its guard above zero.
bool may_arm(const PlanData& plan, const State& state, const Evaluation& ev, std::int32_t e) {
  const PlanEvent& event = plan.events[at(e)];
  if (event.engages == kNone) return ev.guards[at(e)] < 0;
  if (state.engaged[at(event.engages)] == event.engaged) return false;
  if (ev.guards[at(e)] < 0) return true;
  const double rate = calc_motion(plan, state, ev, plan.one_sided[at(event.engages)]).depth_rate;
  return event.engaged != 0 ? rate > 0 : rate < 0;
}

}  // namespace

double calc_next_due(const PlanData& plan, const State& state, double now) noexcept {
  const double slack = plan.get_slack();
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

StepStatus act(Run& run, double now, std::span<const double> tolerances) noexcept {
  return is_any_due(run.plan, now, run.state(), run.ev(), tolerances) ? act_in_rounds(run, now, tolerances)
                                                                      : StepStatus::kOk;
}

void rearm(const PlanData& plan, State& state, Evaluation& ev) noexcept {
  for (const std::int32_t e : plan.repeating_events)
    if (state.events[at(e)].phase == EventPhase::kSpent && may_arm(plan, state, ev, e))
      state.events[at(e)].phase = EventPhase::kArmed;
  const std::span<double> guards = get_pair_guards(plan, ev.guards);
  for (std::size_t i = 0; i < state.contacts.size(); ++i) {
    ContactState& pair = state.contacts[i];
    const double distance = ev.pair_distances[i];
    if (pair.edge == 0 || !(guards[i] < 0) || !(pair.closed != 0 ? distance < 0 : distance > 0)) continue;
    pair.edge = 0;
    guards[i] = pair.closed != 0 ? distance : -distance;
  }
}

}  // namespace unlatch
