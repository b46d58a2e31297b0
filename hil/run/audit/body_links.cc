#include "hil/run/audit/body_links.h"

#include <algorithm>
#include <cstddef>

#include "hil/run/audit/dependence.h"
#include "hil/scenario/base/index.h"
#include "unlatch/model/subjects.h"

namespace unlatch::hil {

BodyLinks::BodyLinks(const Model& model) : model_(model) {
  for (int j = 0; at(j) < model.joints.size(); ++j) add(Kind::kJoint, j, list_joint_bodies(model, j));
  const std::vector<Subjects> subjects = list_element_subjects(model);
  for (int element = 0; at(element) < subjects.size(); ++element) {
    const Subjects& own = subjects[at(element)];
    for (std::size_t i = 0; i < own.bodies.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) add(Kind::kElement, element, list_pair(model, own.bodies[k], own.bodies[i]));
      for (const int law : own.laws)
        add_ways(Kind::kElement, element, list_read_bodies(model, model.laws[at(law)]),
                 list_pair(model, kGround, own.bodies[i]));
    }
  }
  for (std::size_t e = 0; e < model.events.size(); ++e)
    add_ways(Kind::kEvent, static_cast<int>(e), list_guard_bodies(model, model.events[e]),
             list_driven_bodies(model, model.events[e]));
  add_ways(Kind::kCommand, kNone, list_sensed_bodies(model), list_commanded_bodies(model));
}

void BodyLinks::add(Kind kind, int subject, const std::vector<int>& pair) {
  if (pair.size() == 2 && pair[0] != pair[1])
    links_.push_back({.kind = kind, .subject = subject, .a = pair[0], .b = pair[1], .returns = true});
}

void BodyLinks::add_ways(Kind kind, int subject, const std::vector<int>& from, const std::vector<int>& to) {
  for (const int a : from)
    for (const int b : to)
      if (a != b) links_.push_back({.kind = kind, .subject = subject, .a = a, .b = b});
}

bool BodyLinks::is_on(const Link& link, const State& state) const {
  switch (link.kind) {
    case Kind::kJoint:
      return model_.joints[at(link.subject)].modes[at(static_cast<int>(state.joints[at(link.subject)].mode))].rows != 0;
    case Kind::kElement: {  // engaged or not: with the true motion it might have been
      // A ramp that begins at this instant counts; one to zero counts until the next events.
      const ElementState& element = state.elements[at(link.subject)];
      return element.from != 0 || element.to != 0;
    }
    case Kind::kEvent:
      return model_.events[at(link.subject)].repeat || state.events[at(link.subject)].phase != EventPhase::kSpent;
    case Kind::kCommand:
      return !link.periods.empty();
  }
  return true;
}

void BodyLinks::update(const State& state, double time) {
  for (Link& link : links_) {
    const bool was_on = !link.periods.empty() && link.periods.back().until == kNever;
    const bool on = is_on(link, state);
    if (was_on && !on) link.periods.back().until = time;
    if (was_on || !on) continue;
    if (link.periods.size() == kMostPeriods || (!link.periods.empty() && link.periods.back().until == time))
      link.periods.back().until = kNever;
    else
      link.periods.push_back({time});
  }
}

void BodyLinks::add_command(double time) {
  for (Link& link : links_)
    if (link.kind == Kind::kCommand && link.periods.empty()) link.periods.push_back({time});
}

void BodyLinks::spread(std::vector<double>& times, std::vector<int>& sources) const {
  sources.resize(times.size());
  for (std::size_t b = 0; b < times.size(); ++b) sources[b] = static_cast<int>(b);
  bool changes = false;
  const auto pass = [&](int from, int to, const Period& period) {
    const double start = times[at(from)];
    const double arrival = start < period.from ? period.from : start;
    if (start > period.until || !(arrival < times[at(to)])) return;
    times[at(to)] = arrival;
    sources[at(to)] = sources[at(from)];
    changes = true;
  };
  do {
    changes = false;
    for (const Link& link : links_)
      for (const Period& period : link.periods) {
        pass(link.a, link.b, period);
        if (link.returns) pass(link.b, link.a, period);
      }
  } while (changes);
}

}  // namespace unlatch::hil
