// Quantities, sensors, guards and actions.
#include "kernel/images/plan_check.h"
#include "unlatch/quantities.h"

namespace unlatch {

void PlanCheck::check_quantities() {
  for (const PlanQuantity& own : plan_.quantities) {
    require_flag(own.along);
    require_flag(own.guarded);
    require(get_number(own.kind) >= 0 && get_number(own.kind) < count_quantity_kinds());
    if (!good_) return;
    check_subject(own);
    const QuantityTraits& traits = get_traits(own.kind);
    if ((traits.reads & kReadsCoordinate) != 0) require_index(own.coordinate, plan_.coordinates.size());
    if (const int count = count_values(traits); count > 1) require(own.part < count);
    require(!traits.of_air || plan_.environment.has_air);
  }
  for (const PlanSensor& sensor : plan_.sensors) {
    require_flag(sensor.whole);
    require_index(sensor.quantity, plan_.quantities.size());
    if (!good_) return;
    const int count = sensor.whole ? count_values(get_traits(plan_.quantities[at(sensor.quantity)].kind)) : 1;
    require_range(sensor.first, count, at(plan_.sensor_count));
  }
}

void PlanCheck::check_subject(const PlanQuantity& own) {
  const QuantityTraits& traits = get_traits(own.kind);
  switch (traits.of) {
    case SubjectOf::kNothing:
      break;
    case SubjectOf::kBody:
      require_body(own.subject);
      break;
    case SubjectOf::kMassLaw:
      require_body(own.subject);
      if (good_) require(plan_.bodies[at(own.subject)].varying != kNone);
      break;
    case SubjectOf::kJoint:
      require_index(own.subject, plan_.joints.size());
      break;
    case SubjectOf::kSurface:
      require_index(own.subject, plan_.shapes.size());
      break;
    case SubjectOf::kContact:
      require_index(own.subject, plan_.contacts.size());
      break;
    case SubjectOf::kElement:
      require_element(own.subject);
      break;
    case SubjectOf::kOneSided:
      require_index(own.subject, plan_.one_sided.size());
      break;
    case SubjectOf::kCord:
      require_index(own.subject, plan_.one_sided.size());
      break;
    case SubjectOf::kSignal:
      require_index(own.subject, at(plan_.signal_count));
      break;
    case SubjectOf::kChannel:
      require_index(own.subject, plan_.initial_commands.size());
      break;
    case SubjectOf::kEvent:
      require_index(own.subject, plan_.events.size());
      break;
    case SubjectOf::kLaw:
      require_index(own.subject, plan_.laws.list.size());
      break;
  }
  if (traits.other == SubjectOf::kBody) require_body_or_ground(own.other);
  if (traits.other == SubjectOf::kSurface) require_index(own.other, plan_.shapes.size());
}

void PlanCheck::check_events() {
  for (const PlanCondition& condition : plan_.conditions) check_condition(condition);
  for (const PlanImpulse& impulse : plan_.impulses) {
    require_flag(impulse.world);
    require_body(impulse.body);
    require_channel(impulse.channel);
  }
  for (const Action& action : plan_.actions) check_action(action);
  for (const std::int32_t event : plan_.repeating_events) require_index(event, plan_.events.size());
  for (const std::int32_t event : plan_.timed_events) require_index(event, plan_.events.size());
  if (!good_) return;
  for (const PlanEvent& event : plan_.events) {
    for (const bool* flag : {&event.repeat, &event.by_time, &event.crossing, &event.timed}) require_flag(*flag);
    require_optional(event.engages, plan_.one_sided.size());
    require_range(event.first_action, event.action_count, plan_.actions.size());
    require_range(event.first_condition, event.condition_count, plan_.conditions.size());
    require(event.condition_count >= 1);
    if (good_) check_guard(event);
  }
}

void PlanCheck::check_condition(const PlanCondition& c) {
  using Kind = Condition::Kind;
  require_flag(c.below);
  require_kind(c.kind, Kind::kQuantity);
  if (!good_) return;
  switch (c.kind) {
    case Kind::kTime:
    case Kind::kAll:
    case Kind::kAny:
    case Kind::kNot:
      return require(c.part_count >= 0);
    case Kind::kReaction:
      require_index(c.subject, plan_.joints.size());
      require_index(c.axis, kRows);
      if (good_) require(c.first_mode == plan_.joints[at(c.subject)].first_mode);
      return require_index(c.multiplier.at, at(plan_.block_numbers));
    case Kind::kDisplacement:
    case Kind::kAngle:
    case Kind::kSpeed:
      return require_index(c.subject, plan_.coordinates.size());
    case Kind::kMode:
      return require_index(c.subject, plan_.joints.size());
    case Kind::kSignal:
      return require_index(c.subject, at(plan_.signal_count));
    case Kind::kClosed:
      return require_index(c.subject, plan_.contacts.size());
    case Kind::kEngaged:
    case Kind::kReach:
      return require_index(c.subject, plan_.one_sided.size());
    default:
      return require_index(c.subject, plan_.quantities.size());
  }
}

void PlanCheck::check_action(const Action& action) {
  using Kind = Action::Kind;
  require_kind(action.kind, Kind::kEngage);
  if (!good_) return;
  switch (action.kind) {
    case Kind::kSetMode:
      require_index(action.subject, plan_.joints.size());
      if (good_) require_index(action.mode, at(count_modes(action.subject)));
      break;
    case Kind::kSwitch:
    case Kind::kRamp:
      require_element(action.subject);
      break;
    case Kind::kRaise:
      require_index(action.subject, at(plan_.signal_count));
      break;
    case Kind::kImpulse:
      require_index(action.subject, plan_.impulses.size());
      break;
    case Kind::kEngage:
      require_index(action.subject, plan_.one_sided.size());
      break;
  }
}

// Walks through a guard as update_guards() does.
void PlanCheck::check_guard(const PlanEvent& event) {
  using Kind = Condition::Kind;
  const auto combines = [](const PlanCondition& c) {
    return c.kind == Kind::kAll || c.kind == Kind::kAny || c.kind == Kind::kNot;
  };
  require(event.flat_parts >= 0 && event.flat_parts <= event.condition_count);
  std::int32_t depth = 0;
  for (std::int32_t i = 0; i < event.condition_count && good_; ++i) {
    const PlanCondition& c = plan_.conditions[at(event.first_condition + i)];
    if (i < event.flat_parts) require(!combines(c));
    if (event.flat_parts > 0) continue;
    if (c.kind == Kind::kNot) {
      require(depth >= 1);
    } else if (combines(c)) {
      require(c.part_count >= 1 && c.part_count <= depth);
      depth += 1 - c.part_count;
    } else {
      ++depth;
    }
    require(depth <= plan_.guard_depth);
  }
  if (event.flat_parts == 0) require(depth >= 1);
}

}  // namespace unlatch
