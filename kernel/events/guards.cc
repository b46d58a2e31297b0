#include "kernel/events/guards.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/elements/kinds/one_sided/one_sided.h"
#include "kernel/joints/kinematics.h"
#include "kernel/quantities/quantities.h"

namespace unlatch {
namespace {

// Values of parts that are true or false and cannot change within a sub-step. They are so large that the least or the
// greatest of several parts is that of the real-valued ones, which the search for the crossing needs.
constexpr double kYes = 1e100, kNo = -1e100;

// The reach of a one-sided force, by its number: the events of its engagement and of its end follow each other.
struct LatestReach {
  std::int32_t force = kNone;
  bool is_on = false;
  double reach = 0;
};

// Guard of an engagement: ≥ 0 where the force is to be engaged; of its end (`below`): > 0 where it is not.
[[gnu::noinline]] double calc_reach_guard(const Instant& now, const Evaluation& ev, const PlanCondition& c,
                                          LatestReach& latest) {
  if (latest.force != c.subject) {
    const PlanOneSided& own = now.plan.one_sided[at(c.subject)];
    latest = {c.subject, is_on(now.state.elements[at(own.element)], now.t)};
    if (latest.is_on) latest.reach = calc_reach(now.plan, own, calc_motion(now.plan, now.state, ev, own));
  }
  if (!latest.is_on) return kNo;
  return c.below ? -latest.reach - std::numeric_limits<double>::min() : latest.reach;
}

// Quantities other than the most frequent ones. Out of line, so that the frequent ones need few registers.
[[gnu::noinline]] double calc_quantity(const Instant& now, const Evaluation& ev, std::size_t number) {
  return calc_scalar(now, ev, now.plan.quantities[number]);
}

// A condition without parts; `subject` and `axis` are those of PlanCondition's table.
UNLATCH_INLINE double calc_elementary(const Instant& now, const Evaluation& ev, const PlanCondition& c,
                                      LatestReach& latest) {
  const PlanData& plan = now.plan;
  const State& state = now.state;
  const std::size_t subject = at(c.subject);
  double value = 0;
  switch (c.kind) {
    case Condition::Kind::kTime:
      value = now.t;
      break;
    case Condition::Kind::kReaction:
      if (!has_row(plan.modes[at(c.first_mode) + static_cast<std::size_t>(state.joints[subject].mode)], c.axis))
        return kNo;
      value = c.multiplier.in(ev.blocks.data());
      break;
    case Condition::Kind::kDisplacement:
    case Condition::Kind::kAngle:
      value = ev.coordinates[subject];
      break;
    case Condition::Kind::kSpeed:
      value = ev.speeds[subject];
      break;
    case Condition::Kind::kReach:
      return calc_reach_guard(now, ev, c, latest);
    case Condition::Kind::kEngaged:
      return state.engaged[subject] != 0 ? kYes : kNo;
    case Condition::Kind::kSignal:
      return state.signals[subject] != 0 ? kYes : kNo;
    case Condition::Kind::kMode:
      return state.joints[subject].mode == c.axis ? kYes : kNo;
    case Condition::Kind::kClosed: {
      const PlanContact& contact = plan.contacts[subject];
      for (std::int32_t i = 0; i < contact.pairs; ++i)
        if (state.contacts[at(contact.first_pair + i)].closed != 0) return kYes;
      return kNo;
    }
    default:
      value = calc_quantity(now, ev, subject);
  }
  return c.below ? c.threshold - value : value - c.threshold;
}

// Guard of parts that must all hold. Those that cannot change within a sub-step come first.
double calc_all(const Instant& now, const Evaluation& ev, std::span<const PlanCondition> parts, LatestReach& latest) {
  double value = calc_elementary(now, ev, parts[0], latest);
  for (std::size_t i = 1; i < parts.size() && value != kNo; ++i)
    value = std::min(value, calc_elementary(now, ev, parts[i], latest));
  return value;
}

double calc_nested(const Instant& now, const Evaluation& ev, std::span<double> stack,
                   std::span<const PlanCondition> postfix, LatestReach& latest) {
  std::size_t top = 0;
  for (const PlanCondition& c : postfix) {
    const std::size_t parts = at(c.part_count);
    const bool combines = c.kind == Condition::Kind::kAll || c.kind == Condition::Kind::kAny;
    if (c.kind == Condition::Kind::kNot) {
      stack[top - 1] = -stack[top - 1];
    } else if (combines) {
      double value = stack[top - parts];
      for (std::size_t k = top - parts + 1; k < top; ++k)
        value = c.kind == Condition::Kind::kAll ? std::min(value, stack[k]) : std::max(value, stack[k]);
      top -= parts;
      stack[top++] = value;
    } else {
      stack[top++] = calc_elementary(now, ev, c, latest);
    }
  }
  return stack[0];
}

// Guard of a closed pair of a rigid contact: its force falls to zero, or its friction begins or ends to hold it.
double calc_held_guard(const Instant& now, const Evaluation& ev, std::size_t pair) {
  if (!is_held(now.state.contacts[pair])) return kYes;
  const double lift = -ev.pair_forces[pair] - std::numeric_limits<double>::min();
  const PlanContact& contact = now.plan.contacts[at(now.plan.contact_pairs[pair].contact)];
  if (contact.friction > 0 && now.state.contacts[pair].closed == 1) {
    const Vec3& slip = now.state.rigid_slips[pair];
    if (!(dot(slip, slip) > 0)) return kYes;  // it is not decided whether it sticks
  }
  return contact.friction > 0 ? std::max(lift, ev.pair_slides[pair]) : lift;
}

// Guards of pairs of shapes: touch of open ones, lift of closed ones. Shapes of a contact that is off count as apart.
void update_pair_guards(const Instant& now, Evaluation& ev) {
  update_open_pairs(now, ev);
  const std::span<double> guards = get_pair_guards(now.plan, ev.guards);
  for (std::size_t i = 0; i < ev.pair_distances.size(); ++i) {
    const ContactState& pair = now.state.contacts[i];
    const std::int32_t element = now.plan.contacts[at(now.plan.contact_pairs[i].contact)].element;
    const bool off = calc_scale(now.state.elements[at(element)], now.t) == 0;
    if (pair.closed != 0 && now.plan.contacts[at(now.plan.contact_pairs[i].contact)].rigid)
      guards[i] = off ? kYes : calc_held_guard(now, ev, i);
    else if (pair.closed != 0)
      guards[i] = off ? kYes : ev.pair_distances[i] - pair.edge;
    else
      guards[i] = off ? kNo : pair.edge - ev.pair_distances[i];
    if (pair.closed != 0) ev.pair_features[i] = calc_pair_feature(now.plan, i, off, ev);
  }
}

}  // namespace

void update_guards(const Instant& now, Evaluation& ev, std::span<double> stack) noexcept {
  const PlanCondition* conditions = now.plan.conditions.data();
  const EventState* state = now.state.events.data();
  double* guard = ev.guards.data();
  LatestReach latest;
  for (const PlanEvent& event : now.plan.events) {
    const EventPhase phase = (state++)->phase;
    const bool can_cross = phase == EventPhase::kArmed || (phase == EventPhase::kSpent && event.repeat);
    const PlanCondition* first = conditions + event.first_condition;
    if (!can_cross)
      *guard++ = kNo;
    else if (event.flat_parts > 0)
      *guard++ = calc_all(now, ev, {first, at(event.flat_parts)}, latest);
    else
      *guard++ = calc_nested(now, ev, stack, {first, at(event.condition_count)}, latest);
  }
  if (!ev.pair_distances.empty()) update_pair_guards(now, ev);
}

}  // namespace unlatch
