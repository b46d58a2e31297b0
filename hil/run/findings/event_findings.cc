#include <algorithm>
#include <limits>

#include "hil/run/findings/finding_parts.h"
#include "hil/run/notices/format.h"
#include "hil/scenario/model/index.h"

namespace unlatch::hil {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Earliest times at which modes, signals and events can occur, from known times, delays and dependencies. Guards of
// motion can be true at any time.
class Earliest {
 public:
  explicit Earliest(const Model& model)
      : model_(model), events_(model.events.size(), kNever), signals_(model.signals.size(), kNever) {
    for (const Joint& joint : model.joints) {
      modes_.emplace_back(joint.modes.size(), kNever);
      modes_.back()[at(joint.mode)] = 0;
    }
    // Each pass settles at least one event.
    for (std::size_t pass = 0; pass <= model.events.size(); ++pass) settle();
  }

  [[nodiscard]] double get_event(std::size_t e) const { return events_[e]; }

 private:
  void settle() {
    for (std::size_t e = 0; e < events_.size(); ++e) {
      const Event& event = model_.events[e];
      events_[e] = std::min(events_[e], calc(event.when) + event.delay);
      for (const Action& action : event.then) {
        if (action.kind == Action::Kind::kRaise) lower(signals_[at(action.subject)], events_[e]);
        if (action.kind == Action::Kind::kSetMode) lower(modes_[at(action.subject)][at(action.mode)], events_[e]);
      }
    }
  }
  static void lower(double& time, double to) { time = std::min(time, to); }

  [[nodiscard]] double calc(const Condition& c) const {
    using Kind = Condition::Kind;
    double time = c.kind == Kind::kAny ? kNever : 0;
    switch (c.kind) {
      case Kind::kTime:
        return c.below ? 0 : std::max(0.0, c.threshold);
      case Kind::kSignal:
        return signals_[at(c.subject)];
      case Kind::kMode:
        return modes_[at(c.subject)][at(c.axis)];
      case Kind::kReaction:
        time = kNever;
        for (std::size_t mode = 0; mode < modes_[at(c.subject)].size(); ++mode)
          if (has_row(model_.joints[at(c.subject)].modes[mode].rows, c.axis))
            time = std::min(time, modes_[at(c.subject)][mode]);
        return time;
      case Kind::kAll:
        for (const Condition& part : c.parts) time = std::max(time, calc(part));
        return time;
      case Kind::kAny:
        for (const Condition& part : c.parts) time = std::min(time, calc(part));
        return time;
      default:
        return 0;
    }
  }

  const Model& model_;
  std::vector<double> events_, signals_;
  std::vector<std::vector<double>> modes_;  // of each joint
};

// Name of an event in Scenario::marks.
std::string name_event(const Event& event) {
  return quoted("event", event.name) + (event.subject.empty() ? "" : " of '" + event.subject + "'");
}

bool has_kind(const Condition& c, Condition::Kind kind) {
  return c.kind == kind ||
         std::any_of(c.parts.begin(), c.parts.end(), [kind](const Condition& part) { return has_kind(part, kind); });
}
bool lies_before_start(const Condition& c) {
  if (c.kind == Condition::Kind::kTime) return !c.below && c.threshold < 0;
  return std::any_of(c.parts.begin(), c.parts.end(), lies_before_start);
}

}  // namespace

void add_event_findings(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  const Earliest earliest(model);
  for (std::size_t e = 0; e < model.events.size(); ++e) {
    const Event& event = model.events[e];
    const std::string where = name_event(event);
    const double time = earliest.get_event(e);
    if (time == kNever)
      findings.push_back({"never", where, "cannot come: no event brings about what it waits for"});
    else if (time > scenario.until)
      findings.push_back(
          {"never", where, format("cannot come before %.6g s; the run ends at %.6g s", time, scenario.until)});
    if (lies_before_start(event.when)) findings.push_back({"start", where, "waits for a time before the start"});
  }
  // A trial step shows which guards are true already; only guards on time matter.
  Simulation trial(model, {.dt = scenario.dt}, scenario.rates);
  for (const FiredEvent& fired : trial.step().events) {
    const Event& event = model.events[at(fired.event)];
    if (fired.time > 0 || has_kind(event.when, Condition::Kind::kTime)) continue;
    const std::string where = name_event(event);
    findings.push_back({"start", where, "holds at the start already, and acts at t = 0"});
  }
}

}  // namespace unlatch::hil
