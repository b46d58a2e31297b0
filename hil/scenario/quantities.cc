#include "hil/scenario/quantities.h"

#include <algorithm>

#include "hil/scenario/base/index.h"
#include "hil/scenario/scenario.h"
#include "hil/scenario/text/number_text.h"

namespace unlatch::hil {
namespace {

using QuantityKind = unlatch::Quantity::Kind;

bool is_written(const QuantityTraits& traits) {
  return traits.of != SubjectOf::kNothing && traits.kind != QuantityKind::kOneSidedForce &&
         traits.kind != QuantityKind::kReach && traits.kind != QuantityKind::kLaw;
}

std::string show(const Eigen::Vector3d& v) {
  return "[" + write_short(v.x()) + ", " + write_short(v.y()) + ", " + write_short(v.z()) + "]";
}

// A subject has what the kind reads.
bool is_fit(const Model& model, const unlatch::Quantity& quantity, const QuantityTraits& traits) {
  const std::size_t i = at(quantity.subject);
  if (traits.of_planet && !model.environment.planet) return false;
  if (traits.of_air && !model.environment.atmosphere) return false;
  if (traits.of == SubjectOf::kMassLaw) return model.bodies[i].law.has_value();
  if (traits.of == SubjectOf::kCord) return model.one_sided[i].drum.has_value();
  if (traits.kind == QuantityKind::kReaction) return has_row(list_held_rows(model.joints[i]), quantity.part);
  return true;
}

// Numbers of `part` of which one quantity each is listed.
std::vector<int> list_parts(const Model& model, const QuantityTraits& traits, std::size_t subject) {
  int from = 0, to = 0;
  switch (traits.values) {
    case QuantityValues::kOfMode:
      to = static_cast<int>(model.joints[subject].modes.size());
      break;
    case QuantityValues::kOfPointRow:
      to = kRotX;
      break;
    case QuantityValues::kOfTurnRow:
      from = kRotX;
      to = kRows;
      break;
    case QuantityValues::kOfRow:
    case QuantityValues::kRowValues:
      to = kRows;
      break;
    default:
      return {unlatch::Quantity::kSize};
  }
  std::vector<int> parts;
  for (int part = from; part < to; ++part) parts.push_back(part);
  return parts;
}

}  // namespace

const std::vector<std::string>& list_quantity_keys() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> list;
    for (int kind = 0; kind < count_quantity_kinds(); ++kind)
      if (const QuantityTraits& traits = get_traits(static_cast<QuantityKind>(kind)); is_written(traits))
        list.emplace_back(traits.name);
    return list;
  }();
  return keys;
}

const QuantityTraits* find_quantity_traits(const std::string& key) {
  for (int kind = 0; kind < count_quantity_kinds(); ++kind)
    if (const QuantityTraits& traits = get_traits(static_cast<QuantityKind>(kind));
        is_written(traits) && key == traits.name)
      return &traits;
  return nullptr;
}

const char* get_subject_key(SubjectOf of) {
  switch (of) {
    case SubjectOf::kBody:
    case SubjectOf::kMassLaw:
      return "body";
    case SubjectOf::kJoint:
      return "joint";
    case SubjectOf::kSurface:
      return "between";
    case SubjectOf::kContact:
      return "contact";
    case SubjectOf::kElement:
    case SubjectOf::kOneSided:
    case SubjectOf::kCord:
      return "element";
    case SubjectOf::kSignal:
      return "signal";
    case SubjectOf::kChannel:
      return "channel";
    case SubjectOf::kEvent:
      return "event";
    case SubjectOf::kLaw:
      return "law";
    case SubjectOf::kNothing:
      break;
  }
  return "";
}

const char* get_direction_key(const QuantityTraits& traits) {
  return traits.kind == QuantityKind::kRate ? "about" : "along";
}

bool needs_more(const QuantityTraits& traits) {
  return traits.has_axes || (count_values(traits) == 1 && traits.values != QuantityValues::kOne) ||
         traits.values == QuantityValues::kRowValues;
}

std::string write_pattern(const QuantityTraits& traits) {
  std::string text = std::string("{") + get_subject_key(traits.of) + ": NAME";
  if (traits.has_axes) text += ", axis: [1, 0, 0], other: [1, 0, 0]";
  if (traits.values == QuantityValues::kOfMode) text += ", is: MODE";
  if (traits.values == QuantityValues::kRowValues) text += ", row: ROW";
  if (count_values(traits) == 1 && traits.values != QuantityValues::kOne && traits.values != QuantityValues::kOfMode)
    text += ", axis: AXIS";
  return text + "}";
}

std::string write_quantity(const Model& model, const unlatch::Quantity& quantity) {
  const QuantityTraits& traits = get_traits(quantity.kind);
  const std::string subject = get_subject_name(model, traits.of, quantity.subject);
  const std::string name = std::string(traits.name) + ": ";
  if (traits.of == SubjectOf::kSurface)
    return name + "{between: [" + subject + ", " + get_subject_name(model, traits.of, quantity.other) + "]}";
  std::string text = std::string(get_subject_key(traits.of)) + ": " + subject;
  if (traits.other == SubjectOf::kBody && quantity.other != kGround)
    text += ", relative_to: " + get_subject_name(model, traits.other, quantity.other);
  if (traits.has_axes)
    text += ", axis: " + show(quantity.direction) + ", other: " + show(quantity.other_direction);
  else if (!quantity.direction.isZero(0))
    text += std::string(", ") + get_direction_key(traits) + ": " + show(quantity.direction);
  if (!quantity.point.isZero(0)) text += ", point: " + show(quantity.point);
  switch (traits.values) {
    case QuantityValues::kOne:
      break;
    case QuantityValues::kOfMode:
      text += ", is: " + model.joints[at(quantity.subject)].modes[at(quantity.part)].name;
      break;
    case QuantityValues::kRowValues:
      text += std::string(", row: ") + kRowNames[quantity.part];
      break;
    case QuantityValues::kVector:
      if (quantity.part >= 0) text += std::string(", component: ") + get_component_name(traits, quantity.part);
      break;
    case QuantityValues::kQuaternion:
      if (quantity.part >= 0)
        text += std::string(", component: ") + (quantity.part == 0 ? "w" : kRowNames[quantity.part - 1]);
      break;
    default:
      text += std::string(", axis: ") + kRowNames[quantity.part];
  }
  return name + "{" + text + "}";
}

std::vector<unlatch::Quantity> list_possible_quantities(const Model& model) {
  std::vector<unlatch::Quantity> list;
  for (const std::string& key : list_quantity_keys()) {
    const QuantityTraits& traits = *find_quantity_traits(key);
    unlatch::Quantity quantity;
    quantity.kind = traits.kind;
    if (traits.has_axes) quantity.direction = quantity.other_direction = Eigen::Vector3d::UnitX();
    if (traits.of == SubjectOf::kSurface) continue;  // pairs: below
    for (std::size_t i = 0; i < count_subjects(model, traits.of); ++i)
      for (const int part : list_parts(model, traits, i)) {
        quantity.subject = static_cast<int>(i);
        quantity.part = part;
        if (is_fit(model, quantity, traits)) list.push_back(quantity);
      }
  }
  const auto add_pair = [&](int a, int b) {
    unlatch::Quantity quantity;
    quantity.kind = QuantityKind::kClearance;
    quantity.subject = a;
    quantity.other = b;
    const bool known = std::ranges::any_of(list, [&](const unlatch::Quantity& other) {
      return other.kind == QuantityKind::kClearance && other.subject == a && other.other == b;
    });
    if (!known) list.push_back(quantity);
  };
  for (const Contact& contact : model.contacts) add_pair(contact.base, contact.follower);
  for (const Sensor& sensor : model.sensors)
    if (sensor.kind == Sensor::Kind::kDistance) add_pair(sensor.subject, sensor.other);
  return list;
}

std::string get_unit(const Model& model, const Sensor& sensor) {
  return sensor.kind == Sensor::Kind::kQuantity ? unlatch::get_unit(model, get_quantity(model, sensor))
                                                : sensor_unit(sensor.kind);
}

}  // namespace unlatch::hil
