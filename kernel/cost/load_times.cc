#include "kernel/cost/load_times.h"

#include <algorithm>
#include <cmath>

#include "kernel/cost/step_counts.h"
#include "kernel/events/limits.h"

namespace unlatch::cost {
namespace {

constexpr double kNever = HUGE_VAL;
constexpr double kDrift = 1e-6;  // m or rad: what rows hold is off by less

// An event may be left to the next step, and so may the end of its delay; with what calc_earliest_times() takes off.
double calc_margin(const PlanData& plan) { return 3 * plan.options.dt; }

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
  const double margin = calc_margin(plan);
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

namespace {

// Of each element the events that switch it on.
std::vector<std::vector<std::size_t>> list_causes(const PlanData& plan) {
  std::vector<std::vector<std::size_t>> causes(plan.element_scales.size());
  for (std::size_t e = 0; e < plan.events.size(); ++e)
    for_actions(plan, plan.events[e], [&](const Action& action) {
      if ((action.kind == Action::Kind::kSwitch || action.kind == Action::Kind::kRamp) && action.value != 0)
        causes[at(action.subject)].push_back(e);
    });
  return causes;
}

// The end of a ramp: it lies between these times, s.
struct RampEnd {
  double from, to;
};

// The ends of all ramps of a plan in whose flights each ramp begins once. Ramps of one event that last as long end
// together, at one corner.
struct RampEnds {
  std::vector<RampEnd> known;  // of events that act at known times
  std::int64_t others = 0;
  bool recur = false;  // some ramp may begin more often
};
RampEnds list_ramp_ends(const PlanData& plan) {
  const std::vector<double> earliest = calc_earliest_times(plan);
  RampEnds ends;
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    const PlanEvent& event = plan.events[e];
    std::vector<double> durations;
    for_actions(plan, event, [&](const Action& action) {
      if (action.kind != Action::Kind::kRamp || !(action.duration > 0)) return;
      if (std::find(durations.begin(), durations.end(), action.duration) == durations.end())
        durations.push_back(action.duration);
    });
    ends.recur = ends.recur || (event.repeat && !durations.empty());
    for (const double duration : durations) {
      const double from = earliest[e] + duration;
      if (event.by_time)
        ends.known.push_back({from, from + calc_margin(plan)});
      else
        ++ends.others;
    }
  }
  return ends;
}

// The most of them that a step of this length may meet.
std::int64_t count_met(const std::vector<RampEnd>& ends, double dt) {
  std::int64_t most = 0;
  for (const RampEnd& first : ends) {  // the one that lies before the others: the step begins no later than it does
    const auto meets = [&](const RampEnd& own) { return own.from <= first.to + dt && own.to >= first.to; };
    most = std::max(most, static_cast<std::int64_t>(std::count_if(ends.begin(), ends.end(), meets)));
  }
  return most;
}

// True of tables over time and knots of masses: a step may pass many of their points.
bool has_tables_over_time(const PlanData& plan) {
  const auto reads_table = [&](const PlanLoad& load) {
    return load.law == kNone && plan.profiles[at(load.profile)].kind == Profile::Kind::kTable;
  };
  return std::any_of(plan.loads.begin(), plan.loads.end(), reads_table) ||
         std::any_of(plan.varying.begin(), plan.varying.end(), [](const PlanVarying& own) { return !own.by_burnt; });
}

}  // namespace

std::vector<std::int32_t> list_predecessors(const PlanData& plan) {
  const std::vector<std::vector<std::size_t>> causes = list_causes(plan);
  const std::vector<double> earliest = calc_earliest_times(plan);
  // True if no event switches the element on once event `e` has acted: all that do act once, at known times before.
  const auto ends_with = [&](std::int32_t element, std::size_t e) {
    return std::ranges::all_of(causes[at(element)], [&](std::size_t c) {
      const PlanEvent& own = plan.events[c];
      return own.by_time && !own.repeat && earliest[c] + calc_margin(plan) < earliest[e];
    });
  };
  std::vector<std::int32_t> predecessors(plan.element_scales.size(), kNone);
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    // What it alone switches on, and what it switches off for good; the first with the first, and so on.
    std::vector<std::int32_t> on, off;
    const auto add_once = [](std::vector<std::int32_t>& list, std::int32_t element) {
      if (std::find(list.begin(), list.end(), element) == list.end()) list.push_back(element);
    };
    for_actions(plan, plan.events[e], [&](const Action& action) {
      if (action.kind != Action::Kind::kSwitch && action.kind != Action::Kind::kRamp) return;
      const std::vector<std::size_t>& own = causes[at(action.subject)];
      if (action.value != 0 && own.size() == 1 && plan.element_scales[at(action.subject)] == 0)
        add_once(on, action.subject);
      if (action.value == 0 && action.kind == Action::Kind::kSwitch && ends_with(action.subject, e))
        add_once(off, action.subject);
    });
    for (std::size_t i = 0; i < std::min(on.size(), off.size()); ++i) predecessors[at(on[i])] = off[i];
  }
  return predecessors;
}

std::int64_t count_timed_corners(const PlanData& plan) {
  if (!plan.time_corners) return 0;
  const RampEnds ends = list_ramp_ends(plan);
  if (has_tables_over_time(plan) || ends.recur) return kMostCornerSplits;
  return std::min<std::int64_t>(kMostCornerSplits, ends.others + count_met(ends.known, plan.options.dt));
}

}  // namespace unlatch::cost
