// Events of a plan, with the quantities that guards compare and sensors measure.
#pragma once

#include <cstdint>

#include "kernel/plan/lanes.h"
#include "kernel/plan/list_kinds.h"
#include "unlatch/model.h"

namespace unlatch {

struct PlanImpulse {
  std::int32_t body, channel;
  bool world;
  Vec3 point, linear, angular;
};

// A quantity, see kernel/quantities. Its number among signals, bodies and so on is `subject`, as in the model.
struct PlanQuantity {
  Quantity::Kind kind;
  std::int32_t subject, other, part;
  std::int32_t coordinate = kNone;  // into PlanData::coordinates, of kinds that read one
  bool along = false;               // the component along `direction`
  bool guarded = false;             // of a condition: a bound serves that lies on the same side of `threshold`
  double threshold = 0;
  Vec3 direction{}, other_direction{}, point{};
};

// Guards in postfix order: a condition's parts stand before it. Compilation may rewrite `subject` and `axis`:
//
//   kind                             subject is an index into    axis
//   kReaction                        joints                      row
//   kDisplacement, kAngle, kSpeed    PlanData::coordinates       row
//   kMode                            joints                      number of the mode
//   kSignal                          signals
//   kClosed                          PlanData::contacts
//   kEngaged, kReach                 PlanData::one_sided
//   any other                        PlanData::quantities
struct PlanCondition {
  Condition::Kind kind;
  std::int32_t subject, axis, part_count;
  double threshold;
  bool below;
  std::int32_t first_mode;  // of a reaction: of its joint in PlanData::modes
  NumberPlace multiplier;   // likewise
};

struct PlanEvent {
  std::int32_t first_condition, condition_count, first_action, action_count;
  std::int32_t flat_parts;  // the first conditions that must all hold, where the guard is nothing else; otherwise 0
  double delay;
  bool repeat;
  std::int32_t engages;  // the one-sided force whose engagement it decides, or kNone
  std::int64_t engaged;  // what it decides
  bool by_time;          // the whole guard is "t ≥ T", which needs no search
  bool crossing;         // what holds at the start is no event
  bool timed;            // some quantity is the time since it acted: EventState::due keeps that, −1 before
};

struct PlanSensor {
  std::int32_t quantity;  // into PlanData::quantities
  std::int32_t first;     // into Workspace::sensors
  bool whole;             // all values of the quantity; otherwise the one that it chooses
};

// In PlanLists.
template <template <class> class List>
struct PlanEventLists {
  List<PlanCondition> conditions;
  List<Action> actions;
  List<PlanImpulse> impulses;
  List<PlanEvent> events;
  List<std::int32_t> repeating_events;
  List<std::int32_t> timed_events;  // that are due at a known time: by their guard, or after a delay
  List<PlanQuantity> quantities;    // the model's, then those of conditions, then those of sensors
  List<PlanSensor> sensors;
  List<double> initial_commands;  // of the channels

  // Calls use(list…) with each list: that of one name of all `lists`. A new list goes here as well.
  template <class Use, class... Lists>
  static constexpr void for_each(const Use& use, Lists&... lists) {
    use(lists.conditions...);
    use(lists.actions...);
    use(lists.impulses...);
    use(lists.events...);
    use(lists.repeating_events...);
    use(lists.timed_events...);
    use(lists.quantities...);
    use(lists.sensors...);
    use(lists.initial_commands...);
  }
};

}  // namespace unlatch
