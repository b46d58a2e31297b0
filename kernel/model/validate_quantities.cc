// Quantities: their subjects exist and have the values that are read.
#include <algorithm>
#include <set>

#include "kernel/model/validate.h"
#include "unlatch/quantities.h"

namespace unlatch {
namespace {

const char* get_noun(SubjectOf of) {
  switch (of) {
    case SubjectOf::kBody:
    case SubjectOf::kMassLaw:
      return "body";
    case SubjectOf::kJoint:
      return "joint";
    case SubjectOf::kSurface:
      return "surface";
    case SubjectOf::kContact:
      return "contact";
    case SubjectOf::kElement:
      return "element";
    case SubjectOf::kOneSided:
    case SubjectOf::kCord:
      return "pusher, stop or cord";
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

struct QuantityCheck {
  const Model& model;
  const std::string& where;
  const std::string& key;
  ModelErrors& errors;

  void report(const std::string& what, const std::string& mend, const char* own_key = "") {
    errors.push_back({where, what, mend, key.empty() ? own_key : key});
  }

  bool check_subject(SubjectOf of, int subject) {
    const bool exists = of == SubjectOf::kNothing || is_index(subject, count_subjects(model, of));
    if (of == SubjectOf::kCord && !(exists && model.one_sided[static_cast<std::size_t>(subject)].drum)) {
      report("it reads how far a cord is wound that has no drum", "the index of a cord with a drum");
      return false;
    }
    if (of == SubjectOf::kMassLaw && !(exists && model.bodies[static_cast<std::size_t>(subject)].law)) {
      report("it reads what is burnt by a body that has no mass law", "the index of a body with a law");
      return false;
    }
    if (!exists)
      report(std::string("the ") + get_noun(of) + " that it names does not exist",
             std::string("the index of one ") + get_noun(of), get_noun(of));
    return exists;
  }

  void check_surroundings(const QuantityTraits& traits) {
    if (traits.of_planet && !model.environment.planet)
      report(std::string(traits.name) + " is of a planet, and there is none", "environment: {planet: wgs84}");
    else if (traits.of_air && !model.environment.atmosphere)
      report(std::string(traits.name) + " is of the air, and there is none", "environment: {atmosphere: us1976}");
  }

  void check_row(int row, int first, int last) {
    if (row < first || row > last)
      report("it names an axis that this kind of quantity does not have",
             std::string(kRowNames[first]) + " … " + kRowNames[last], "axis");
  }

  // A reaction along a row that never holds is always 0.
  void check_held(const Quantity& quantity) {
    const Joint& joint = model.joints[static_cast<std::size_t>(quantity.subject)];
    if (std::none_of(joint.modes.begin(), joint.modes.end(),
                     [&](const JointMode& m) { return has_row(m.rows, quantity.part); }))
      report("no mode of joint '" + joint.name + "' has the row " + kRowNames[quantity.part],
             "look at a row that one of its modes has");
  }

  // `single`: one value is wanted.
  void check_part(const Quantity& quantity, const QuantityTraits& traits, bool single) {
    const int part = quantity.part, count = count_values(traits);
    switch (traits.values) {
      case QuantityValues::kOfPointRow:
        return check_row(part, kX, kZ);
      case QuantityValues::kOfTurnRow:
        return check_row(part, kRotX, kRotZ);
      case QuantityValues::kOfRow:
        return check_row(part, kX, kRotZ);
      case QuantityValues::kRowValues:
        if (part == Quantity::kAll && !single) return;
        check_row(part, kX, kRotZ);
        if (is_index(part, kRows)) check_held(quantity);
        return;
      case QuantityValues::kOfMode: {
        const Joint& joint = model.joints[static_cast<std::size_t>(quantity.subject)];
        if (!is_index(part, joint.modes.size()))
          report("it names a mode that joint '" + joint.name + "' does not have", "the index of one of its modes");
        return;
      }
      case QuantityValues::kVector:
      case QuantityValues::kQuaternion:
        if (part == Quantity::kAll && single)
          report("it takes all values of a vector", "one of them, the size, or a direction");
        else if (part < Quantity::kAll || part >= count)
          report("it names a value that this kind of quantity does not have", "0 … " + std::to_string(count - 1));
        return;
      case QuantityValues::kOne:
        return;
    }
  }

  void check_directions(const Quantity& quantity, const QuantityTraits& traits) {
    if (!quantity.direction.allFinite() || !quantity.other_direction.allFinite() || !quantity.point.allFinite())
      report("a direction or point is not finite", "give finite values");
    if (traits.has_axes && (quantity.direction.isZero(0) || quantity.other_direction.isZero(0)))
      report("an axis has the length 0", "give two unit vectors");
    else if (!traits.has_axes && traits.values != QuantityValues::kVector && !quantity.direction.isZero(0))
      report("it has a direction, and is no vector", "leave the direction out");
    if (!traits.has_point && !quantity.point.isZero(0)) report("it has a point that is not read", "leave it out");
  }
};

}  // namespace

void check_quantity(const Model& model, const Quantity& quantity, bool single, const std::string& where,
                    const std::string& key, ModelErrors& errors) {
  QuantityCheck check{model, where, key, errors};
  if (static_cast<int>(quantity.kind) < 0 || static_cast<int>(quantity.kind) >= count_quantity_kinds())
    return check.report("its kind of quantity does not exist", "one of Quantity::Kind");
  const QuantityTraits& traits = get_traits(quantity.kind);
  if (traits.other == SubjectOf::kSurface)
    return check_shape_pair(model, where, quantity.subject, quantity.other, key, errors);
  if (!check.check_subject(traits.of, quantity.subject)) return;
  check.check_surroundings(traits);
  if (traits.other == SubjectOf::kBody && quantity.other != kGround) {
    if (!check.check_subject(traits.other, quantity.other)) return;
    if (quantity.other == quantity.subject && !traits.has_axes)
      check.report("a body is seen from itself", "another body, or the ground");
  }
  check.check_part(quantity, traits, single);
  check.check_directions(quantity, traits);
}

void validate_quantities(const Model& model, ModelErrors& errors) {
  for (const Quantity& quantity : model.quantities)
    check_quantity(model, quantity, true, quoted("quantity", quantity.name), "", errors);
}

}  // namespace unlatch
