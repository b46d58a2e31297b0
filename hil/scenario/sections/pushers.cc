// One-sided elements: pushers, cords, stops; friction in joints; and the events that belong to them.
#include <algorithm>

#include "hil/scenario/base/index.h"
#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {

// Reads a line between two points, or along an axis of a joint. Returns true if its coordinate is an angle.
bool ScenarioReader::read_line(YamlMap& map, OneSided& force) {
  if (map.only_one_of({"between", "joint"}, "its two ends") == "joint") {
    force.joint = map.choice("joint", "joint", joints_);
    force.axis = std::max(map.choice("axis", "row", row_names()), 0);
    return force.axis >= kRotX;
  }
  read_between(map, force.base, force.follower);
  force.point_base = map.vector("point", "m", Eigen::Vector3d::Zero());
  force.point_follower = map.vector("follower_point", "m", Eigen::Vector3d::Zero());
  if (map.find("guide")) force.guide = map.vector("guide", "").stableNormalized();
  return false;
}

void ScenarioReader::read_pusher(YamlMap& map, OneSided force) {
  force.kind = OneSided::Kind::kPusher;
  const bool turns = read_line(map, force);
  const std::string length = turns ? "rad" : "m", unit = turns ? "N m" : "N";
  force.stroke = map.number("stroke", length);
  if (map.find("limit")) force.limit = map.number("limit", length);
  force.pulls = map.boolean("pull_only", false);
  const YamlNode *table = map.find("table"), *gas = map.find("gas");
  if (table && gas) mistakes_.add(gas->mark, "a pusher with a table and with gas", "one law of its force");
  if (!table) force.preload = map.number("preload", unit);
  if (!table && !gas) force.stiffness = map.number("stiffness", turns ? "N m/rad" : "N/m", 0.0);
  if (table) {
    force.law = OneSided::Law::kTable;
    YamlMap inner(*table, "table", mistakes_);
    if (const YamlNode* travels = inner.require("travel")) force.travels = read_numbers(*travels, 0, length, mistakes_);
    if (const YamlNode* forces = inner.require("force")) force.forces = read_numbers(*forces, 0, unit, mistakes_);
    inner.finish();
  }
  if (gas) {
    force.law = OneSided::Law::kGas;
    YamlMap inner(*gas, "gas", mistakes_);
    force.gas_length = inner.number("length", length);
    force.exponent = inner.number("exponent", "", 1.4);
    inner.finish();
  }
  force.damping = map.number("damping", turns ? "N m s/rad" : "N s/m", 0.0);
  force.friction = map.number("friction", unit, 0.0);
  force.friction_speed = map.number("friction_speed", turns ? "rad/s" : "m/s", 1e-3);
  force.on = map.boolean("enabled", true);
  model_.one_sided.push_back(std::move(force));
}

void ScenarioReader::read_cord(YamlMap& map, OneSided force) {
  force.kind = OneSided::Kind::kCord;
  force.pulls = true;
  read_between(map, force.base, force.follower);
  const YamlNode *wraps = map.find("wraps"), *point = map.find("point");
  if (wraps && point)
    mistakes_.add(point->mark, "a cord with a `point` on the base and a drum there",
                  "leave `point` out: its anchor follows from the angle that it is wound");
  force.point_base = map.vector("point", "m", Eigen::Vector3d::Zero());
  force.point_follower = map.vector("follower_point", "m", Eigen::Vector3d::Zero());
  if (map.find("length")) force.limit = map.number("length", "m");
  force.stiffness = map.number("stiffness", "N/m");
  force.damping = map.number("damping", "N s/m", 0.0);
  force.on = map.boolean("enabled", true);
  if (map.find("parts_at")) {
    Event part;
    part.name = "part";
    part.subject = force.name;
    part.when.kind = Condition::Kind::kOneSidedForce;
    part.when.subject = static_cast<int>(model_.one_sided.size());
    part.when.threshold = map.number("parts_at", "N");
    if (!(part.when.threshold > 0))
      mistakes_.add(map.find("parts_at")->mark, "it would part without any load", "a load greater than 0");
    part.then = {{.kind = Action::Kind::kSwitch, .subject = part.when.subject}};  // append_events() numbers it
    cord_events_.push_back(std::move(part));
  }
  if (wraps) read_drum(*wraps, force);
  model_.one_sided.push_back(std::move(force));
}

void ScenarioReader::read_drum(const YamlNode& node, OneSided& cord) {
  YamlMap map(node, "wraps", mistakes_);
  Drum drum;
  drum.centre = map.vector("centre", "m", Eigen::Vector3d::Zero());
  drum.axis = map.vector("axis", "").stableNormalized();
  drum.radius = map.number("radius", "m");
  drum.left = map.choice("sense", "sense", {"right", "left"}, 0) == 1;
  if (map.find("wound")) drum.wound = map.number("wound", "rad");
  const bool lets_go = map.find("releases") != nullptr;
  const bool radial = lets_go && map.choice("releases", "release", {"tangential", "radial"}, 0) == 1;
  map.finish();
  const auto number = static_cast<int>(model_.one_sided.size());
  Event unwound;
  unwound.name = "unwound";
  unwound.subject = cord.name;
  unwound.when.kind = Condition::Kind::kWound;
  unwound.when.subject = number;
  unwound.when.below = true;
  unwound.repeat = unwound.crossing = true;
  Event release = unwound;
  release.name = "release";
  if (radial) release.when.kind = Condition::Kind::kBearing;
  release.repeat = release.crossing = false;
  release.then = {{.kind = Action::Kind::kSwitch, .subject = number}};  // append_events() numbers it
  cord_events_.push_back(std::move(unwound));
  if (lets_go) cord_events_.push_back(std::move(release));
  cord.drum = drum;
}

void ScenarioReader::read_stop(const std::string& name, const YamlNode& node) {
  YamlMap map(node, "stop '" + name + "'", mistakes_);
  OneSided force;
  force.name = name;
  force.joint = map.choice("joint", "joint", joints_);
  force.axis = std::max(map.choice("axis", "row", row_names()), 0);
  const bool turns = force.axis >= kRotX;
  const std::string side = map.only_one_of({"at_most", "at_least"}, "the side that it allows");
  force.pulls = side == "at_most";
  if (!side.empty()) force.limit = map.number(side, turns ? "rad" : "m");
  force.stiffness = map.number("stiffness", turns ? "N m/rad" : "N/m");
  force.damping = map.number("damping", turns ? "N m s/rad" : "N s/m", 0.0);
  force.on = map.boolean("enabled", true);
  map.finish();
  model_.one_sided.push_back(std::move(force));
}

void ScenarioReader::read_friction(YamlMap& map, JointFriction friction) {
  friction.joint = map.choice("joint", "joint", joints_);
  friction.axis = std::max(map.choice("axis", "row", row_names()), 0);
  friction.coefficient = map.number("coefficient", "");
  if (friction.axis >= kRotX) friction.radius = map.number("radius", "m");
  friction.speed = map.number("speed", "m/s", 1e-3);
  friction.on = map.boolean("enabled", true);
  model_.frictions.push_back(std::move(friction));
}

// Reads a joint that separates at a load: it gets an event.
void ScenarioReader::read_parting(const YamlNode& node, const Joint& joint, int number) {
  YamlMap map(node, "parts", mistakes_);
  Event part;
  part.name = "part";
  part.subject = joint.name;
  part.when.kind = Condition::Kind::kAny;
  const auto add = [&](const char* key, Condition::Kind kind, const char* unit) {
    if (!map.find(key)) return;
    Condition load;
    load.kind = kind;
    load.subject = number;
    load.threshold = map.number(key, unit);
    if (!(load.threshold > 0))
      mistakes_.add(map.find(key)->mark, "it would part without any load", "a load greater than 0");
    part.when.parts.push_back(load);
  };
  add("force", Condition::Kind::kForceSize, "N");
  add("moment", Condition::Kind::kMomentSize, "N m");
  if (part.when.parts.empty()) mistakes_.add(node.mark, "no load at which it parts", "give `force`, `moment` or both");
  std::vector<std::string> names;
  for (const JointMode& mode : joint.modes) names.push_back(mode.name);
  Action open;
  open.subject = number;
  open.mode = std::max(map.choice("mode", "mode of joint '" + joint.name + "'", names), 0);
  part.then = {open};
  map.finish();
  if (!part.when.parts.empty()) parting_joints_.push_back(std::move(part));
}

Action ScenarioReader::read_impulse(YamlMap& map) {
  Impulse impulse;
  if (!map.find("linear") && !map.find("angular"))
    mistakes_.add(map.node().mark, "an impulse without a size", "give `linear`, in N s, `angular`, in N m s, or both");
  impulse.body = std::max(map.choice("body", "body", bodies_), 0);
  impulse.frame = map.choice("frame", "frame", {"body", "world"}, 0) == 1 ? Load::Frame::kWorld : Load::Frame::kBody;
  impulse.point = map.vector("point", "m", Eigen::Vector3d::Zero());
  impulse.linear = map.vector("linear", "N s", Eigen::Vector3d::Zero());
  impulse.angular = map.vector("angular", "N m s", Eigen::Vector3d::Zero());
  impulse.channel = map.choice("channel", "channel", channels_, kNone);
  Action action;
  action.kind = Action::Kind::kImpulse;
  action.subject = static_cast<int>(model_.impulses.size());
  model_.impulses.push_back(impulse);
  return action;
}

// Number of a cord with a drum among pushers, stops and cords.
int ScenarioReader::read_wound_cord(const YamlNode& node) {
  const int number = read_one_sided(node);
  if (static_cast<std::size_t>(number) < model_.one_sided.size() &&
      !model_.one_sided[static_cast<std::size_t>(number)].drum)
    mistakes_.add(node.mark, "'" + node.text + "' is not wound on anything", "a cord with `wraps`");
  return number;
}

// Number of a pusher, stop or cord among these.
int ScenarioReader::read_one_sided(const YamlNode& node) {
  std::vector<std::string> names;
  for (const OneSided& force : model_.one_sided) names.push_back(force.name);
  return std::max(read_choice(node, "pusher, stop or cord", names, mistakes_), 0);
}

// Reports joints that part into the mode that they never leave.
void ScenarioReader::report_idle_partings() {
  for (const Event& part : parting_joints_) {
    const Action& open = part.then[0];
    const Joint& joint = model_.joints[static_cast<std::size_t>(open.subject)];
    const std::string where = "joint '" + joint.name + "'";
    const auto leaves = [&](const Action& action) {
      return action.kind == Action::Kind::kSetMode && action.subject == open.subject && action.mode != open.mode;
    };
    const bool is_left =
        std::ranges::any_of(model_.events, [&](const Event& event) { return std::ranges::any_of(event.then, leaves); });
    if (open.mode != joint.mode || is_left || is_flawed(where)) continue;
    const YamlNode* const parts = nodes_.at(where)->find("parts");
    mistakes_.add(parts->find("mode")->mark, where + " parts into the mode in which it already is",
                  "a mode that holds fewer rows, or another `mode` at the start");
  }
}

// Appends the events of joints and elements to those of the scenario.
void ScenarioReader::append_events() {
  report_idle_partings();
  const int first = get_first_one_sided(model_);
  for (Event& event : cord_events_)
    for (Action& action : event.then) action.subject += first;
  const std::size_t own = model_.events.size();
  for (const std::vector<Event>* list : {&parting_joints_, &cord_events_})
    model_.events.insert(model_.events.end(), list->begin(), list->end());
  model_ = complete_events(model_);
  for (std::size_t i = own; i < model_.events.size(); ++i)
    event_names_.emplace_back(model_.events[i].name + ":" + model_.events[i].subject, static_cast<int>(i));
}

}  // namespace unlatch::hil
