#include "hil/run/audit/dependence.h"

#include <algorithm>
#include <set>
#include <utility>

#include "hil/scenario/base/index.h"
#include "unlatch/model/subjects.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

// Of its one or two subjects.
std::vector<int> list_own_bodies(const Model& model, const unlatch::Quantity& quantity) {
  const QuantityTraits& traits = get_traits(quantity.kind);
  std::vector<int> bodies = list_subject_bodies(model, traits.of, quantity.subject);
  for (const int body : list_subject_bodies(model, traits.other, quantity.other)) bodies.push_back(body);
  return bodies;
}

// Gathers bodies; each law and event is followed once, so that a circle of them ends.
class BodyList {
 public:
  explicit BodyList(const Model& model) : model_(model) {}

  void add(int body) { bodies_.insert(find_carrier(model_, body)); }
  void add(const std::vector<int>& bodies) {
    for (const int body : bodies) add(body);
  }
  void add_law(int law);
  void add_law(const unlatch::Law& law);
  void add_quantity(const unlatch::Quantity& quantity);
  void add_guard(int event);
  void add_guard(const Condition& condition);
  void add_raisers(int signal);

  [[nodiscard]] std::vector<int> get() const { return {bodies_.begin(), bodies_.end()}; }

 private:
  void add_through(SubjectOf of, int subject);

  const Model& model_;
  std::set<int> bodies_, laws_, events_, signals_;
};

void BodyList::add_law(int law) {
  if (laws_.insert(law).second) add_law(model_.laws[at(law)]);
}

void BodyList::add_law(const unlatch::Law& law) {
  for (const int quantity : list_law_subjects(model_, law).quantities) add_quantity(model_.quantities[at(quantity)]);
}

void BodyList::add_quantity(const unlatch::Quantity& quantity) {
  const QuantityTraits& traits = get_traits(quantity.kind);
  switch (traits.motion) {
    case QuantityMotion::kOfAll:
      return add(list_all_bodies(model_));
    case QuantityMotion::kOfNone:
      return;
    case QuantityMotion::kPlaces:
    case QuantityMotion::kSpeeds:
    case QuantityMotion::kForces:
      return add(list_own_bodies(model_, quantity));
    case QuantityMotion::kThrough:
      return add_through(traits.of, quantity.subject);
  }
}

void BodyList::add_through(SubjectOf of, int subject) {
  if (of == SubjectOf::kLaw) return add_law(subject);
  if (of == SubjectOf::kEvent) return add_guard(subject);
  if (of == SubjectOf::kSignal) return add_raisers(subject);
  add(list_all_bodies(model_));
}

void BodyList::add_guard(int event) {
  if (events_.insert(event).second) add_guard(model_.events[at(event)].when);
}

void BodyList::add_guard(const Condition& condition) {
  for (const Condition& part : condition.parts) add_guard(part);
  if (condition.parts.empty()) add_quantity(get_quantity(model_, condition));
}

// Events that raise or lower a signal.
void BodyList::add_raisers(int signal) {
  if (!signals_.insert(signal).second) return;
  for (std::size_t i = 0; i < model_.events.size(); ++i)
    for (const Action& action : model_.events[i].then)
      if (action.kind == Action::Kind::kRaise && action.subject == signal) add_guard(static_cast<int>(i));
}

// True for an event at a given time, which no motion changes.
bool is_timed(const Model& model, const EventName& name) {
  return !name.is_named() || name.event == kNone || model.events[at(name.event)].when.kind == Condition::Kind::kTime;
}

// A command decides its value, directly or through laws.
bool reads_command(const Model& model, const unlatch::Quantity& quantity, std::set<int>& seen) {
  const QuantityTraits& traits = get_traits(quantity.kind);
  if (traits.of != SubjectOf::kLaw) return (traits.reads & kReadsInputs) != 0;
  if (!seen.insert(quantity.subject).second) return false;
  const Subjects subjects = list_law_subjects(model, model.laws[at(quantity.subject)]);
  return !subjects.channels.empty() || std::ranges::any_of(subjects.quantities, [&](int own) {
    return reads_command(model, model.quantities[at(own)], seen);
  });
}

bool reads_command(const Model& model, int law) {
  std::set<int> seen;
  return reads_command(model, {.name = "", .kind = unlatch::Quantity::Kind::kLaw, .subject = law}, seen);
}

bool reads_command(const Model& model, const Condition& condition) {
  std::set<int> seen;
  if (condition.parts.empty()) return reads_command(model, get_quantity(model, condition), seen);
  return std::ranges::any_of(condition.parts, [&](const Condition& part) { return reads_command(model, part); });
}

}  // namespace

int find_carrier(const Model& model, int body) {
  const Body& own = model.bodies[at(body)];
  return own.marker ? own.marker->body : body;
}

std::vector<int> list_pair(const Model& model, int base, int follower) {
  std::vector<int> bodies;
  if (base != kGround) bodies.push_back(find_carrier(model, base));
  if (follower != kGround) bodies.push_back(find_carrier(model, follower));
  return bodies;
}

std::vector<int> list_all_bodies(const Model& model) {
  std::vector<int> bodies(model.bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b] = static_cast<int>(b);
  return bodies;
}

std::vector<int> list_joint_bodies(const Model& model, int joint) {
  return list_pair(model, model.joints[at(joint)].base, model.joints[at(joint)].follower);
}

std::vector<int> list_contact_bodies(const Model& model, int contact) {
  const Contact& own = model.contacts[at(contact)];
  return list_pair(model, model.surfaces[at(own.base)].body, model.surfaces[at(own.follower)].body);
}

std::vector<int> list_read_bodies(const Model& model, const unlatch::Law& law) {
  BodyList list(model);
  list.add_law(law);
  return list.get();
}

std::vector<int> list_guard_bodies(const Model& model, const unlatch::Event& event) {
  BodyList list(model);
  list.add_guard(event.when);
  return list.get();
}

std::vector<int> list_driven_bodies(const Model& model, const unlatch::Event& event) {
  BodyList list(model);
  for (const Action& action : event.then) list.add(list_action_bodies(model, action));
  return list.get();
}

std::vector<int> list_sensed_bodies(const Model& model) {
  BodyList list(model);
  for (const Sensor& sensor : model.sensors) list.add_quantity(get_quantity(model, sensor));
  return list.get();
}

std::vector<int> list_commanded_bodies(const Model& model) {
  BodyList list(model);
  for (const Subjects& subjects : list_element_subjects(model))
    if (!subjects.channels.empty() ||
        std::ranges::any_of(subjects.laws, [&](int law) { return reads_command(model, law); }))
      list.add(subjects.bodies);
  for (const Impulse& impulse : model.impulses)
    if (impulse.channel != kNone) list.add(impulse.body);
  for (const unlatch::Event& event : model.events)
    if (reads_command(model, event.when)) list.add(list_driven_bodies(model, event));
  return list.get();
}

std::vector<int> list_own_bodies(const Model& model, const Requirement& requirement) {
  using Measure = Requirement::Measure;
  switch (requirement.quantity) {
    case Measure::kClearance:
    case Measure::kRate:
    case Measure::kVelocity:
    case Measure::kPosition:
    case Measure::kAxes:
      return list_pair(model, requirement.a, requirement.b);
    case Measure::kReaction:
    case Measure::kDisplacement:
    case Measure::kAngle:
    case Measure::kSpeed:
      return list_joint_bodies(model, requirement.a);
    case Measure::kContact:
      return list_contact_bodies(model, requirement.a);
    default:
      return list_all_bodies(model);
  }
}

std::vector<int> list_bodies(const Model& model, const Requirement& requirement) {
  const bool timed =
      is_timed(model, requirement.at) && is_timed(model, requirement.from) && is_timed(model, requirement.to);
  return timed ? list_own_bodies(model, requirement) : list_all_bodies(model);
}

}  // namespace unlatch::hil
