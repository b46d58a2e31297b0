#include "hil/run/audit/speed_readers.h"

#include <algorithm>
#include <set>

#include "hil/run/audit/dependence.h"
#include "hil/scenario/base/index.h"
#include "unlatch/model/subjects.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

// True if any quantity that a condition compares is such a one.
template <class Is>
bool any_quantity(const Model& model, const Condition& condition, const Is& is) {
  if (condition.parts.empty()) return is(get_quantity(model, condition));
  return std::ranges::any_of(condition.parts, [&](const Condition& part) { return any_quantity(model, part, is); });
}

// Some mode of it has rows: others only measure.
bool holds(const Joint& joint) {
  return std::ranges::any_of(joint.modes, [](const JointMode& mode) { return mode.rows != 0; });
}

}  // namespace

SpeedReaders::SpeedReaders(const Model& model, int spring, int body)
    : model_(&model),
      spring_(spring),
      body_(body),
      joint_(spring == kNone ? kNone : describe_element(model, spring).joint),
      whole_(find_groups(kNone, kNone)),
      parts_(find_groups(joint_, body_)),
      looped_(is_in_loop()) {}

std::size_t SpeedReaders::find_node(int body) const {
  return body == kGround ? model_->bodies.size() : at(find_carrier(*model_, body));
}

std::vector<std::size_t> SpeedReaders::find_groups(int joint, int body) const {
  std::vector<std::size_t> groups(model_->bodies.size() + 1);
  for (std::size_t i = 0; i < groups.size(); ++i) groups[i] = i;
  for (std::size_t j = 0; j < model_->joints.size(); ++j) {
    const std::size_t base = find_node(model_->joints[j].base), follower = find_node(model_->joints[j].follower);
    if (static_cast<int>(j) == joint || (static_cast<int>(j) != joint_ && !holds(model_->joints[j]))) continue;
    if (body != kNone && (base == at(body) || follower == at(body))) continue;
    std::ranges::replace(groups, groups[base], groups[follower]);
  }
  return groups;
}

// Two ways lead from one side of the joint to the other, or away from the body and back.
bool SpeedReaders::is_in_loop() const {
  std::set<std::size_t> sides;
  for (std::size_t j = 0; j < model_->joints.size(); ++j) {
    const std::size_t base = find_node(model_->joints[j].base), follower = find_node(model_->joints[j].follower);
    if (static_cast<int>(j) == joint_) return parts_[base] == parts_[follower];
    if (body_ == kNone || !holds(model_->joints[j]) || base == follower || (base != at(body_) && follower != at(body_)))
      continue;
    if (!sides.insert(parts_[base == at(body_) ? follower : base]).second) return true;
  }
  return false;
}

bool SpeedReaders::is_between(int a, int b) const {
  const std::size_t one = find_node(a), other = find_node(b);
  if (body_ != kNone && (one == at(body_) || other == at(body_))) return true;
  if (one == other || whole_[one] != whole_[other]) return false;
  if (!looped_) return parts_[one] != parts_[other];
  return whole_[one] == whole_[body_ != kNone ? at(body_) : find_node(model_->joints[at(joint_)].follower)];
}

// One body moves beside the ground.
bool SpeedReaders::is_among(const std::vector<int>& bodies) const {
  if (bodies.size() == 1) return is_between(kGround, bodies.front());
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (is_between(bodies[k], bodies[i])) return true;
  return false;
}

bool SpeedReaders::is_read_by(const unlatch::Quantity& quantity) const {
  const QuantityTraits& traits = get_traits(quantity.kind);
  if (traits.motion == QuantityMotion::kOfAll) return true;
  const bool is_own_force =
      traits.motion == QuantityMotion::kForces && traits.of == SubjectOf::kElement && quantity.subject == spring_;
  if (is_own_force || (traits.motion != QuantityMotion::kSpeeds && traits.motion != QuantityMotion::kForces))
    return false;
  std::vector<int> bodies = list_subject_bodies(*model_, traits.of, quantity.subject);
  for (const int body : list_subject_bodies(*model_, traits.other, quantity.other)) bodies.push_back(body);
  return is_among(bodies);
}

bool SpeedReaders::is_read_by_elements() const {
  const std::vector<Subjects> elements = list_element_subjects(*model_);
  for (int element = 0; at(element) < elements.size(); ++element) {
    const Subjects& own = elements[at(element)];
    if (!own.reads_speed || element == spring_) continue;
    // Of a flexible body's own frame, the motion is judged by itself; its shape moves markers.
    if (own.bodies.size() == 1 && own.bodies.front() == body_) continue;
    if (is_among(own.bodies)) return true;
  }
  return false;
}

// A joint that locks takes its bodies' speeds in one blow.
bool SpeedReaders::is_read_by_locks(const State& state) const {
  for (std::size_t e = 0; e < model_->events.size(); ++e) {
    const unlatch::Event& event = model_->events[e];
    if (!event.repeat && state.events[e].phase != EventPhase::kSpent) continue;
    for (const Action& action : event.then) {
      if (action.kind != Action::Kind::kSetMode) continue;
      const Joint& joint = model_->joints[at(action.subject)];
      if (joint.modes[at(action.mode)].rows != 0 && is_between(joint.base, joint.follower)) return true;
    }
  }
  return false;
}

bool SpeedReaders::is_read(const State& state) const {
  const auto reads = [&](const unlatch::Quantity& quantity) { return is_read_by(quantity); };
  return std::ranges::any_of(model_->quantities, reads) ||
         std::ranges::any_of(model_->sensors,
                             [&](const Sensor& sensor) { return reads(get_quantity(*model_, sensor)); }) ||
         std::ranges::any_of(model_->events,
                             [&](const unlatch::Event& event) { return any_quantity(*model_, event.when, reads); }) ||
         is_read_by_elements() || is_read_by_locks(state);
}

bool SpeedReaders::is_read_by(const Requirement& requirement) const {
  using Measure = Requirement::Measure;
  switch (requirement.quantity) {
    case Measure::kClearance:
    case Measure::kPosition:
    case Measure::kDisplacement:
    case Measure::kAngle:
    case Measure::kAxes:
      return false;
    case Measure::kTime:  // guards, sensors and quantities make the bodies unresolved
    case Measure::kOrder:
    case Measure::kSensor:
    case Measure::kQuantity:
      return false;
    case Measure::kSpeed:
    case Measure::kReaction:
    case Measure::kVelocity:
    case Measure::kRate:
    case Measure::kContact:
      break;
  }
  return is_among(list_own_bodies(*model_, requirement));
}

}  // namespace unlatch::hil
