#include "hil/run/audit/body_links.h"

#include <algorithm>
#include <cstddef>

#include "hil/run/audit/dependence.h"
#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {

BodyLinks::BodyLinks(const Model& model) : model_(model) {
  for (int j = 0; at(j) < model.joints.size(); ++j) add(Kind::kJoint, j, kNone, list_joint_bodies(model, j));
  int element = 0;
  for (const Load& load : model.loads) {
    if (load.profile.law != kNone)
      add_ways(Kind::kElement, kNone, element, list_read_bodies(model, model.laws[at(load.profile.law)]),
               list_pair(model, kGround, load.body));
    ++element;
  }
  for (; element < model.element_count(); ++element) {
    const std::size_t first_contact =
        model.loads.size() + model.point_springs.size() + model.joint_springs.size() + model.plane_torsions.size();
    const std::size_t own = at(element);
    if (own < first_contact) {
      const std::vector<int> bodies = list_element_bodies(model, element);
      if (bodies.size() == 2) add(Kind::kElement, kNone, element, list_pair(model, bodies[0], bodies[1]));
    } else if (own < first_contact + model.contacts.size()) {
      const int contact = element - static_cast<int>(first_contact);
      add(Kind::kContact, contact, element, list_contact_bodies(model, contact));
    } else if (own < first_contact + model.contacts.size() + model.one_sided.size()) {
      const std::vector<int> bodies = list_element_bodies(model, element);
      if (bodies.size() == 2)
        add(Kind::kOneSided, element - get_first_one_sided(model), element, list_pair(model, bodies[0], bodies[1]));
    }
  }
  const int first_air = model.element_count() - static_cast<int>(model.aerodynamics.size());
  for (std::size_t i = 0; i < model.aerodynamics.size(); ++i)
    for (const AeroTerm& term : model.aerodynamics[i].terms)
      if (term.law != kNone)
        add_ways(Kind::kElement, kNone, first_air + static_cast<int>(i),
                 list_read_bodies(model, model.laws[at(term.law)]),
                 list_pair(model, kGround, model.aerodynamics[i].body));
  for (std::size_t e = 0; e < model.events.size(); ++e)
    add_ways(Kind::kEvent, static_cast<int>(e), kNone, list_guard_bodies(model, model.events[e]),
             list_driven_bodies(model, model.events[e]));
  add_ways(Kind::kCommand, kNone, kNone, list_sensed_bodies(model), list_commanded_bodies(model));
}

void BodyLinks::add(Kind kind, int subject, int element, const std::vector<int>& pair) {
  if (pair.size() == 2 && pair[0] != pair[1])
    links_.push_back(
        {.kind = kind, .subject = subject, .element = element, .a = pair[0], .b = pair[1], .returns = true});
}

void BodyLinks::add_ways(Kind kind, int subject, int element, const std::vector<int>& from,
                         const std::vector<int>& to) {
  for (const int a : from)
    for (const int b : to)
      if (a != b) links_.push_back({.kind = kind, .subject = subject, .element = element, .a = a, .b = b});
}

bool BodyLinks::is_on(const Link& link, const State& state) const {
  // A ramp that begins at this instant counts; one to zero counts until the next events.
  const auto acts = [&] {
    const ElementState& element = state.elements[at(link.element)];
    return element.from != 0 || element.to != 0;
  };
  switch (link.kind) {
    case Kind::kJoint:
      return model_.joints[at(link.subject)].modes[at(static_cast<int>(state.joints[at(link.subject)].mode))].rows != 0;
    case Kind::kElement:
      return acts();
    case Kind::kContact:
    case Kind::kOneSided:  // engaged or not: with the true motion it might have been
      return acts();
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
