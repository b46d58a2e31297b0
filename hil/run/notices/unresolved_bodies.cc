#include "hil/run/notices/unresolved_bodies.h"

#include <algorithm>
#include <utility>

#include "hil/scenario/model/index.h"
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

UnresolvedBodies::UnresolvedBodies(const Model& model) : model_(model), bodies_(model.bodies.size()) {}

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

void UnresolvedBodies::spread(const State& state, double time) {
  if (is_empty()) return;
  for (bool changes = true; changes;) {
    changes = false;
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (joint.base == kGround || joint.follower == kGround ||
          joint.modes[at(static_cast<int>(state.joints[j].mode))].rows == 0)
        continue;
      Entry& base = bodies_[at(find_carrier(model_, joint.base))];
      Entry& follower = bodies_[at(find_carrier(model_, joint.follower))];
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
