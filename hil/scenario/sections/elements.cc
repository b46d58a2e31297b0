// Elements, the channels that drive them, and the signals.
#include <algorithm>

#include "hil/scenario/model/index.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {

// SI unit of a channel. A channel's unit is text for people; if it is an SI unit, the channel's numbers may be given in
// other units of its kind.
std::string get_si(const Channel& channel) {
  static const std::vector<std::string> kUnits{"m", "kg", "s", "rad", "m/s", "rad/s", "N", "N m", "N/m", "m/s2"};
  return std::find(kUnits.begin(), kUnits.end(), channel.unit) == kUnits.end() ? "" : channel.unit;
}

void ScenarioReader::read_channels(YamlMap& top) {
  for_each_named(top, "channels", "channel", [&](const std::string& name, const YamlNode& node) {
    Channel channel;
    channel.name = name;
    YamlMap map(node, "channel '" + name + "'", mistakes_);
    if (const YamlNode* unit = map.find("unit")) channel.unit = read_text(*unit, mistakes_);
    const std::string si = get_si(channel);
    if (const YamlNode* range = map.find("range")) {
      const std::vector<double> limits = read_numbers(*range, 2, si, mistakes_);
      channel.minimum = limits[0];
      channel.maximum = limits[1];
    }
    channel.initial = map.number("initial", si, 0.0);
    channel.safe = map.number("safe", si, channel.initial);
    if (channel.unit.size() >= 48) mistakes_.add(node.mark, "a unit of more than 47 bytes", "write it shorter");
    map.finish();
    channels_.push_back(name);
    model_.channels.push_back(std::move(channel));
  });
}

// Reads signals: the listed ones, and after them those that events raise.
void ScenarioReader::read_signals(YamlMap& top) {
  std::vector<std::string>& signals = model_.signals;
  if (const YamlNode* node = top.find("signals")) {
    if (!node->is_sequence()) mistakes_.add(node->mark, "signals is not a list", "write their names: [kr1, kr2]");
    for (const YamlNode& item : node->items) {
      const std::string name = read_name(item, mistakes_);
      nodes_["signal '" + name + "'"] = &item;
      scenario_.marks["signal '" + name + "'"] = item.mark;
      signals.push_back(name);
    }
  }
  if (const YamlNode* events = top.find("events")) collect_signals(*events);
}

void ScenarioReader::collect_signals(const YamlNode& events) {
  const auto declare = [&](const YamlNode& name) {
    if (!name.is_scalar() || !is_name(name.text)) return;  // reported where the action is read
    for (const std::string& signal : model_.signals)
      if (signal == name.text) return;
    model_.signals.push_back(name.text);
    scenario_.marks["signal '" + name.text + "'"] = name.mark;
  };
  for (const YamlNode& event : events.items) {
    const YamlNode* then = event.find("then");
    if (!then) continue;
    for (const YamlNode& action : then->items) {
      const YamlNode* raise = action.find("raise");
      if (!raise) continue;
      const YamlNode* signal = raise->is_mapping() ? raise->find("signal") : raise;
      if (signal) declare(*signal);
    }
  }
}

void ScenarioReader::read_elements(YamlMap& top) {
  for_each_named(top, "elements", "element",
                 [&](const std::string& name, const YamlNode& node) { read_element(name, node); });
  for_each_named(top, "stops", "element",
                 [&](const std::string& name, const YamlNode& node) { read_stop(name, node); });
  for (int i = 0; i < model_.element_count(); ++i) elements_.push_back(model_.element_name(i));
}

namespace {

template <class Item>
Item make_named(const std::string& name) {
  Item item;
  item.name = name;
  return item;
}

}  // namespace

// Types of elements: what stands at `type`, and what reads the rest of its keys. A new kind of element is a line here.
const std::vector<ScenarioReader::ElementType>& ScenarioReader::get_element_types() {
  using Reader = ScenarioReader;
  static const auto read_turnable = [](Reader& reader, YamlMap& map, Load load) {
    const int frame = map.choice("frame", "frame", {"body", "world"}, 0);
    load.frame = frame == 1 ? Load::Frame::kWorld : Load::Frame::kBody;
    reader.read_load(map, std::move(load));
  };
  static const std::vector<ElementType> kTypes{
      {"thrust", [](Reader& r, YamlMap& map, const std::string& name) { r.read_load(map, make_named<Load>(name)); }},
      {"force",
       [](Reader& r, YamlMap& map, const std::string& name) { read_turnable(r, map, make_named<Load>(name)); }},
      {"torque",
       [](Reader& r, YamlMap& map, const std::string& name) {
         Load load = make_named<Load>(name);
         load.kind = Load::Kind::kTorque;
         read_turnable(r, map, std::move(load));
       }},
      {"spring", [](Reader& r, YamlMap& map,
                    const std::string& name) { r.read_point_spring(map, make_named<PointSpring>(name)); }},
      {"joint_spring", [](Reader& r, YamlMap& map,
                          const std::string& name) { r.read_joint_spring(map, make_named<JointSpring>(name)); }},
      {"plane_torsion", [](Reader& r, YamlMap& map,
                           const std::string& name) { r.read_plane_torsion(map, make_named<PlaneTorsion>(name)); }},
      {"pusher",
       [](Reader& r, YamlMap& map, const std::string& name) { r.read_pusher(map, make_named<OneSided>(name)); }},
      {"cord", [](Reader& r, YamlMap& map, const std::string& name) { r.read_cord(map, make_named<OneSided>(name)); }},
      {"joint_friction",
       [](Reader& r, YamlMap& map, const std::string& name) { r.read_friction(map, make_named<JointFriction>(name)); }},
      {"aerodynamics", [](Reader& r, YamlMap& map,
                          const std::string& name) { r.read_aerodynamics(map, make_named<Aerodynamics>(name)); }},
  };
  return kTypes;
}

void ScenarioReader::read_element(const std::string& name, const YamlNode& node) {
  const std::vector<ElementType>& types = get_element_types();
  std::vector<std::string> names;
  for (const ElementType& type : types) names.push_back(type.name);
  YamlMap map(node, "element '" + name + "'", mistakes_);
  const int type = map.choice("type", "element type", names);
  if (type < 0) return;  // the valid keys depend on the type
  types[at(type)].read(*this, map, name);
  map.finish();
}

// What a force has beside where it should be: `offset` of its point, and `misalignment`, the rotation vector by which
// its direction is turned, both in the axes of the direction.
void ScenarioReader::read_misalignment(YamlMap& map, Load& load) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  load.point += map.vector("offset", "m", none);
  const Eigen::Vector3d turn = map.vector("misalignment", "rad", none);
  const double angle = turn.norm();
  if (angle == 0) return;
  const Eigen::Vector3d axis = turn / angle, d = load.direction;
  double sine, cosine;
  elementary::sincos(angle, sine, cosine);
  load.direction = d * cosine + axis.cross(d) * sine + axis * (axis.dot(d) * (1 - cosine));
}

void ScenarioReader::read_load(YamlMap& map, Load load) {
  load.body = map.choice("body", "body", bodies_);
  const bool force = load.kind == Load::Kind::kForce;
  if (force) load.point = map.vector("point", "m", Eigen::Vector3d::Zero());
  const std::size_t before = mistakes_.count();
  const Eigen::Vector3d direction = map.vector("direction", "");
  if (direction.isZero(0) && mistakes_.count() == before)
    mistakes_.add(map.find("direction")->mark, "its direction is zero",
                  "a vector along which it acts; `scale: 0` makes it dead");
  load.direction = direction * map.number("scale", "", 1.0);
  if (force) read_misalignment(map, load);
  if (const YamlNode* profile = map.require("profile"))
    load.profile = read_profile(*profile, force ? "N" : "N m", load.name);
  load.channel = map.choice("channel", "channel", channels_, kNone);
  if (force) {
    load.consumption = map.number("consumption", "kg/(N s)", 0.0);
    load.tank = map.choice("tank", "body", bodies_, kNone);
  }
  load.on = map.boolean("enabled", true);
  model_.loads.push_back(std::move(load));
}

void ScenarioReader::read_point_spring(YamlMap& map, PointSpring spring) {
  read_between(map, spring.base, spring.follower);
  spring.point_base = map.vector("point", "m", Eigen::Vector3d::Zero());
  spring.point_follower = map.vector("follower_point", "m", Eigen::Vector3d::Zero());
  spring.stiffness = map.number("stiffness", "N/m");
  spring.damping = map.number("damping", "N s/m", 0.0);
  spring.free_length = map.number("free_length", "m", 0.0);
  spring.push_only = map.boolean("push_only", false);
  spring.on = map.boolean("enabled", true);
  model_.point_springs.push_back(std::move(spring));
}

void ScenarioReader::read_joint_spring(YamlMap& map, JointSpring spring) {
  spring.joint = map.choice("joint", "joint", joints_);
  spring.axis = map.choice("axis", "row", row_names());
  const bool turns = spring.axis >= kRotX;
  spring.effort = map.number("effort", turns ? "N m" : "N", 0.0);
  spring.stiffness = map.number("stiffness", turns ? "N m/rad" : "N/m", 0.0);
  spring.damping = map.number("damping", turns ? "N m s/rad" : "N s/m", 0.0);
  spring.rest = map.number("rest", turns ? "rad" : "m", 0.0);
  spring.on = map.boolean("enabled", true);
  if (map.find("implicit")) spring.implicit = map.boolean("implicit", true);
  if (map.boolean("while_free", false)) scenario_.springs_while_free.push_back(spring.name);
  model_.joint_springs.push_back(std::move(spring));
}

void ScenarioReader::read_plane_torsion(YamlMap& map, PlaneTorsion torsion) {
  read_between(map, torsion.base, torsion.follower);
  torsion.normal_base = map.vector("normal", "").stableNormalized();
  torsion.axis_follower = map.vector("axis", "").stableNormalized();
  torsion.stiffness = map.number("stiffness", "N m/rad");
  torsion.damping = map.number("damping", "N m s/rad", 0.0);
  torsion.on = map.boolean("enabled", true);
  model_.plane_torsions.push_back(std::move(torsion));
}

// Reads a profile of an element. A number alone is constant.
Profile ScenarioReader::read_profile(const YamlNode& node, const std::string& unit, const std::string& element) {
  Profile profile;
  if (node.is_scalar()) {
    profile.value = read_number(node, unit, 0.0, mistakes_);
    return profile;
  }
  YamlMap map(node, "a profile", mistakes_);
  const std::string kind = map.only_one_of({"constant", "exponential", "table", "harmonic", "expression"}, "a kind");
  if (kind == "constant") profile.value = map.number("constant", unit);
  if (kind == "exponential") {
    profile.kind = Profile::Kind::kExponential;
    YamlMap inner(*map.find(kind), kind, mistakes_);
    profile.initial = inner.number("initial", unit);
    profile.final = inner.number("final", unit);
    profile.tau = inner.number("tau", "s");
    inner.finish();
  }
  if (kind == "table") {
    profile.kind = Profile::Kind::kTable;
    YamlMap inner(*map.find(kind), kind, mistakes_);
    if (const YamlNode* times = inner.require("times")) profile.times = read_numbers(*times, 0, "s", mistakes_);
    if (const YamlNode* values = inner.require("values")) profile.values = read_numbers(*values, 0, unit, mistakes_);
    inner.finish();
  }
  if (kind == "harmonic") {
    profile.kind = Profile::Kind::kHarmonic;
    const YamlNode& list = *map.find(kind);
    if (!list.is_sequence())
      mistakes_.add(list.mark, "harmonic is not a list", "write [{amplitude: 1, frequency: 2, phase: 0}, …]");
    for (const YamlNode& item : list.items) {
      YamlMap inner(item, "a harmonic", mistakes_);
      const double amplitude = inner.number("amplitude", unit), frequency = inner.number("frequency", "rad/s");
      profile.harmonics.push_back({amplitude, frequency, inner.number("phase", "rad", 0.0)});
      inner.finish();
    }
  }
  if (kind == "expression") {
    profile.kind = Profile::Kind::kLaw;
    profile.law = read_law(map, unit, "profile of " + element, element);
  }
  map.finish();
  return profile;
}

}  // namespace unlatch::hil
