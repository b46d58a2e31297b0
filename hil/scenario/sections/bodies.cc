// Bodies: mass, inertia, pose and velocity at the start.
#include <Eigen/Geometry>
#include <cmath>

#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/number_text.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

// Deviation of a quaternion's length from 1: a larger one is a mistake, a smaller one is rounding and is normalised.
constexpr double kUnitTolerance = 1e-3;

Eigen::Matrix3d read_inertia(const YamlNode& node, Mistakes& mistakes) {
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  const bool rows = node.is_sequence() && !node.items.empty() && node.items[0].is_sequence();
  if (!rows) {
    const std::vector<double> diagonal = read_numbers(node, 3, "kg m2", mistakes);
    for (int i = 0; i < 3; ++i) inertia(i, i) = diagonal[static_cast<std::size_t>(i)];
    return inertia;
  }
  if (node.items.size() != 3)
    mistakes.add(node.mark, "an inertia of " + hil::count(node.items.size(), "row"), "three rows of three");
  for (std::size_t i = 0; i < std::min<std::size_t>(3, node.items.size()); ++i) {
    const std::vector<double> row = read_numbers(node.items[i], 3, "kg m2", mistakes);
    inertia.row(static_cast<Eigen::Index>(i)) << row[0], row[1], row[2];
  }
  return inertia;
}

// Reads one value per knot of a law: a list of `count` items, or null nodes if `missing` is acceptable.
std::vector<const YamlNode*> read_knots(YamlMap& map, const std::string& key, std::size_t count, bool required,
                                        Mistakes& mistakes) {
  std::vector<const YamlNode*> out;
  const YamlNode* node = required ? map.require(key) : map.find(key);
  if (node == nullptr) return out;
  if (!node->is_sequence())
    mistakes.add(node->mark, key + " is not a list", "one for each of `at`");
  else if (node->items.size() != count)
    mistakes.add(node->mark,
                 key + " has " + hil::count(node->items.size(), "entry") + " for " + std::to_string(count) + " of `at`",
                 "one for each");
  else
    for (const YamlNode& item : node->items) out.push_back(&item);
  return out;
}

// Returns a marker with the pose and motion that its flexible body, already placed, gives it at the start.
Body place_marker(const Model& model, int marker) {
  Model pair;
  const Body& body = model.bodies[static_cast<std::size_t>(marker)];
  pair.bodies = {model.bodies[static_cast<std::size_t>(body.marker->body)], body};
  pair.bodies[1].marker->body = 0;
  return place_markers(pair).bodies[1];
}

}  // namespace

// Reads the mass of a body over time or burnt mass: columns of a table.
MassLaw ScenarioReader::read_law(const YamlNode& node) {
  MassLaw law;
  YamlMap map(node, "a mass law", mistakes_);
  const bool burnt = map.choice("of", "variable", {"time", "burnt"}) == 1;
  law.of = burnt ? MassLaw::Of::kBurnt : MassLaw::Of::kTime;
  const YamlNode* at = map.require("at");
  const std::size_t count = at != nullptr && at->is_sequence() ? at->items.size() : 0;
  if (at != nullptr && count == 0)
    mistakes_.add(at->mark, "at is not a list", burnt ? "kg burnt: [0 kg, 60 kg]" : "times: [0 s, 4 s]");
  for (std::size_t i = 0; i < count; ++i)
    law.knots.push_back({read_number(at->items[i], burnt ? "kg" : "s", 0.0, mistakes_), 0, Eigen::Vector3d::Zero(),
                         Eigen::Matrix3d::Zero()});
  const auto masses = read_knots(map, "mass", count, true, mistakes_);
  for (std::size_t i = 0; i < masses.size(); ++i) law.knots[i].mass = read_number(*masses[i], "kg", 0.0, mistakes_);
  const auto inertias = read_knots(map, "inertia", count, true, mistakes_);
  for (std::size_t i = 0; i < inertias.size(); ++i) law.knots[i].inertia = read_inertia(*inertias[i], mistakes_);
  const auto centres = read_knots(map, "centre_of_mass", count, false, mistakes_);
  for (std::size_t i = 0; i < centres.size(); ++i)
    law.knots[i].centre = read_vector(*centres[i], "m", Eigen::Vector3d::Zero(), mistakes_);
  if (const YamlNode* exit = map.find("jet_exit")) {
    law.jet_damping = true;
    law.exit = read_vector(*exit, "m", Eigen::Vector3d::Zero(), mistakes_);
  }
  map.finish();
  return law;
}

void ScenarioReader::read_bodies(YamlMap& top) {
  top.require("bodies");
  for_each_named(top, "bodies", "body", [&](const std::string& name, const YamlNode& node) { read_body(name, node); });
  place_bodies();
}

// Reads the mass: constant, by a law, or from a flexible body's file.
void ScenarioReader::read_mass(YamlMap& map, Body& body) {
  if (const YamlNode* flexible = map.find("flexible")) {
    read_flexible(*flexible, body);
  } else if (const YamlNode* law = map.find("law")) {
    body.law = read_law(*law);
    if (body.law->knots.empty()) return;
    body.mass = body.law->knots.front().mass;
    body.inertia = body.law->knots.front().inertia;
  } else {
    body.mass = map.number("mass", "kg");
    if (const YamlNode* inertia = map.require("inertia")) body.inertia = read_inertia(*inertia, mistakes_);
    // A constant law: its body's origin is a point of the structure. At the origin itself it is an ordinary body.
    const Eigen::Vector3d centre = map.vector("centre_of_mass", "m", Eigen::Vector3d::Zero());
    if (!centre.isZero(0))
      body.law.emplace(MassLaw{.of = MassLaw::Of::kTime, .knots = {{0, body.mass, centre, body.inertia}}});
  }
}

// Reads the position of the centre of mass; for a flexible body the origin of its modes file may be given instead.
Eigen::Vector3d ScenarioReader::read_position(YamlMap& map, const Body& body) {
  if (map.node().find("flexible") == nullptr || map.node().find("origin") == nullptr)
    return map.vector("position", "m", Eigen::Vector3d::Zero());
  return map.vector("origin", "m") + body.q_WB * structures_[body.name].centre;
}

void ScenarioReader::read_body(const std::string& name, const YamlNode& node) {
  Body body;
  body.name = name;
  YamlMap map(node, "body '" + name + "'", mistakes_);
  if (const YamlNode* marker = map.find("marker")) {
    read_marker(*marker, body);
  } else {
    read_mass(map, body);
    if (const YamlNode* attitude = map.find("attitude")) body.q_WB = read_attitude(*attitude);
    body.p_WB = read_position(map, body);
    body.v_WB = map.vector("velocity", "m/s", Eigen::Vector3d::Zero());
    body.w_WB_B = map.vector("rate", "rad/s", Eigen::Vector3d::Zero());
  }
  Placement placement;
  if (const YamlNode* relative_to = map.find("relative_to"); relative_to && body.marker)
    mistakes_.add(relative_to->mark, "a marker has its place from its flexible body", "leave `relative_to` out");
  else
    placement.relative_to = relative_to;
  placement.follows = body.marker.has_value();
  placement.parent = body.marker ? body.marker->body : kNone;
  const YamlNode* shape = map.find("shape");
  scenario_.shapes.push_back(shape ? read_shapes(*shape) : std::vector<BodyShape>());
  map.finish();
  bodies_.push_back(name);
  model_.bodies.push_back(std::move(body));
  placements_.push_back(placement);
}

// Transforms poses relative to other bodies into the inertial frame, parents first. A marker's parent is its flexible
// body; the pose that it has there is for its children only, the model's markers have none of their own.
void ScenarioReader::place_bodies() {
  for (std::size_t i = 0; i < placements_.size(); ++i)
    if (const YamlNode* parent = placements_[i].relative_to) {
      placements_[i].parent = read_choice(*parent, "body", bodies_, mistakes_);
      if (placements_[i].parent < 0) flawed_.insert("body '" + bodies_[i] + "'");
    }
  bool progress = true;
  while (progress) {
    progress = false;
    for (std::size_t i = 0; i < placements_.size(); ++i) {
      Placement& placement = placements_[i];
      const auto parent = static_cast<std::size_t>(placement.parent);
      if (placement.placed || (placement.parent >= 0 && !placements_[parent].placed)) continue;
      placement.placed = progress = true;
      if (placement.parent < 0) continue;
      if (is_flawed("body '" + bodies_[parent] + "'")) flawed_.insert("body '" + bodies_[i] + "'");
      if (placement.follows) continue;
      const Body a = placements_[parent].follows ? place_marker(model_, placement.parent) : model_.bodies[parent];
      Body& b = model_.bodies[i];
      const Eigen::Matrix3d R_WA = a.q_WB.toRotationMatrix();
      const Eigen::Vector3d arm = R_WA * b.p_WB, w_WA = R_WA * a.w_WB_B;
      b.w_WB_B = b.q_WB.conjugate() * a.w_WB_B + b.w_WB_B;
      b.v_WB = a.v_WB + w_WA.cross(arm) + R_WA * b.v_WB;
      b.p_WB = a.p_WB + arm;
      b.q_WB = (a.q_WB * b.q_WB).normalized();
    }
  }
  report_circles();
}

// Reports bodies that could not be placed: they are part of a circle of relative_to, or depend on one. Each circle is
// reported once, at its first body that has a relative_to; a marker depends on its body without one.
void ScenarioReader::report_circles() {
  std::vector<bool> seen(placements_.size(), false);
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    if (placements_[i].placed) continue;
    flawed_.insert("body '" + bodies_[i] + "'");
    if (placements_[i].follows) continue;
    std::string chain = bodies_[i];
    std::size_t at = i, steps = 0;
    do {
      at = static_cast<std::size_t>(placements_[at].parent);
      if (chain.size() < 200) chain += " -> " + bodies_[at];
    } while (at != i && !seen[at] && ++steps < placements_.size());
    if (at != i) continue;
    for (std::size_t k = i; !seen[k]; k = static_cast<std::size_t>(placements_[k].parent)) seen[k] = true;
    mistakes_.add(placements_[i].relative_to->mark, "relative_to goes round in a circle: " + chain,
                  "give one of them its place in the inertial frame");
  }
}

Eigen::Quaterniond ScenarioReader::read_attitude(const YamlNode& node) {
  if (!node.is_mapping()) {
    const std::vector<double> n = read_numbers(node, 4, "", mistakes_);
    Eigen::Quaterniond q(n[0], n[1], n[2], n[3]);
    if (node.is_sequence() && !(std::abs(q.norm() - 1) <= kUnitTolerance)) {
      mistakes_.add(node.mark, "a quaternion of length " + write_short(q.norm()), "[w, x, y, z] of length 1");
      return Eigen::Quaterniond::Identity();
    }
    return node.is_sequence() ? q.normalized() : Eigen::Quaterniond::Identity();
  }
  const YamlNode* rotations = node.find("rotate");
  if (!rotations) return Eigen::Quaterniond(read_frame(node)).normalized();
  YamlMap map(node, "an attitude", mistakes_);
  map.find("rotate");
  map.finish();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (const YamlNode& item : rotations->items) {
    if (!item.is_sequence() || item.items.size() != 2) {
      mistakes_.add(item.mark, "not a rotation", "write [axis, angle in rad]: [z, 0.1]");
      continue;
    }
    const int axis = read_choice(item.items[0], "axis", axis_names(), mistakes_);
    const double angle = read_number(item.items[1], "rad", 0.0, mistakes_);
    if (axis < 0) continue;
    double sine, cosine;  // not the C library's functions, whose bits depend on the processor
    elementary::sincos(0.5 * angle, sine, cosine);
    Eigen::Quaterniond turn(cosine, 0, 0, 0);
    turn.vec()[axis] = sine;
    q = q * turn;
  }
  if (!rotations->is_sequence()) mistakes_.add(rotations->mark, "not a list of rotations", "write [[z, 0.1], …]");
  return q.normalized();
}

// Reads two or three perpendicular axes as a right-handed frame.
Eigen::Matrix3d ScenarioReader::read_frame(const YamlNode& node) {
  constexpr double kRightAngle = 1e-9;  // rad; a larger deviation is not rounding but a mistake
  const std::size_t before = mistakes_.count();
  YamlMap map(node, "a frame", mistakes_);
  Eigen::Matrix3d frame = Eigen::Matrix3d::Zero();
  std::vector<int> given;
  for (int i = 0; i < 3; ++i) {
    const YamlNode* axis = map.find(axis_names()[static_cast<std::size_t>(i)]);
    if (!axis) continue;
    given.push_back(i);
    const Eigen::Vector3d v = read_vector(*axis, "", Eigen::Vector3d::Zero(), mistakes_);
    if (!(v.norm() > 1e-12) || !std::isfinite(v.norm()))
      mistakes_.add(axis->mark, "an axis without direction", "give a vector that is not zero");
    else
      frame.col(i) = v.normalized();
  }
  map.finish();
  const auto reject = [&](const std::string& what, const std::string& mend) -> Eigen::Matrix3d {
    if (mistakes_.count() == before) mistakes_.add(node.mark, what, mend);
    return Eigen::Matrix3d::Identity();
  };
  if (given.size() < 2) return reject("a frame of fewer than two axes", "give two of x, y, z; the third follows");
  for (std::size_t i = 0; i < given.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double cosine = frame.col(given[i]).dot(frame.col(given[j]));
      if (!(std::abs(cosine) < kRightAngle))
        return reject("axes that are not perpendicular: the cosine between them is " + write_short(cosine),
                      "make them perpendicular to 1e-9");
    }
  if (mistakes_.count() != before) return Eigen::Matrix3d::Identity();
  if (given.size() == 3 && frame.determinant() < 0)
    return reject("a left-handed frame", "z is x cross y; turn one axis round");
  const int missing = given.size() == 3 ? 2 : 3 - given[0] - given[1];
  const int a = (missing + 1) % 3, b = (missing + 2) % 3;
  frame.col(b) = (frame.col(b) - frame.col(a) * frame.col(a).dot(frame.col(b))).normalized();
  frame.col(missing) = frame.col(a).cross(frame.col(b));
  return frame;
}

}  // namespace unlatch::hil
