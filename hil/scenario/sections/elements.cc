// Elements, the channels that drive them, and the signals.
#include <algorithm>
#include <array>

#include "hil/scenario/base/index.h"
#include "hil/scenario/language/bounded_number.h"
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
    if (!check_name(name, node, "channel", Minus::kAllowed)) return;
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
}

// Readers of the types of elements: each reads the keys of its type and adds the element to the model. A new type is a
// function here and a line of kTypes.
struct ElementReader {
  ScenarioReader& in;
  YamlMap& map;
  const std::string& name;

  struct Type {
    const char* name;  // what stands at `type`
    void (ElementReader::*read)();
  };
  static const Type kTypes[];

  template <class Item>
  [[nodiscard]] Item make_named() const {
    Item item;
    item.name = name;
    return item;
  }

  void read_thrust() { read_load(make_named<Load>()); }
  void read_force() { read_turnable(make_named<Load>()); }
  void read_torque() {
    Load load = make_named<Load>();
    load.kind = Load::Kind::kTorque;
    read_turnable(std::move(load));
  }
  void read_turnable(Load load);
  void read_load(Load load);
  void read_misalignment(Load& load);
  void read_spring();
  void read_joint_spring();
  void read_plane_torsion();
  void read_pusher() { in.read_pusher(map, make_named<OneSided>()); }
  void read_cord() { in.read_cord(map, make_named<OneSided>()); }
  void read_friction() { in.read_friction(map, make_named<JointFriction>()); }
  void read_aerodynamics();
  void read_coefficient(const YamlNode& node, AeroTerm term, Aerodynamics& air);
  void read_aero_term(const YamlNode& node, AeroTerm term, Aerodynamics& air);
};

constexpr ElementReader::Type ElementReader::kTypes[] = {
    {"thrust", &ElementReader::read_thrust},
    {"force", &ElementReader::read_force},
    {"torque", &ElementReader::read_torque},
    {"spring", &ElementReader::read_spring},
    {"joint_spring", &ElementReader::read_joint_spring},
    {"plane_torsion", &ElementReader::read_plane_torsion},
    {"pusher", &ElementReader::read_pusher},
    {"cord", &ElementReader::read_cord},
    {"joint_friction", &ElementReader::read_friction},
    {"aerodynamics", &ElementReader::read_aerodynamics},
};

void ScenarioReader::read_element(const std::string& name, const YamlNode& node) {
  std::vector<std::string> names;
  for (const ElementReader::Type& type : ElementReader::kTypes) names.emplace_back(type.name);
  YamlMap map(node, "element '" + name + "'", mistakes_);
  const int type = map.choice("type", "element type", names);
  if (type < 0) return;  // the valid keys depend on the type
  ElementReader reader{*this, map, name};
  (reader.*ElementReader::kTypes[type].read)();
  map.finish();
}

void ElementReader::read_turnable(Load load) {
  const int frame = map.choice("frame", "frame", {"body", "world"}, 0);
  load.frame = frame == 1 ? Load::Frame::kWorld : Load::Frame::kBody;
  read_load(std::move(load));
}

// What a force has beside where it should be: `offset` of its point, and `misalignment`, the rotation vector by which
// its direction is turned, both in the axes of the direction.
void ElementReader::read_misalignment(Load& load) {
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

void ElementReader::read_load(Load load) {
  load.body = map.choice("body", "body", in.bodies_);
  const bool force = load.kind == Load::Kind::kForce;
  if (force) load.point = map.vector("point", "m", Eigen::Vector3d::Zero());
  const std::size_t before = in.mistakes_.count();
  const Eigen::Vector3d direction = map.vector("direction", "");
  if (direction.isZero(0) && in.mistakes_.count() == before)
    in.mistakes_.add(map.find("direction")->mark, "its direction is zero",
                     "a vector along which it acts; `scale: 0` makes it dead");
  load.direction = direction * map.number("scale", "", 1.0);
  if (force) read_misalignment(load);
  if (const YamlNode* profile = map.require("profile"))
    load.profile = in.read_profile(*profile, force ? "N" : "N m", load.name);
  load.channel = map.choice("channel", "channel", in.channels_, kNone);
  if (force) {
    load.consumption = map.number("consumption", "kg/(N s)", 0.0);
    load.tank = map.choice("tank", "body", in.bodies_, kNone);
  }
  load.on = map.boolean("enabled", true);
  in.model_.loads.push_back(std::move(load));
}

void ElementReader::read_spring() {
  PointSpring spring = make_named<PointSpring>();
  in.read_between(map, spring.base, spring.follower);
  spring.point_base = map.vector("point", "m", Eigen::Vector3d::Zero());
  spring.point_follower = map.vector("follower_point", "m", Eigen::Vector3d::Zero());
  spring.stiffness = map.number("stiffness", "N/m");
  spring.damping = map.number("damping", "N s/m", 0.0);
  spring.free_length = map.number("free_length", "m", 0.0);
  spring.push_only = map.boolean("push_only", false);
  spring.on = map.boolean("enabled", true);
  in.model_.point_springs.push_back(std::move(spring));
}

void ElementReader::read_joint_spring() {
  JointSpring spring = make_named<JointSpring>();
  spring.joint = map.choice("joint", "joint", in.joints_);
  spring.axis = map.choice("axis", "row", row_names());
  const bool turns = spring.axis >= kRotX;
  spring.effort = map.number("effort", turns ? "N m" : "N", 0.0);
  spring.stiffness = map.number("stiffness", turns ? "N m/rad" : "N/m", 0.0);
  spring.damping = map.number("damping", turns ? "N m s/rad" : "N s/m", 0.0);
  spring.rest = map.number("rest", turns ? "rad" : "m", 0.0);
  spring.on = map.boolean("enabled", true);
  if (map.find("implicit")) spring.implicit = map.boolean("implicit", true);
  if (map.boolean("while_free", false)) in.scenario_.springs_while_free.push_back(spring.name);
  in.model_.joint_springs.push_back(std::move(spring));
}

void ElementReader::read_plane_torsion() {
  PlaneTorsion torsion = make_named<PlaneTorsion>();
  in.read_between(map, torsion.base, torsion.follower);
  torsion.normal_base = map.vector("normal", "").stableNormalized();
  torsion.axis_follower = map.vector("axis", "").stableNormalized();
  torsion.stiffness = map.number("stiffness", "N m/rad");
  torsion.damping = map.number("damping", "N m s/rad", 0.0);
  torsion.on = map.boolean("enabled", true);
  in.model_.plane_torsions.push_back(std::move(torsion));
}

namespace {

constexpr std::array<const char*, 7> kCoefficients{"cx", "cy", "cz", "cl", "cm", "cn", "drag"};  // as AeroTerm::Of

bool is_moment(AeroTerm::Of of) {
  return of == AeroTerm::Of::kRoll || of == AeroTerm::Of::kPitch || of == AeroTerm::Of::kYaw;
}

}  // namespace

// Coefficients are numbers, expressions, and sums of them.
void ElementReader::read_aerodynamics() {
  Aerodynamics air = make_named<Aerodynamics>();
  air.body = map.choice("body", "body", in.bodies_);
  air.area = read_bounded(map, get_number_key("scenario.aerodynamics.area"), {}, in.mistakes_);
  air.point = map.vector("point", "m", Eigen::Vector3d::Zero());
  const YamlNode *const length = map.find("length"), *const lengths = map.find("lengths");
  if (length != nullptr && lengths != nullptr)
    in.mistakes_.add(lengths->mark, "it has a length and three lengths", "write one of them");
  if (length != nullptr)
    air.lengths.setConstant(read_bounded(map, get_number_key("scenario.aerodynamics.length"), 1.0, in.mistakes_));
  else if (lengths != nullptr)
    air.lengths = read_vector(*lengths, "m", Eigen::Vector3d::Ones(), in.mistakes_);
  for (std::size_t i = 0; i < kCoefficients.size(); ++i)
    if (const YamlNode* node = map.find(kCoefficients[i]))
      read_coefficient(*node, {static_cast<AeroTerm::Of>(i), kNone, 0, kNone}, air);
  if (const YamlNode* node = map.find("damping")) {
    YamlMap damping(*node, "damping", in.mistakes_);
    for (std::size_t i = 0; i < kCoefficients.size(); ++i) {
      const YamlNode* rates = damping.find(kCoefficients[i]);
      if (!rates) continue;
      if (!rates->is_sequence() || rates->items.size() != 3) {
        in.mistakes_.add(rates->mark, "these are not three derivatives", "write those by p, q and r: [-0.4, 0, 0]");
        continue;
      }
      for (int rate = 0; rate < 3; ++rate)
        read_coefficient(rates->items[static_cast<std::size_t>(rate)], {static_cast<AeroTerm::Of>(i), rate, 0, kNone},
                         air);
    }
    damping.finish();
  }
  if (length == nullptr && lengths == nullptr)
    for (const AeroTerm& term : air.terms)
      if (is_moment(term.of) || term.rate != kNone) {
        in.mistakes_.add(map.node().mark, "its moments have no length", "give its `length`, or three `lengths`");
        break;
      }
  air.on = map.boolean("enabled", true);
  in.model_.aerodynamics.push_back(std::move(air));
}

// A number, an expression, or a list of these, which is their sum.
void ElementReader::read_coefficient(const YamlNode& node, AeroTerm term, Aerodynamics& air) {
  if (!node.is_sequence()) return read_aero_term(node, term, air);
  for (const YamlNode& item : node.items) read_aero_term(item, term, air);
}

void ElementReader::read_aero_term(const YamlNode& node, AeroTerm term, Aerodynamics& air) {
  if (node.is_mapping()) {
    YamlMap coefficient(node, "a coefficient", in.mistakes_);
    if (coefficient.require("expression") != nullptr) {
      term.law = in.read_law(coefficient, "", "coefficient " + std::to_string(air.terms.size() + 1) + " of " + air.name,
                             air.name);
      air.terms.push_back(term);
    }
    coefficient.finish();
    return;
  }
  term.value = read_number(node, "", 0.0, in.mistakes_);
  if (term.value != 0) air.terms.push_back(term);
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
