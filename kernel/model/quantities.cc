// Quantities of a model in words and units, and the quantities that conditions and sensors name by their own kinds.
#include "unlatch/quantities.h"

#include <array>

#include "kernel/math/index.h"
#include "kernel/model/validate.h"
#include "unlatch/readings.h"

namespace unlatch {
namespace {

using Kind = Quantity::Kind;

// Quantity of a kind of condition or sensor. `part`: its axis, or what this says.
struct Named {
  Kind kind = Kind::kTime;
  bool takes_axis = false;  // `part` is the condition's axis
  int part = Quantity::kSize;
};

// In the order of Condition::Kind; those of parts, and kQuantity, have none.
constexpr std::array<Named, 22> kConditions{{{Kind::kTime},
                                             {Kind::kReaction, true},
                                             {Kind::kDisplacement, true},
                                             {Kind::kAngle, true},
                                             {Kind::kSpeed, true},
                                             {Kind::kRate},
                                             {Kind::kSignal},
                                             {Kind::kCommand},
                                             {Kind::kMode, true},
                                             {},
                                             {},
                                             {},
                                             {Kind::kBurnt},
                                             {Kind::kClearance},
                                             {Kind::kClosed},
                                             {Kind::kReactionForce},
                                             {Kind::kReactionMoment},
                                             {Kind::kOneSidedForce},
                                             {Kind::kEngaged},
                                             {Kind::kReach},
                                             {Kind::kWound},
                                             {Kind::kBearing}}};
static_assert(kConditions.size() == static_cast<std::size_t>(Condition::Kind::kQuantity));

// In the order of Sensor::Kind; kQuantity has none.
constexpr std::array<Named, 12> kSensors{{{Kind::kPosition, false, Quantity::kAll},
                                          {Kind::kAttitude, false, Quantity::kAll},
                                          {Kind::kVelocity, false, Quantity::kAll},
                                          {Kind::kRate, false, Quantity::kAll},
                                          {Kind::kAcceleration, false, Quantity::kAll},
                                          {Kind::kSpecificForce, false, Quantity::kAll},
                                          {Kind::kSignal},
                                          {Kind::kReaction, false, Quantity::kAll},
                                          {Kind::kDisplacement, true},
                                          {Kind::kAngle, true},
                                          {Kind::kSpeed, true},
                                          {Kind::kClearance}}};
static_assert(kSensors.size() == static_cast<std::size_t>(Sensor::Kind::kQuantity));

using enum ConditionCourse;
using At = ConditionAtKnots;

constexpr std::array<ConditionTraits, kConditions.size() + 1> kConditionTraits{{
    // kind, course, at knots, by guards
    {Condition::Kind::kTime, kOneWay, At::kTime, true},
    {Condition::Kind::kReaction, kCurve, At::kRow, true},
    {Condition::Kind::kDisplacement, kCurve, At::kCoordinates, true},
    {Condition::Kind::kAngle, kCurve, At::kCoordinates, true},
    {Condition::Kind::kSpeed, kCurve, At::kSpeeds, true},
    {Condition::Kind::kBodyRate, kCurve, At::kRates, false},
    {Condition::Kind::kSignal, kSteps, At::kSignals, true},
    {Condition::Kind::kCommand, kSteps, At::kCommands, false},
    {Condition::Kind::kMode, kSteps, At::kModes, true},
    {Condition::Kind::kAll, kParts, At::kInParts, true},
    {Condition::Kind::kAny, kParts, At::kInParts, true},
    {Condition::Kind::kNot, kParts, At::kInParts, true},
    {Condition::Kind::kBurnt, kOneWay, At::kNowhere, false},
    {Condition::Kind::kDistance, kCurve, At::kNowhere, false},
    {Condition::Kind::kClosed, kSteps, At::kNowhere, true},
    {Condition::Kind::kForceSize, kCurve, At::kForceRows, false},
    {Condition::Kind::kMomentSize, kCurve, At::kMomentRows, false},
    {Condition::Kind::kOneSidedForce, kCurve, At::kNowhere, false},
    {Condition::Kind::kEngaged, kSteps, At::kEngaged, true},
    {Condition::Kind::kReach, kCurve, At::kNowhere, true},
    {Condition::Kind::kWound, kCurve, At::kNowhere, false},
    {Condition::Kind::kBearing, kCurve, At::kNowhere, false},
    {Condition::Kind::kQuantity, kCurve, At::kQuantities, false},
}};
constexpr bool are_in_order() {
  for (std::size_t i = 0; i < kConditionTraits.size(); ++i)
    if (static_cast<std::size_t>(kConditionTraits[i].kind) != i) return false;
  return true;
}
static_assert(are_in_order());

bool is_angular(const Model& model, const Quantity& quantity, const QuantityTraits& traits) {
  switch (traits.values) {
    case QuantityValues::kOfRow:
    case QuantityValues::kOfTurnRow:
    case QuantityValues::kRowValues:
      return quantity.part >= kRotX;
    case QuantityValues::kQuaternion:
      return quantity.part == Quantity::kSize;
    default:
      break;
  }
  if (traits.of == SubjectOf::kElement)
    return is_index(quantity.subject, at(model.element_count())) && describe_element(model, quantity.subject).angular;
  if (traits.of != SubjectOf::kOneSided) return false;
  const OneSided& force = model.one_sided[at(quantity.subject)];
  return force.joint != kNone && force.axis >= kRotX;
}

std::string name_event(const Event& event) { return event.name + (event.subject.empty() ? "" : ":" + event.subject); }

// What follows the subject: its part, or the direction.
std::string describe_part(const Quantity& quantity, const QuantityTraits& traits) {
  if (traits.has_axes) return "";
  if (!quantity.direction.isZero(0)) return " along " + show(quantity.direction);
  if (quantity.part < 0 || count_values(traits) == 1) return "";
  const bool attitude = traits.values == QuantityValues::kQuaternion;
  if (traits.values == QuantityValues::kVector) return std::string(", ") + get_component_name(traits, quantity.part);
  return std::string(", ") + (attitude && quantity.part == 0 ? "w" : kRowNames[quantity.part - (attitude ? 1 : 0)]);
}

}  // namespace

const ConditionTraits& get_traits(Condition::Kind kind) noexcept {
  return kConditionTraits[static_cast<std::size_t>(kind)];
}

bool is_size(const Quantity& quantity) noexcept {
  return get_traits(quantity.kind).values == QuantityValues::kVector && quantity.part == Quantity::kSize &&
         quantity.direction.isZero();
}

Quantity get_quantity(const Model& model, const Condition& condition) {
  if (condition.kind == Condition::Kind::kQuantity) return model.quantities[at(condition.subject)];
  const Named& named = kConditions[static_cast<std::size_t>(condition.kind)];
  Quantity out;
  out.kind = named.kind;
  out.subject = condition.subject;
  out.other = get_traits(named.kind).other == SubjectOf::kSurface ? condition.axis : kGround;
  out.part = named.takes_axis ? condition.axis : named.part;
  return out;
}

Quantity get_quantity(const Model& model, const Sensor& sensor) {
  if (sensor.kind == Sensor::Kind::kQuantity)
    return is_index(sensor.subject, model.quantities.size()) ? model.quantities[at(sensor.subject)] : Quantity{};
  const Named& named = kSensors[static_cast<std::size_t>(sensor.kind)];
  Quantity out;
  out.kind = named.kind;
  out.subject = sensor.subject;
  out.other = get_traits(named.kind).other == SubjectOf::kSurface ? sensor.other : kGround;
  out.part = named.takes_axis ? sensor.axis : named.part;
  out.point = sensor.point;
  return out;
}

std::string get_unit(const Model& model, const Quantity& quantity) {
  const QuantityTraits& traits = get_traits(quantity.kind);
  // A subject that was misspelt has no number: the unit is that of its kind.
  if (traits.of == SubjectOf::kChannel && is_index(quantity.subject, model.channels.size())) {
    const std::string& unit = model.channels[at(quantity.subject)].unit;
    return unit.empty() ? traits.unit : unit;
  }
  if (traits.of == SubjectOf::kLaw && is_index(quantity.subject, model.laws.size()))
    return model.laws[at(quantity.subject)].unit;
  return traits.angular_unit != nullptr && is_angular(model, quantity, traits) ? traits.angular_unit : traits.unit;
}

std::string get_subject_name(const Model& model, SubjectOf of, int subject) {
  const auto i = at(subject);
  switch (of) {
    case SubjectOf::kNothing:
      return "";
    case SubjectOf::kBody:
    case SubjectOf::kMassLaw:
      return subject == kGround ? "ground" : model.bodies[i].name;
    case SubjectOf::kJoint:
      return model.joints[i].name;
    case SubjectOf::kSurface:
      return model.surfaces[i].name;
    case SubjectOf::kContact:
      return model.contacts[i].name;
    case SubjectOf::kElement:
      return model.element_name(subject);
    case SubjectOf::kOneSided:
    case SubjectOf::kCord:
      return model.one_sided[i].name;
    case SubjectOf::kSignal:
      return model.signals[i];
    case SubjectOf::kChannel:
      return model.channels[i].name;
    case SubjectOf::kEvent:
      return name_event(model.events[i]);
    case SubjectOf::kLaw:
      return model.laws[i].name;
  }
  return "";
}

std::size_t count_subjects(const Model& model, SubjectOf of) {
  switch (of) {
    case SubjectOf::kNothing:
      return 0;
    case SubjectOf::kBody:
    case SubjectOf::kMassLaw:
      return model.bodies.size();
    case SubjectOf::kJoint:
      return model.joints.size();
    case SubjectOf::kSurface:
      return model.surfaces.size();
    case SubjectOf::kContact:
      return model.contacts.size();
    case SubjectOf::kElement:
      return at(model.element_count());
    case SubjectOf::kOneSided:
    case SubjectOf::kCord:
      return model.one_sided.size();
    case SubjectOf::kSignal:
      return model.signals.size();
    case SubjectOf::kChannel:
      return model.channels.size();
    case SubjectOf::kEvent:
      return model.events.size();
    case SubjectOf::kLaw:
      return model.laws.size();
  }
  return 0;
}

std::string describe(const Model& model, const Quantity& quantity, bool names_joint) {
  const QuantityTraits& traits = get_traits(quantity.kind);
  const std::string subject = get_subject_name(model, traits.of, quantity.subject);
  if (traits.values == QuantityValues::kOfMode)
    return subject + " is " + model.joints[at(quantity.subject)].modes[at(quantity.part)].name;
  if (quantity.kind == Kind::kEngaged) return subject + " acts";
  const bool of_row = traits.of == SubjectOf::kJoint && traits.values != QuantityValues::kVector;
  std::string text = traits.phrase;
  if (of_row) return text + " " + kRowNames[quantity.part] + (names_joint ? " of " + subject : "");
  if (!subject.empty()) text += " " + subject;
  const bool pair = traits.other == SubjectOf::kSurface;
  if (pair || (traits.other == SubjectOf::kBody && quantity.other != kGround))
    text += (pair ? " and " : " relative to ") + get_subject_name(model, traits.other, quantity.other);
  return text + describe_part(quantity, traits);
}

}  // namespace unlatch
