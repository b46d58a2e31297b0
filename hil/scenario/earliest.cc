#include "hil/scenario/earliest.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "hil/scenario/base/index.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

void lower(double& time, double to) { time = std::min(time, to); }

}  // namespace

EarliestTimes::EarliestTimes(const Model& model)
    : model_(model), events_(model.events.size(), kNever), signals_(model.signals.size(), kNever) {
  for (const Joint& joint : model.joints) {
    modes_.emplace_back(joint.modes.size(), kNever);
    modes_.back()[at(joint.mode)] = 0;
  }
  // Each pass settles at least one event.
  for (std::size_t pass = 0; pass <= model.events.size(); ++pass) settle();
}

std::string EarliestTimes::explain(std::size_t event, double until) const {
  const double time = events_[event];
  if (time <= until) return "";
  if (time == kNever) return "cannot come: no event brings about what it waits for";
  char text[96];
  std::snprintf(text, sizeof text, "cannot come before %.6g s; the run ends at %.6g s", time, until);
  return text;
}

void EarliestTimes::settle() {
  for (std::size_t e = 0; e < events_.size(); ++e) {
    const Event& event = model_.events[e];
    events_[e] = std::min(events_[e], calc(event.when) + event.delay);
    for (const Action& action : event.then) {
      if (action.kind == Action::Kind::kRaise) lower(signals_[at(action.subject)], events_[e]);
      if (action.kind == Action::Kind::kSetMode) lower(modes_[at(action.subject)][at(action.mode)], events_[e]);
    }
  }
}

double EarliestTimes::calc(const Condition& c) const {
  double time = c.kind == Condition::Kind::kAny ? kNever : 0;
  switch (c.kind) {
    case Condition::Kind::kAll:
      for (const Condition& part : c.parts) time = std::max(time, calc(part));
      return time;
    case Condition::Kind::kAny:
      for (const Condition& part : c.parts) time = std::min(time, calc(part));
      return time;
    case Condition::Kind::kNot:
      return 0;
    default:
      return calc(get_quantity(model_, c), c);
  }
}

double EarliestTimes::calc(const unlatch::Quantity& quantity, const Condition& c) const {
  const bool compared = c.kind == Condition::Kind::kQuantity;
  switch (quantity.kind) {
    case unlatch::Quantity::Kind::kTime:
      return c.below ? 0 : std::max(0.0, c.threshold);
    case unlatch::Quantity::Kind::kSince:
      return c.below || !(c.threshold > 0) ? 0 : events_[at(quantity.subject)] + c.threshold;
    case unlatch::Quantity::Kind::kSignal:
      return compared ? 0 : signals_[at(quantity.subject)];
    case unlatch::Quantity::Kind::kMode:
      return compared ? 0 : modes_[at(quantity.subject)][at(quantity.part)];
    case unlatch::Quantity::Kind::kReaction: {
      if (compared) return 0;  // a row that does not hold has the reaction 0
      double time = kNever;
      const std::vector<double>& modes = modes_[at(quantity.subject)];
      for (std::size_t mode = 0; mode < modes.size(); ++mode)
        if (has_row(model_.joints[at(quantity.subject)].modes[mode].rows, quantity.part)) lower(time, modes[mode]);
      return time;
    }
    default:
      return 0;
  }
}

}  // namespace unlatch::hil
