#include "hil/run/notices/unresolved_bodies.h"

#include <algorithm>
#include <utility>

#include "hil/scenario/base/index.h"
#include "unlatch/contacts.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

// Body that moves a body: of a marker its flexible body.
int find_carrier(const Model& model, int body) {
  const Body& own = model.bodies[at(body)];
  return own.marker ? own.marker->body : body;
}

std::vector<int> list_pair(int base, int follower) {
  std::vector<int> bodies;
  if (base != kGround) bodies.push_back(base);
  if (follower != kGround) bodies.push_back(follower);
  return bodies;
}

// True for an event at a given time, which no motion changes.
bool is_timed(const Model& model, const EventName& name) {
  return !name.is_named() || name.event == kNone || model.events[at(name.event)].when.kind == Condition::Kind::kTime;
}

// Bodies on whose motion a law depends; every body where its quantities do not name them.
std::vector<int> list_read_bodies(const Model& model, const unlatch::Law& law) {
  using Kind = unlatch::Quantity::Kind;
  std::vector<int> bodies;
  for (const LawStep& step : law.steps) {
    if (step.kind != LawStep::Kind::kQuantity) continue;
    const unlatch::Quantity& quantity = model.quantities[at(step.subject)];
    std::vector<int> read;
    if (quantity.kind == Kind::kTime || quantity.kind == Kind::kCommand) continue;
    if (quantity.kind >= Kind::kPosition && quantity.kind <= Kind::kAxes)
      read = list_pair(quantity.subject, quantity.other);
    else if (quantity.kind >= Kind::kAcceleration && quantity.kind <= Kind::kBurnt)
      read = {quantity.subject};
    else if (quantity.kind >= Kind::kDisplacement && quantity.kind <= Kind::kReactionMoment)
      read = list_pair(model.joints[at(quantity.subject)].base, model.joints[at(quantity.subject)].follower);
    else
      return list_all_bodies(model);
    bodies.insert(bodies.end(), read.begin(), read.end());
  }
  return bodies;
}

}  // namespace

std::vector<int> list_contact_bodies(const Model& model, int contact) {
  const Contact& own = model.contacts[at(contact)];
  return list_pair(model.surfaces[at(own.base)].body, model.surfaces[at(own.follower)].body);
}

std::vector<int> list_all_bodies(const Model& model) {
  std::vector<int> bodies(model.bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b] = static_cast<int>(b);
  return bodies;
}

UnresolvedBodies::UnresolvedBodies(const Model& model, const Plan& plan)
    : model_(model), plan_(plan), bodies_(model.bodies.size()) {}

void UnresolvedBodies::add(std::span<const int> bodies, const std::string& cause, double time, const State& state) {
  bool is_new = false;
  for (const int body : bodies) {
    Entry& entry = bodies_[at(find_carrier(model_, body))];
    if (entry.time != kNever) continue;
    entry = {time, cause};
    is_new = true;
  }
  first_ = std::min(first_, time);
  if (is_new) spread(state, time);
}

// Pairs of bodies that joints or acting elements connect now; those with the ground have one body.
std::vector<std::vector<int>> UnresolvedBodies::list_links(const State& state, double time) const {
  std::vector<std::vector<int>> links;
  const auto link_joint = [&](int joint) {
    links.push_back(list_pair(model_.joints[at(joint)].base, model_.joints[at(joint)].follower));
  };
  for (std::size_t j = 0; j < model_.joints.size(); ++j)
    if (model_.joints[j].modes[at(static_cast<int>(state.joints[j].mode))].rows != 0) link_joint(static_cast<int>(j));
  const auto acts = [&](std::size_t element) { return calc_scale(state.elements[element], time) != 0; };
  for (std::size_t i = 0; i < model_.loads.size(); ++i) {
    const Load& load = model_.loads[i];
    if (load.profile.law == kNone || !acts(i)) continue;
    for (const int body : list_read_bodies(model_, model_.laws[at(load.profile.law)]))
      links.push_back(list_pair(body, load.body));
  }
  std::size_t element = model_.loads.size();
  for (const PointSpring& spring : model_.point_springs)
    if (acts(element++)) links.push_back(list_pair(spring.base, spring.follower));
  for (const JointSpring& spring : model_.joint_springs)
    if (acts(element++)) link_joint(spring.joint);
  for (const PlaneTorsion& torsion : model_.plane_torsions)
    if (acts(element++)) links.push_back(list_pair(torsion.base, torsion.follower));
  for (std::size_t i = 0; i < model_.contacts.size(); ++i) {
    const std::span<const ContactState> pairs = get_contact_pairs(plan_, state, static_cast<int>(i));
    const bool closed = std::ranges::any_of(pairs, [](const ContactState& pair) { return pair.closed != 0; });
    if (acts(element++) && closed) links.push_back(list_contact_bodies(model_, static_cast<int>(i)));
  }
  for (std::size_t i = 0; i < model_.one_sided.size(); ++i) {
    const OneSided& force = model_.one_sided[i];
    if (!acts(element++) || state.engaged[i] == 0) continue;
    if (force.joint != kNone)
      link_joint(force.joint);
    else
      links.push_back(list_pair(force.base, force.follower));
  }
  return links;
}

void UnresolvedBodies::spread(const State& state, double time) {
  if (is_empty()) return;
  const std::vector<std::vector<int>> links = list_links(state, time);
  for (bool changes = true; changes;) {
    changes = false;
    for (const std::vector<int>& link : links) {
      if (link.size() < 2) continue;
      Entry& base = bodies_[at(find_carrier(model_, link[0]))];
      Entry& follower = bodies_[at(find_carrier(model_, link[1]))];
      if ((base.time == kNever) == (follower.time == kNever)) continue;
      if (base.time == kNever)
        base = {time, follower.cause};
      else
        follower = {time, base.cause};
      changes = true;
    }
  }
}

// Bodies on which a value depends; every body where the quantity does not name them.
std::vector<int> UnresolvedBodies::list_bodies(const Requirement& requirement) const {
  using Measure = Requirement::Measure;
  const bool timed =
      is_timed(model_, requirement.at) && is_timed(model_, requirement.from) && is_timed(model_, requirement.to);
  if (!timed) return list_all_bodies(model_);
  switch (requirement.quantity) {
    case Measure::kClearance:
    case Measure::kRate:
    case Measure::kVelocity:
    case Measure::kPosition:
    case Measure::kAxes:
      return list_pair(requirement.a, requirement.b);
    case Measure::kReaction:
    case Measure::kDisplacement:
    case Measure::kAngle:
    case Measure::kSpeed: {
      const Joint& joint = model_.joints[at(requirement.a)];
      return list_pair(joint.base, joint.follower);
    }
    case Measure::kContact:
      return list_contact_bodies(model_, requirement.a);
    default:
      return list_all_bodies(model_);
  }
}

std::string UnresolvedBodies::find_cause(const Requirement& requirement, double until) const {
  if (is_empty()) return "";
  const Entry* first = nullptr;
  for (const int body : list_bodies(requirement)) {
    const Entry& entry = bodies_[at(find_carrier(model_, body))];
    if (entry.time <= until && (first == nullptr || entry.time < first->time)) first = &entry;
  }
  return first == nullptr || first->time == kNever ? "" : first->cause;
}

}  // namespace unlatch::hil
