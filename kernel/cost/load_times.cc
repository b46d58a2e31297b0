#include "kernel/cost/load_times.h"

#include <algorithm>
#include <cmath>

#include "kernel/cost/step_counts.h"

namespace unlatch::cost {
namespace {

constexpr double kNever = HUGE_VAL;
constexpr double kDrift = 1e-6;  // m or rad: what rows hold is off by less

bool switches(const Action& action, std::int32_t element) {
  return (action.kind == Action::Kind::kSwitch || action.kind == Action::Kind::kRamp) && action.subject == element;
}

template <class Do>
void for_actions(const PlanData& plan, const PlanEvent& event, const Do& act) {
  for (std::int32_t i = 0; i < event.action_count; ++i) act(plan.actions[at(event.first_action + i)]);
}

class EarliestTimes {
 public:
  explicit EarliestTimes(const PlanData& plan) : plan_(plan), times_(plan.events.size(), kNever) {}

  // From "never" on, until no event finds an earlier cause.
  std::vector<double> find() {
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t e = 0; e < times_.size(); ++e) {
        const double time = calc_event(plan_.events[e]);
        changed = changed || time < times_[e];
        times_[e] = std::min(times_[e], time);
      }
    }
    return times_;
  }

 private:
  double calc_event(const PlanEvent& event) const {
    double time = 0;
    for (std::int32_t i = 0; i < event.flat_parts; ++i)
      time = std::max(time, calc_part(plan_.conditions[at(event.first_condition + i)]));
    return time + event.delay;
  }

  double calc_part(const PlanCondition& part) const {
    using Kind = Condition::Kind;
    switch (part.kind) {
      case Kind::kTime:
        return part.below ? 0 : std::max(0.0, part.threshold - plan_.options.dt);
      case Kind::kSignal:
        return find_cause([&](const Action& action) {
          return action.kind == Action::Kind::kRaise && action.subject == part.subject && action.value != 0;
        });
      case Kind::kMode:
        return find_mode(part.subject, [&](std::int64_t mode) { return mode == part.axis; });
      case Kind::kReaction:
        return find_mode(part.subject, [&](std::int64_t mode) { return has_row(get_rows(part, mode), part.axis); });
      case Kind::kDisplacement:
        return calc_displacement(plan_.coordinates[at(part.subject)], part);
      default:
        return 0;
    }
  }
  // A displacement that rows hold at 0 is not beyond a threshold before a mode without them.
  double calc_displacement(const PlanCoordinate& coordinate, const PlanCondition& part) const {
    const bool beyond = part.below ? part.threshold < -kDrift : part.threshold > kDrift;
    if (!beyond || coordinate.row >= kRotX) return 0;
    return find_mode(coordinate.joint, [&](std::int64_t mode) {
      return !has_row(plan_.get_rows(coordinate.joint, mode), coordinate.row);
    });
  }
  RowSet get_rows(const PlanCondition& part, std::int64_t mode) const { return plan_.get_rows(part.subject, mode); }

  // The earliest time of an event with such an action.
  template <class Is>
  double find_cause(const Is& is) const {
    double time = kNever;
    for (std::size_t e = 0; e < times_.size(); ++e)
      for_actions(plan_, plan_.events[e], [&](const Action& action) {
        if (is(action)) time = std::min(time, times_[e]);
      });
    return time;
  }
  // The earliest time at which a joint may have such a mode.
  template <class Is>
  double find_mode(std::int32_t joint, const Is& is) const {
    if (is(plan_.joints[at(joint)].mode)) return 0;
    return find_cause([&](const Action& action) {
      return action.kind == Action::Kind::kSetMode && action.subject == joint && is(action.mode);
    });
  }

  const PlanData& plan_;
  std::vector<double> times_;
};

// An action that switches an element, by an event that acts at a known time.
struct Switching {
  double time, value, duration;
};

// All that switch an element, in order of time; `known`: all of them act once, at known times.
std::vector<Switching> list_switchings(const PlanData& plan, std::int32_t element, const std::vector<double>& earliest,
                                       bool& known) {
  std::vector<Switching> list;
  known = true;
  for (std::size_t e = 0; e < plan.events.size(); ++e)
    for_actions(plan, plan.events[e], [&](const Action& action) {
      if (!switches(action, element)) return;
      known = known && plan.events[e].by_time && !plan.events[e].repeat;
      list.push_back({earliest[e], action.value, action.kind == Action::Kind::kRamp ? action.duration : 0});
    });
  std::stable_sort(list.begin(), list.end(), [](const Switching& a, const Switching& b) { return a.time < b.time; });
  return list;
}

std::vector<OnSpan> list_spans(const PlanData& plan, std::int32_t element, const std::vector<double>& earliest) {
  const double margin = 3 * plan.options.dt;  // an event may be left to the next step
  bool known = false;
  const std::vector<Switching> list = list_switchings(plan, element, earliest, known);
  const bool on = plan.element_scales[at(element)] != 0;
  std::vector<OnSpan> spans;
  if (on) spans.push_back({0, kNever});
  for (const Switching& own : list) {
    if (own.value != 0)
      spans.push_back({own.time, kNever});
    else if (known && !spans.empty())
      for (OnSpan& span : spans) span.to = std::min(span.to, own.time + own.duration + margin);
  }
  return spans;
}

}  // namespace

std::vector<double> calc_earliest_times(const PlanData& plan) { return EarliestTimes(plan).find(); }

std::vector<std::vector<OnSpan>> list_on_spans(const PlanData& plan) {
  const std::vector<double> earliest = calc_earliest_times(plan);
  std::vector<std::vector<OnSpan>> all;
  for (std::size_t i = 0; i < plan.element_scales.size(); ++i)
    all.push_back(list_spans(plan, static_cast<std::int32_t>(i), earliest));
  return all;
}

std::vector<std::int32_t> list_predecessors(const PlanData& plan) {
  // Of each element: events that switch it on.
  std::vector<std::vector<std::size_t>> causes(plan.element_scales.size());
  for (std::size_t e = 0; e < plan.events.size(); ++e)
    for_actions(plan, plan.events[e], [&](const Action& action) {
      if ((action.kind == Action::Kind::kSwitch || action.kind == Action::Kind::kRamp) && action.value != 0)
        causes[at(action.subject)].push_back(e);
    });
  std::vector<std::int32_t> predecessors(plan.element_scales.size(), kNone);
  for (std::size_t own = 0; own < predecessors.size(); ++own) {
    if (plan.element_scales[own] != 0 || causes[own].size() != 1) continue;
    for_actions(plan, plan.events[causes[own].front()], [&](const Action& action) {
      const bool ends = action.kind == Action::Kind::kSwitch && action.value == 0 && causes[at(action.subject)].empty();
      if (ends && predecessors[own] == kNone) predecessors[own] = action.subject;
    });
  }
  return predecessors;
}

}  // namespace unlatch::cost
