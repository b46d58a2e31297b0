// Sensors, and events: their conditions and their actions.
#include <algorithm>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/quantities.h"
#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {
namespace {

// Reads an axis of rotation: x, y, z are accepted as well as rot_x, rot_y, rot_z.
int read_angle_axis(YamlMap& map) {
  static const std::vector<std::string> kNames{"rot_x", "rot_y", "rot_z", "x", "y", "z"};
  const int axis = map.choice("axis", "axis", kNames);
  return axis < 0 ? kRotX : kRotX + axis % 3;
}

// Conditions with keys and rules of their own; any other key is a quantity's.
const std::vector<std::string>& list_own_keys() {
  static const std::vector<std::string> keys{
      "time",      "reaction",       "displacement",    "angle",   "speed",   "body_rate", "burnt",
      "clearance", "contact",        "signal",          "command", "mode",    "all",       "any",
      "not",       "reaction_force", "reaction_moment", "force",   "engaged", "wound",     "bearing"};
  return keys;
}

const std::vector<std::string>& list_condition_keys() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> list = list_own_keys();
    list.emplace_back("quantity");
    list.emplace_back("expression");
    for (const std::string& key : list_quantity_keys())
      if (std::ranges::find(list, key) == list.end()) list.push_back(key);
    return list;
  }();
  return keys;
}

// The key of a quantity, or of a condition that is written like one: `force: {element: spring}`.
bool is_quantity_condition(const std::string& key, const YamlNode& value) {
  if (std::ranges::find(list_own_keys(), key) == list_own_keys().end()) return true;
  const QuantityTraits* const traits = find_quantity_traits(key);
  return traits != nullptr && !traits->holds && !needs_more(*traits) && traits->of != SubjectOf::kSurface &&
         !value.is_scalar();
}

// Index for the model; a name that was not found has been reported already.
int or_first(int index) { return std::max(index, 0); }

}  // namespace

void ScenarioReader::read_sensors(YamlMap& top) {
  scenario_.rates.errors.dt = scenario_.dt;
  scenario_.rates.errors.seed =
      static_cast<std::uint64_t>(read_bounded(top, get_number_key("scenario.scenario.sensor_seed"), 1.0, mistakes_));
  for_each_named(top, "sensors", "sensor",
                 [&](const std::string& name, const YamlNode& node) { read_sensor(name, node); });
}

void ScenarioReader::read_sensor(const std::string& name, const YamlNode& node) {
  static const std::vector<std::string> kTypes{
      "position", "attitude",     "velocity", "rate",  "acceleration", "specific_force", "contact",
      "reaction", "displacement", "angle",    "speed", "distance",     "quantity"};  // in the order of Sensor::Kind
  YamlMap map(node, "sensor '" + name + "'", mistakes_);
  const int type = map.choice("type", "sensor type", kTypes);
  if (type < 0) return;  // the valid keys depend on the type
  Sensor sensor;
  sensor.name = name;
  using Kind = Sensor::Kind;
  sensor.kind = static_cast<Kind>(type);
  if (sensor.kind <= Kind::kSpecificForce) sensor.subject = map.choice("body", "body", bodies_);
  if (sensor.kind == Kind::kAcceleration || sensor.kind == Kind::kSpecificForce)
    sensor.point = map.vector("point", "m", Eigen::Vector3d::Zero());
  if (sensor.kind == Kind::kContact) sensor.subject = map.choice("signal", "signal", model_.signals);
  if (sensor.kind == Kind::kDistance) {
    const YamlNode* const between = map.require("between");
    const std::optional<ClearancePair> pair = between ? read_surface_pair(*between) : std::nullopt;
    if (pair) {
      sensor.subject = find_surface(pair->a);
      sensor.other = find_surface(pair->b);
    }
  } else if (sensor.kind == Kind::kQuantity) {
    if (const YamlNode* const quantity = map.require("quantity"))
      sensor.subject = read_quantity_index("quantity", *quantity);
  } else if (sensor.kind >= Kind::kReaction) {
    sensor.subject = map.choice("joint", "joint", joints_);
  }
  if (sensor.kind == Kind::kDisplacement) sensor.axis = or_first(map.choice("axis", "axis", axis_names()));
  if (sensor.kind == Kind::kAngle) sensor.axis = read_angle_axis(map);
  if (sensor.kind == Kind::kSpeed) sensor.axis = or_first(map.choice("axis", "row", row_names()));
  if (const YamlNode* const errors = map.find("errors")) read_sensor_errors(*errors, sensor);
  map.finish();
  model_.sensors.push_back(std::move(sensor));
}

void ScenarioReader::read_events(YamlMap& top) {
  const YamlNode* node = top.find("events");
  if (!node) return;
  if (!node->is_sequence()) mistakes_.add(node->mark, "events is not a list", "write `- name: …` for each event");
  for (const YamlNode& item : node->items) read_event(item);
}

void ScenarioReader::read_event(const YamlNode& node) {
  Event event;
  YamlMap map(node, "an event", mistakes_);
  if (const YamlNode* name = map.require("name")) event.name = read_name(*name, mistakes_);
  if (const YamlNode* subject = map.find("subject")) event.subject = read_name(*subject, mistakes_);
  bool enabled = true;
  const std::string where = "event '" + event.name + "'" + (event.subject.empty() ? "" : " of '" + event.subject + "'");
  const auto read_rest = [&] {
    if (const YamlNode* when = map.require("when")) event.when = read_condition(*when);
    event.delay = map.number("delay", "s", 0.0);
    if (const YamlNode* then = map.find("then")) {
      if (!then->is_sequence()) mistakes_.add(then->mark, "then is not a list", "write `- set_mode: {…}` and so on");
      for (const YamlNode& action : then->items) event.then.push_back(read_action(action));
    }
    event.repeat = map.boolean("repeat", false);
    enabled = map.boolean("enabled", true);
    map.finish();
  };
  if (nodes_.count(where) > 0)
    mistakes_.add(node.mark, "a second " + where, "give each event its own pair of name and subject");
  read_item_at(where, node, read_rest);
  event_names_.emplace_back(event.name + (event.subject.empty() ? "" : ":" + event.subject),
                            enabled ? static_cast<int>(model_.events.size()) : kNone);
  if (enabled) model_.events.push_back(std::move(event));
}

// --- Conditions -----------------------------------------------------------------------------------------------------

Condition ScenarioReader::read_condition(const YamlNode& node) {
  using Kind = Condition::Kind;
  Condition condition;
  YamlMap map(node, "a condition", mistakes_);
  const std::string kind = map.only_one_of(list_condition_keys(), "to say what it looks at");
  if (kind.empty()) return condition;
  const YamlNode& value = *map.find(kind);
  if (kind == "time") {
    condition.threshold = read_number(value, "s", 0.0, mistakes_);
    if (condition.threshold < 0)
      mistakes_.add(value.mark, "this time is before the run, which begins at 0 s", "0 s or later");
  } else if (is_quantity_condition(kind, value)) {
    condition.kind = Kind::kQuantity;
    condition.subject = read_quantity_index(kind, value);
    const auto number = static_cast<std::size_t>(condition.subject);
    read_threshold(map, number < model_.quantities.size() ? get_si(model_, model_.quantities[number]) : "", condition);
  } else if (kind == "signal") {
    condition.kind = Kind::kSignal;
    condition.subject = read_choice(value, "signal", model_.signals, mistakes_);
  } else if (kind == "contact") {
    std::vector<std::string> contacts;
    for (const Contact& contact : model_.contacts) contacts.push_back(contact.name);
    condition.kind = Kind::kClosed;
    condition.subject = read_choice(value, "contact", contacts, mistakes_);
  } else if (kind == "clearance") {
    YamlMap inner(value, kind, mistakes_);
    const YamlNode* const between = inner.require("between");
    const std::optional<ClearancePair> pair = between ? read_surface_pair(*between) : std::nullopt;
    inner.finish();
    condition.kind = Kind::kDistance;
    if (pair) {
      condition.subject = find_surface(pair->a);
      condition.axis = find_surface(pair->b);
    }
    read_threshold(map, "m", condition);
  } else if (kind == "body_rate") {
    condition.kind = Kind::kBodyRate;
    condition.subject = read_choice(value, "body", bodies_, mistakes_);
    read_threshold(map, "rad/s", condition);
  } else if (kind == "reaction_force" || kind == "reaction_moment") {
    condition.kind = kind == "reaction_force" ? Kind::kForceSize : Kind::kMomentSize;
    condition.subject = read_choice(value, "joint", joints_, mistakes_);
    read_threshold(map, kind == "reaction_force" ? "N" : "N m", condition);
  } else if (kind == "force") {
    condition.kind = Kind::kOneSidedForce;
    condition.subject = read_one_sided(value);
    const bool turns = model_.one_sided.size() > static_cast<std::size_t>(condition.subject) &&
                       model_.one_sided[static_cast<std::size_t>(condition.subject)].joint != kNone &&
                       model_.one_sided[static_cast<std::size_t>(condition.subject)].axis >= kRotX;
    read_threshold(map, turns ? "N m" : "N", condition);
  } else if (kind == "engaged") {
    condition.kind = Kind::kEngaged;
    condition.subject = read_one_sided(value);
  } else if (kind == "wound" || kind == "bearing") {
    condition.kind = kind == "wound" ? Kind::kWound : Kind::kBearing;
    condition.subject = read_wound_cord(value);
    read_threshold(map, "rad", condition);
  } else if (kind == "burnt") {
    condition.kind = Kind::kBurnt;
    condition.subject = read_choice(value, "body", bodies_, mistakes_);
    read_threshold(map, "kg", condition);
  } else if (kind == "command") {
    condition.kind = Kind::kCommand;
    condition.subject = read_choice(value, "channel", channels_, mistakes_);
    const auto channel = static_cast<std::size_t>(or_first(condition.subject));
    read_threshold(map, channel < model_.channels.size() ? get_si(model_.channels[channel]) : "", condition);
  } else if (kind == "mode") {
    condition.kind = Kind::kMode;
    YamlMap inner(value, kind, mistakes_);
    condition.subject = inner.choice("joint", "joint", joints_);
    condition.axis = read_mode_of(inner, "is", condition.subject);
    inner.finish();
  } else if (kind == "all" || kind == "any" || kind == "not") {
    read_parts(value, kind, condition);
  } else {
    read_joint_condition(value, kind, condition);
    const bool force = kind == "reaction", turns = condition.axis >= kRotX;
    const std::string unit = force ? (turns ? "N m" : "N") : (turns ? "rad" : "m");
    read_threshold(map, unit + (kind == "speed" ? "/s" : ""), condition);
  }
  map.finish();
  return condition;
}

void ScenarioReader::read_parts(const YamlNode& node, const std::string& kind, Condition& condition) {
  using Kind = Condition::Kind;
  condition.kind = kind == "all" ? Kind::kAll : (kind == "any" ? Kind::kAny : Kind::kNot);
  if (condition.kind == Kind::kNot) {
    condition.parts.push_back(read_condition(node));
    return;
  }
  if (!node.is_sequence()) mistakes_.add(node.mark, kind + " is not a list", "write a list of conditions");
  for (const YamlNode& part : node.items) condition.parts.push_back(read_condition(part));
}

void ScenarioReader::read_joint_condition(const YamlNode& node, const std::string& kind, Condition& condition) {
  using Kind = Condition::Kind;
  YamlMap map(node, kind, mistakes_);
  condition.subject = map.choice("joint", "joint", joints_);
  if (kind == "reaction") {
    condition.kind = Kind::kReaction;
    condition.axis = or_first(map.choice("row", "row", row_names()));
  } else if (kind == "displacement") {
    condition.kind = Kind::kDisplacement;
    condition.axis = or_first(map.choice("axis", "axis", axis_names()));
  } else if (kind == "angle") {
    condition.kind = Kind::kAngle;
    condition.axis = read_angle_axis(map);
  } else {
    condition.kind = Kind::kSpeed;
    condition.axis = or_first(map.choice("axis", "row", row_names()));
  }
  map.finish();
}

void ScenarioReader::read_threshold(YamlMap& map, const std::string& unit, Condition& condition) {
  const std::string side = map.only_one_of({"above", "below"}, "a threshold");
  condition.below = side == "below";
  if (!side.empty()) condition.threshold = map.number(side, unit);
}

// --- Actions --------------------------------------------------------------------------------------------------------

// Number of a mode of that joint; an unknown mode of a joint that has mistakes itself is not reported again.
int ScenarioReader::read_mode_of(YamlMap& map, const std::string& key, int joint) {
  const YamlNode* node = map.require(key);
  if (!node || joint < 0 || static_cast<std::size_t>(joint) >= model_.joints.size()) return 0;
  const Joint& of = model_.joints.at(static_cast<std::size_t>(joint));
  std::vector<std::string> names;
  for (const JointMode& mode : of.modes) names.push_back(mode.name);
  if (is_flawed("joint '" + of.name + "'") && std::find(names.begin(), names.end(), node->text) == names.end())
    return 0;
  return or_first(read_choice(*node, "mode of joint '" + of.name + "'", names, mistakes_));
}

Action ScenarioReader::read_action(const YamlNode& node) {
  Action action;
  YamlMap map(node, "an action", mistakes_);
  const std::string kind =
      map.only_one_of({"set_mode", "latch", "switch", "ramp", "raise", "impulse"}, "to say what it does");
  if (kind.empty()) return action;
  const YamlNode& value = *map.find(kind);
  map.finish();
  if (kind == "raise" && value.is_scalar()) {
    action = {Action::Kind::kRaise, read_choice(value, "signal", model_.signals, mistakes_), 0, 1.0, 0.0};
    return action;
  }
  YamlMap inner(value, kind, mistakes_);
  if (kind == "set_mode" || kind == "latch") {
    action.subject = inner.choice("joint", "joint", joints_);
    action.mode = read_mode_of(inner, "mode", action.subject);
    if (kind == "latch" && action.subject >= 0) {
      const auto& modes = model_.joints[static_cast<std::size_t>(action.subject)].modes;
      const bool adds = std::any_of(modes.begin(), modes.end(), [&](const JointMode& mode) {
        return (modes[static_cast<std::size_t>(action.mode)].rows & ~mode.rows) != 0;
      });
      if (!modes.empty() && !adds)
        mistakes_.add(value.mark, "this latch adds no rows to any other mode",
                      "latch a mode with more rows, or set_mode");
    }
  } else if (kind == "impulse") {
    action = read_impulse(inner);
  } else if (kind == "raise") {
    action.kind = Action::Kind::kRaise;
    action.subject = inner.choice("signal", "signal", model_.signals);
    action.value = inner.number("to", "", 1.0);
  } else {
    action.kind = kind == "ramp" ? Action::Kind::kRamp : Action::Kind::kSwitch;
    action.subject = inner.choice("element", "element", elements_);
    const YamlNode* to = inner.require("to");
    if (to && is_truth_value(*to))
      action.value = read_bool(*to, false, mistakes_) ? 1.0 : 0.0;
    else if (to)
      action.value = read_number(*to, "", 0.0, mistakes_);
    if (kind == "ramp") action.duration = inner.number("over", "s");
  }
  inner.finish();
  return action;
}

}  // namespace unlatch::hil
