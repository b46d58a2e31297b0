#include "kernel/step/guards.h"

#include <algorithm>

#include "kernel/dynamics/kinematics.h"
#include "kernel/plan/lane_access.h"
#include "unlatch/step.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Parts that hold or do not, and cannot change within a sub-step: so large that in an all or any they leave the
// real-valued parts as they are, which the search for the crossing needs.
constexpr double kYes = 1e100, kNo = -1e100;

UNLATCH_INLINE double calc_elementary(const Plan& plan, const Inputs& inputs, const State& state, double t,
                                      const Workspace& ws, const PlanCondition& c) {
  const std::size_t subject = at(c.subject);
  double value = 0;
  switch (c.kind) {
    case Condition::Kind::kTime:
      value = t;
      break;
    case Condition::Kind::kReaction:
      if (!has_row(plan.modes[at(c.first_mode) + static_cast<std::size_t>(state.joints[subject].mode)], c.axis))
        return kNo;
      value = ws.lanes[at(c.multiplier)];
      break;
    case Condition::Kind::kDisplacement:
    case Condition::Kind::kAngle:
      value = ws.coordinates[subject];
      break;
    case Condition::Kind::kSpeed:
      value = ws.speeds[subject];
      break;
    case Condition::Kind::kBodyRate:
      value = norm(read_vec(ws.lanes.data(), ws.slots[subject], kVelocity + 3));
      break;
    case Condition::Kind::kCommand:
      value = inputs.commands[subject];
      break;
    case Condition::Kind::kBurnt:
      value = ws.extras.now[at(plan.bodies[subject].varying)];
      break;
    case Condition::Kind::kSignal:
      return state.signals[subject] != 0 ? kYes : kNo;
    case Condition::Kind::kMode:
      return state.joints[subject].mode == c.axis ? kYes : kNo;
    case Condition::Kind::kAll:
    case Condition::Kind::kAny:
    case Condition::Kind::kNot:
      break;  // evaluated by the caller
  }
  return c.below ? c.threshold - value : value - c.threshold;
}

// Parts that must all hold, those that cannot change within a sub-step first.
double calc_all(const Plan& plan, const Inputs& inputs, const State& state, double t, const Workspace& ws,
                std::span<const PlanCondition> parts) {
  double value = calc_elementary(plan, inputs, state, t, ws, parts[0]);
  for (std::size_t i = 1; i < parts.size() && value != kNo; ++i)
    value = std::min(value, calc_elementary(plan, inputs, state, t, ws, parts[i]));
  return value;
}

double calc_nested(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws,
                   std::span<const PlanCondition> postfix) {
  std::size_t top = 0;
  for (const PlanCondition& c : postfix) {
    const std::size_t parts = at(c.part_count);
    const bool combines = c.kind == Condition::Kind::kAll || c.kind == Condition::Kind::kAny;
    if (c.kind == Condition::Kind::kNot) {
      ws.stack[top - 1] = -ws.stack[top - 1];
    } else if (combines) {
      double value = ws.stack[top - parts];
      for (std::size_t k = top - parts + 1; k < top; ++k)
        value = c.kind == Condition::Kind::kAll ? std::min(value, ws.stack[k]) : std::max(value, ws.stack[k]);
      top -= parts;
      ws.stack[top++] = value;
    } else {
      ws.stack[top++] = calc_elementary(plan, inputs, state, t, ws, c);
    }
  }
  return ws.stack[0];
}

}  // namespace

void update_guards(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws,
                   std::span<double> values) noexcept {
  const EventState* states = state.events.data();
  for (std::size_t e = 0; e < values.size(); ++e) {
    const PlanEvent& event = plan.events[e];
    const EventPhase phase = states[e].phase;
    const bool asleep = phase == EventPhase::kPending || (phase == EventPhase::kSpent && !event.repeat);
    const PlanCondition* first = plan.conditions.data() + event.first_condition;
    if (asleep)
      values[e] = kNo;
    else if (event.flat_parts > 0)
      values[e] = calc_all(plan, inputs, state, t, ws, {first, at(event.flat_parts)});
    else
      values[e] = calc_nested(plan, inputs, state, t, ws, {first, at(event.condition_count)});
  }
}

}  // namespace unlatch
