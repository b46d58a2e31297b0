// Requirements: the quantity, the interval, the limit.
#include <algorithm>
#include <cmath>

#include "hil/scenario/measurable.h"
#include "hil/scenario/quantities.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/suggestion.h"

namespace unlatch::hil {
namespace {

using Measure = Requirement::Measure;
using Take = Requirement::Take;

const std::vector<std::string> kQuantities{"clearance", "rate",     "time",         "order",   "reaction",
                                           "velocity",  "position", "displacement", "angle",   "speed",
                                           "axes",      "sensor",   "contact",      "quantity"};

// Keys of a requirement: the kinds above, and those of other quantities.
const std::vector<std::string>& list_keys() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> list = kQuantities;
    list.emplace_back("expression");
    for (const std::string& key : list_quantity_keys())
      if (std::ranges::find(list, key) == list.end()) list.push_back(key);
    return list;
  }();
  return keys;
}

const std::vector<std::string> kContactValues{"force", "depth", "slip", "impulse", "dissipated"};

}  // namespace

void ScenarioReader::read_requirements(YamlMap& top) {
  const YamlNode* node = top.find("requirements");
  if (!node) return;
  if (!node->is_sequence())
    mistakes_.add(node->mark, "requirements is not a list", "write `- id: R1` for each requirement");
  for (const YamlNode& item : node->items) read_requirement(item);
}

void ScenarioReader::read_requirement(const YamlNode& node) {
  Requirement requirement;
  YamlMap map(node, "a requirement", mistakes_);
  if (const YamlNode* id = map.require("id")) requirement.id = read_name(*id, mistakes_);
  if (const YamlNode* text = map.find("text")) requirement.text = read_text(*text, mistakes_);
  RequirementOrigin origin;
  if (const YamlNode* parent = map.find("parent")) origin.parent = read_text(*parent, mistakes_);
  if (const YamlNode* rationale = map.find("rationale")) origin.rationale = read_text(*rationale, mistakes_);
  record_.requirements.push_back(std::move(origin));
  const std::string where = "requirement '" + requirement.id + "'";
  if (nodes_.count(where) > 0) mistakes_.add(node.mark, "a second " + where, "give each an id of its own");
  read_item_at(where, node, [&] {
    const std::string kind = map.only_one_of(list_keys(), "a quantity");
    if (!kind.empty()) {
      const auto own = std::find(kQuantities.begin(), kQuantities.end(), kind);  // in the order of Measure
      requirement.quantity =
          own == kQuantities.end() ? Measure::kQuantity : static_cast<Measure>(own - kQuantities.begin());
      read_requirement_quantity(*map.find(kind), kind, requirement);
      requirement.unit = get_unit(requirement, model_);
    }
    read_requirement_interval(map, requirement);
    read_requirement_limit(map, requirement);
    map.finish();
  });
  scenario_.requirements.push_back(std::move(requirement));
}

// --- The quantity ---------------------------------------------------------------------------------------------------

void ScenarioReader::read_requirement_quantity(const YamlNode& node, const std::string& kind, Requirement& to) {
  switch (to.quantity) {
    case Measure::kClearance:
      return read_requirement_clearance(node, to);
    case Measure::kOrder:
      if (!node.is_sequence()) return mistakes_.add(node.mark, "order is not a list", "write [latch1, latch2]");
      for (const YamlNode& item : node.items) to.events.push_back(read_event_name(item));
      if (to.events.size() < 2) mistakes_.add(node.mark, "an order of fewer than two events", "write [latch1, latch2]");
      return;
    case Measure::kQuantity:
      to.a = read_quantity_index(kind, node);
      return;
    case Measure::kDisplacement:
    case Measure::kAngle:
    case Measure::kSpeed: {
      Condition joint;
      read_joint_condition(node, kind, joint);
      to.a = joint.subject;
      to.axis = joint.axis;
      return;
    }
    default:
      break;
  }
  YamlMap map(node, kind, mistakes_);
  if (to.quantity == Measure::kTime) {
    if (const YamlNode* event = map.require("event")) to.events.push_back(read_event_name(*event));
    if (const YamlNode* after = map.find("after")) to.events.push_back(read_event_name(*after));
  } else if (to.quantity == Measure::kReaction) {
    std::vector<std::string> rows = row_names();
    rows.insert(rows.end(), {"force", "moment"});
    to.a = map.choice("joint", "joint", joints_);
    to.axis = map.choice("row", "row", rows);
    if (to.axis >= kRows) to.axis = to.axis == kRows ? Requirement::kForce : Requirement::kMoment;
  } else if (to.quantity == Measure::kContact) {
    read_requirement_contact(map, to);
  } else if (to.quantity == Measure::kSensor) {
    read_requirement_sensor(map, to);
  } else {
    read_requirement_of_bodies(map, to);
  }
  map.finish();
}

void ScenarioReader::read_requirement_clearance(const YamlNode& node, Requirement& to) {
  const std::optional<ClearancePair> pair = read_shape_pair(node);
  if (!pair) return;
  to.a = pair->a.body;
  to.b = pair->b.body;
  to.pair = watch(*pair);  // from then on the pair is watched and reported
  to.pair_name = pair->a.name + " – " + pair->b.name;
}

void ScenarioReader::read_requirement_of_bodies(YamlMap& map, Requirement& to) {
  to.a = map.choice("body", "body", bodies_);
  to.b = read_relative_to(map, to.a, false);
  if (to.quantity != Measure::kAxes && map.find("component")) {
    const int axis = std::max(0, map.choice("component", "component", axis_names()));
    to.direction = Eigen::Vector3d::Unit(axis);
    return;
  }
  switch (to.quantity) {
    case Measure::kRate:
      to.direction = read_direction(map, "about", false);
      break;
    case Measure::kVelocity:
    case Measure::kPosition:
      to.direction = read_direction(map, "along", false);
      break;
    default:
      to.direction = read_direction(map, "axis", true);
      to.other = read_direction(map, "other", true);
      break;
  }
}

void ScenarioReader::read_requirement_contact(YamlMap& map, Requirement& to) {
  std::vector<std::string> contacts;
  for (const Contact& contact : model_.contacts) contacts.push_back(contact.name);
  to.a = map.choice("name", "contact", contacts);
  to.axis = std::max(0, map.choice("value", "value", kContactValues, 0));
}

void ScenarioReader::read_requirement_sensor(YamlMap& map, Requirement& to) {
  static const std::vector<std::string> kValues{"x", "y", "z", "w", "rot_x", "rot_y", "rot_z", "size"};
  std::vector<std::string> sensors;
  for (const Sensor& sensor : model_.sensors) sensors.push_back(sensor.name);
  to.a = map.choice("name", "sensor", sensors);
  const int value = map.choice("value", "value", kValues, 7);
  to.received = map.boolean("received", false);
  if (to.a < 0 || value < 0) return;
  const Sensor& sensor = model_.sensors[static_cast<std::size_t>(to.a)];
  const int width = sensor_width(sensor.kind);
  if (value < 7 && width > 1) {
    if (width == 4)
      to.axis = value == 3 ? 0 : value + 1;  // w x y z
    else
      to.axis = value < 3 ? value : value - 1;  // x y z rot_x rot_y rot_z
    if ((width == 4 && value > 3) || (width != 4 && (value == 3 || to.axis >= width)))
      mistakes_.add(map.node().find("value")->mark,
                    "sensor '" + sensor.name + "' gives no '" + kValues[static_cast<std::size_t>(value)] + "'",
                    "leave value out for the size");
  } else if (value < 7 || width == 1) {
    to.axis = 0;
  }
  if (sensor.kind == Sensor::Kind::kReaction && value == 7)
    mistakes_.add(map.node().mark, "forces and moments have no size together", "value: x … rot_z, or a reaction");
}

// --- The interval and the limit -------------------------------------------------------------------------------------

EventName ScenarioReader::read_event_name(const YamlNode& node) {
  EventName name;
  if (!node.is_scalar()) {
    mistakes_.add(node.mark, "the event is not a name", "write its name, or name:subject");
    return name;
  }
  name.text = node.text;
  int found = 0;
  std::vector<std::string> known;
  for (const auto& [whole, index] : event_names_) {
    known.push_back(whole);
    if (whole != node.text && whole.substr(0, whole.find(':')) != node.text) continue;
    ++found;
    name.event = index;
    name.text = whole;
    if (whole == node.text) return name;
  }
  if (found == 0) mistakes_.add(node.mark, "unknown event '" + node.text + "'", suggest(node.text, known));
  if (found > 1)
    mistakes_.add(node.mark, "several events are called '" + node.text + "'", "write name:subject, " + name.text);
  return name;
}

void ScenarioReader::read_requirement_interval(YamlMap& map, Requirement& to) {
  const YamlNode *at = map.find("at"), *from = map.find("from"), *until = map.find("to");
  if (at) to.at = read_event_name(*at);
  if (from) to.from = read_event_name(*from);
  if (until) to.to = read_event_name(*until);
  if (at && (from || until)) mistakes_.add(at->mark, "an instant and an interval", "write either at, or from and to");
  for (const YamlNode* key : {at, from, until})
    if (key && to.is_of_events())
      mistakes_.add(key->mark, "an interval of a time", "leave it out: the events say when");
}

void ScenarioReader::read_requirement_limit(YamlMap& map, Requirement& to) {
  static const std::vector<std::string> kTakes{"minimum", "maximum", "peak", "final"};
  const std::string limit = map.only_one_of({"at_least", "at_most", "range"}, "a limit");
  const YamlNode* take = map.find("take");
  if (limit == "at_least") {
    to.least = map.number("at_least", to.unit);
    to.take = Take::kMinimum;
  } else if (limit == "at_most") {
    to.most = map.number("at_most", to.unit);
    to.take = to.quantity == Measure::kReaction ? Take::kPeak : Take::kMaximum;
  } else if (limit == "range") {
    const std::vector<double> range = read_numbers(*map.find("range"), 2, to.unit, mistakes_);
    to.take = Take::kBoth;
    if (range.size() == 2) {
      to.least = range[0];
      to.most = range[1];
      if (!(to.least <= to.most))
        mistakes_.add(map.find("range")->mark, "a range without room", "write [smallest, greatest]");
    }
  }
  if (!take) return;
  const int choice = read_choice(*take, "way to take the value", kTakes, mistakes_);
  if (choice >= 0) to.take = static_cast<Take>(choice);
  if (to.at.is_named() || to.is_of_events()) mistakes_.add(take->mark, "there is one value only", "leave take out");
}

// --- Words ----------------------------------------------------------------------------------------------------------

const std::string& get_quantity_name(Requirement::Measure quantity) {
  return kQuantities[static_cast<std::size_t>(quantity)];
}

std::string describe_quantity(const Requirement& r, const Model& model) {
  const auto body = [&](int i) {
    return i == kGround ? std::string("ground") : model.bodies[static_cast<std::size_t>(i)].name;
  };
  const std::string kind = kQuantities[static_cast<std::size_t>(r.quantity)];
  std::string text = kind;
  switch (r.quantity) {
    case Measure::kClearance:
      text += " " + r.pair_name;
      break;
    case Measure::kRate:
    case Measure::kVelocity:
    case Measure::kPosition:
    case Measure::kAxes:
      text += " of " + body(r.a) + (r.b == kGround ? "" : " relative to " + body(r.b));
      break;
    case Measure::kTime:
      text += " of " + r.events[0].text + (r.events.size() > 1 ? " after " + r.events[1].text : "");
      break;
    case Measure::kOrder:
      for (const EventName& event : r.events) text += " " + event.text;
      break;
    case Measure::kContact:
      text = kContactValues[static_cast<std::size_t>(r.axis)] + " of contact " +
             model.contacts[static_cast<std::size_t>(r.a)].name;
      break;
    case Measure::kQuantity: {
      const unlatch::Quantity& quantity = model.quantities[static_cast<std::size_t>(r.a)];
      text = describe(model, quantity);
      break;
    }
    case Measure::kSensor:
      text += " " + model.sensors[static_cast<std::size_t>(r.a)].name + (r.received ? " as received" : "");
      break;
    default: {
      const std::string row = r.axis >= 0 ? kRowNames[r.axis] : r.axis == Requirement::kForce ? "force" : "moment";
      text += " " + row + " of " + model.joints[static_cast<std::size_t>(r.a)].name;
    }
  }
  if (r.at.is_named()) text += " at " + r.at.text;
  if (r.from.is_named()) text += " from " + r.from.text;
  if (r.to.is_named()) text += " to " + r.to.text;
  return text;
}

}  // namespace unlatch::hil
