#include "hil/run/audit/dependence.h"

#include <algorithm>
#include <set>
#include <utility>

#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

// Gathers bodies; each law and event is followed once, so that a circle of them ends.
class BodyList {
 public:
  explicit BodyList(const Model& model) : model_(model) {}

  void add(int body) {
    if (body != kGround) bodies_.insert(find_carrier(model_, body));
  }
  void add(const std::vector<int>& bodies) {
    for (const int body : bodies) add(body);
  }
  void add_joint(int joint) {
    add(model_.joints[at(joint)].base);
    add(model_.joints[at(joint)].follower);
  }
  void add_surface(int surface) { add(model_.surfaces[at(surface)].body); }
  void add_contact(int contact) {
    add_surface(model_.contacts[at(contact)].base);
    add_surface(model_.contacts[at(contact)].follower);
  }
  void add_one_sided(int number) { add(list_element_bodies(model_, get_first_one_sided(model_) + number)); }
  void add_law(int law);
  void add_law(const unlatch::Law& law);
  void add_quantity(const unlatch::Quantity& quantity);
  void add_guard(int event);
  void add_guard(const Condition& condition);
  void add_raisers(int signal);
  void add_sensor(const Sensor& sensor);

  [[nodiscard]] std::vector<int> get() const { return {bodies_.begin(), bodies_.end()}; }

 private:
  const Model& model_;
  std::set<int> bodies_, laws_, events_, signals_;
};

void BodyList::add_law(int law) {
  if (laws_.insert(law).second) add_law(model_.laws[at(law)]);
}

void BodyList::add_law(const unlatch::Law& law) {
  for (const LawStep& step : law.steps)
    if (step.kind == LawStep::Kind::kQuantity) add_quantity(model_.quantities[at(step.subject)]);
}

void BodyList::add_quantity(const unlatch::Quantity& quantity) {
  using Kind = unlatch::Quantity::Kind;
  const Kind kind = quantity.kind;
  const auto is_within = [kind](Kind first, Kind last) { return kind >= first && kind <= last; };
  if (kind == Kind::kTime || kind == Kind::kCommand) return;
  if (kind == Kind::kSince) return add_guard(quantity.subject);
  if (kind == Kind::kSignal) return add_raisers(quantity.subject);
  if (kind == Kind::kLaw) return add_law(quantity.subject);
  if (is_within(Kind::kPosition, Kind::kAxes) || is_within(Kind::kOrbitPosition, Kind::kOrbitVelocity))
    return add(list_pair(model_, quantity.subject, quantity.other));
  if (is_within(Kind::kAcceleration, Kind::kBurnt) || is_within(Kind::kAltitude, Kind::kLaunchVelocity))
    return add(quantity.subject);
  if (is_within(Kind::kDisplacement, Kind::kMode)) return add_joint(quantity.subject);
  if (is_within(Kind::kContactForce, Kind::kClosed)) return add_contact(quantity.subject);
  if (is_within(Kind::kForce, Kind::kScale) || kind == Kind::kOnTime)
    return add(list_element_bodies(model_, quantity.subject));
  if (is_within(Kind::kOneSidedForce, Kind::kBearing)) return add_one_sided(quantity.subject);
  if (kind == Kind::kClearance) {
    add_surface(quantity.subject);
    return add_surface(quantity.other);
  }
  add(list_all_bodies(model_));
}

void BodyList::add_guard(int event) {
  if (events_.insert(event).second) add_guard(model_.events[at(event)].when);
}

void BodyList::add_guard(const Condition& condition) {
  using Kind = Condition::Kind;
  switch (condition.kind) {
    case Kind::kTime:
    case Kind::kCommand:
      return;
    case Kind::kAll:
    case Kind::kAny:
    case Kind::kNot:
      for (const Condition& part : condition.parts) add_guard(part);
      return;
    case Kind::kSignal:
      return add_raisers(condition.subject);
    case Kind::kReaction:
    case Kind::kDisplacement:
    case Kind::kAngle:
    case Kind::kSpeed:
    case Kind::kMode:
    case Kind::kForceSize:
    case Kind::kMomentSize:
      return add_joint(condition.subject);
    case Kind::kBodyRate:
    case Kind::kBurnt:
      return add(condition.subject);
    case Kind::kDistance:
      add_surface(condition.subject);
      return add_surface(condition.axis);
    case Kind::kClosed:
      return add_contact(condition.subject);
    case Kind::kOneSidedForce:
    case Kind::kEngaged:
    case Kind::kReach:
    case Kind::kWound:
    case Kind::kBearing:
      return add_one_sided(condition.subject);
    case Kind::kQuantity:
      return add_quantity(model_.quantities[at(condition.subject)]);
  }
}

// Events that raise or lower a signal.
void BodyList::add_raisers(int signal) {
  if (!signals_.insert(signal).second) return;
  for (std::size_t i = 0; i < model_.events.size(); ++i)
    for (const Action& action : model_.events[i].then)
      if (action.kind == Action::Kind::kRaise && action.subject == signal) add_guard(static_cast<int>(i));
}

void BodyList::add_sensor(const Sensor& sensor) {
  switch (sensor.kind) {
    case Sensor::Kind::kPosition:
    case Sensor::Kind::kAttitude:
    case Sensor::Kind::kVelocity:
    case Sensor::Kind::kRate:
    case Sensor::Kind::kAcceleration:
    case Sensor::Kind::kSpecificForce:
      return add(sensor.subject);
    case Sensor::Kind::kContact:
      return add_raisers(sensor.subject);
    case Sensor::Kind::kReaction:
    case Sensor::Kind::kDisplacement:
    case Sensor::Kind::kAngle:
    case Sensor::Kind::kSpeed:
      return add_joint(sensor.subject);
    case Sensor::Kind::kDistance:
      add_surface(sensor.subject);
      return add_surface(sensor.other);
    case Sensor::Kind::kQuantity:
      return add_quantity(model_.quantities[at(sensor.subject)]);
  }
}

// True for an event at a given time, which no motion changes.
bool is_timed(const Model& model, const EventName& name) {
  return !name.is_named() || name.event == kNone || model.events[at(name.event)].when.kind == Condition::Kind::kTime;
}

bool reads_command(const Model& model, const unlatch::Law& law, std::set<const unlatch::Law*>& seen) {
  if (!seen.insert(&law).second) return false;
  if (law.scale_channel != kNone || law.offset_channel != kNone) return true;
  return std::ranges::any_of(law.steps, [&](const LawStep& step) {
    if (step.kind == LawStep::Kind::kCommand) return true;
    if (step.kind == LawStep::Kind::kTable) {
      const Table& table = model.tables[at(step.subject)];
      return table.scale_channel != kNone || table.offset_channel != kNone;
    }
    if (step.kind != LawStep::Kind::kQuantity) return false;
    const unlatch::Quantity& quantity = model.quantities[at(step.subject)];
    if (quantity.kind == unlatch::Quantity::Kind::kCommand) return true;
    return quantity.kind == unlatch::Quantity::Kind::kLaw &&
           reads_command(model, model.laws[at(quantity.subject)], seen);
  });
}

bool reads_command(const Model& model, int law) {
  std::set<const unlatch::Law*> seen;
  return law != kNone && reads_command(model, model.laws[at(law)], seen);
}

bool reads_speed(const Condition& condition, int joint) {
  if (condition.kind == Condition::Kind::kSpeed) return condition.subject == joint;
  return std::ranges::any_of(condition.parts, [joint](const Condition& part) { return reads_speed(part, joint); });
}

bool reads_command(const Model& model, const Condition& condition) {
  if (condition.kind == Condition::Kind::kCommand) return true;
  if (condition.kind == Condition::Kind::kQuantity) {
    const unlatch::Quantity& quantity = model.quantities[at(condition.subject)];
    return quantity.kind == unlatch::Quantity::Kind::kCommand ||
           (quantity.kind == unlatch::Quantity::Kind::kLaw && reads_command(model, quantity.subject));
  }
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
  for (const Action& action : event.then) {
    switch (action.kind) {
      case Action::Kind::kSetMode:
        list.add_joint(action.subject);
        break;
      case Action::Kind::kSwitch:
      case Action::Kind::kRamp:
        list.add(list_element_bodies(model, action.subject));
        break;
      case Action::Kind::kImpulse:
        list.add(model.impulses[at(action.subject)].body);
        break;
      case Action::Kind::kRaise:   // who waits for it reads it as part of his guard
      case Action::Kind::kEngage:  // by the element's own two bodies
        break;
    }
  }
  return list.get();
}

std::vector<int> list_sensed_bodies(const Model& model) {
  BodyList list(model);
  for (const Sensor& sensor : model.sensors) list.add_sensor(sensor);
  return list.get();
}

std::vector<int> list_commanded_bodies(const Model& model) {
  BodyList list(model);
  for (const Load& load : model.loads)
    if (load.channel != kNone || reads_command(model, load.profile.law)) list.add(load.body);
  for (const Aerodynamics& air : model.aerodynamics)
    if (std::ranges::any_of(air.terms, [&](const AeroTerm& term) { return reads_command(model, term.law); }))
      list.add(air.body);
  for (const Impulse& impulse : model.impulses)
    if (impulse.channel != kNone) list.add(impulse.body);
  for (const unlatch::Event& event : model.events)
    if (reads_command(model, event.when)) list.add(list_driven_bodies(model, event));
  return list.get();
}

bool reads_speed(const Model& model, int joint) {
  const auto is_speed = [joint](const auto& own) {
    return own.kind == std::remove_cvref_t<decltype(own)>::Kind::kSpeed && own.subject == joint;
  };
  return std::ranges::any_of(model.quantities, is_speed) || std::ranges::any_of(model.sensors, is_speed) ||
         std::ranges::any_of(model.events,
                             [joint](const unlatch::Event& event) { return reads_speed(event.when, joint); });
}

std::vector<int> list_bodies(const Model& model, const Requirement& requirement) {
  using Measure = Requirement::Measure;
  const bool timed =
      is_timed(model, requirement.at) && is_timed(model, requirement.from) && is_timed(model, requirement.to);
  if (!timed) return list_all_bodies(model);
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

}  // namespace unlatch::hil
