// Shapes of bodies, the pairs whose clearance is watched, the points whose path is drawn.
#include <algorithm>

#include "hil/scenario/scenario_reader.h"

namespace unlatch::hil {

std::vector<Shape> ScenarioReader::read_shapes(const YamlNode& node) {
  std::vector<Shape> shapes;
  if (!node.is_sequence()) mistakes_.add(node.mark, "shape is not a list", "write [{sphere: {radius: 1}}]");
  for (const YamlNode& item : node.items) shapes.push_back(read_shape(item));
  return shapes;
}

Shape ScenarioReader::read_shape(const YamlNode& node) {
  static const std::vector<std::string> kKinds{"sphere", "capsule", "cylinder", "cone", "box", "hull"};
  Shape shape;
  YamlMap outer(node, "a shape", mistakes_);
  const std::string kind = outer.only_one_of(kKinds, "a kind");
  outer.finish();
  if (kind.empty()) return shape;
  shape.kind = static_cast<Shape::Kind>(std::find(kKinds.begin(), kKinds.end(), kind) - kKinds.begin());  // same order
  const YamlNode& value = *node.find(kind);
  YamlMap map(value, kind, mistakes_);
  const auto reject = [&](const std::string& what, const std::string& mend) { mistakes_.add(value.mark, what, mend); };
  const bool centred = kind == "sphere" || kind == "box";
  if (centred) shape.from = map.vector("centre", "m", Eigen::Vector3d::Zero());
  if (kind == "box") {
    shape.size = map.vector("size", "m");
    if (const YamlNode* attitude = map.find("attitude")) shape.q_BS = read_attitude(*attitude);
    if (!(shape.size.minCoeff() > 0)) reject("a box without volume", "size: three edge lengths greater than 0");
  } else if (kind == "hull") {
    const YamlNode* points = map.require("points");
    for (const YamlNode& point : points ? points->items : std::vector<YamlNode>())
      shape.points.push_back(read_vector(point, "m", Eigen::Vector3d::Zero(), mistakes_));
    if (shape.points.size() < 4) reject("a hull of fewer than four points", "points: [[x, y, z], …]");
  } else {
    if (!centred) {
      shape.from = map.vector("from", "m");
      shape.to = map.vector("to", "m");
      if (shape.from == shape.to) reject("from and to are the same point", "a sphere has no axis; else move one");
    }
    shape.radius = map.number("radius", "m");
    if (!(shape.radius > 0) && !(kind == "capsule" && shape.radius == 0))
      reject("a radius that is not positive", "a radius greater than 0 (capsules: 0 or more)");
  }
  map.finish();
  return shape;
}

void ScenarioReader::read_clearance(YamlMap& top) {
  const YamlNode* node = top.find("clearance");
  if (!node) return;
  const int count = static_cast<int>(bodies_.size());
  const auto has_shape = [&](int body) { return !scenario_.shapes[static_cast<std::size_t>(body)].empty(); };
  if (node->is_scalar() && node->text == "all") {
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b)
        if (has_shape(a) && has_shape(b)) scenario_.clearance.emplace_back(a, b);
    return;
  }
  if (!node->is_sequence()) mistakes_.add(node->mark, "not a list of pairs", "write [[core, booster1], …], or all");
  for (const YamlNode& pair : node->items) {
    if (!pair.is_sequence() || pair.items.size() != 2) {
      mistakes_.add(pair.mark, "not a pair of bodies", "write [core, booster1]");
      continue;
    }
    const int a = read_choice(pair.items[0], "body", bodies_, mistakes_);
    const int b = read_choice(pair.items[1], "body", bodies_, mistakes_);
    if (a < 0 || b < 0) continue;
    if (a == b) mistakes_.add(pair.mark, "a body and itself", "name two bodies");
    for (const int body : {a, b})
      if (!has_shape(body))
        mistakes_.add(pair.mark, "body '" + bodies_[static_cast<std::size_t>(body)] + "' has no shape",
                      "give it one, or leave the pair out");
    scenario_.clearance.emplace_back(a, b);
  }
}

void ScenarioReader::read_points(YamlMap& top) {
  std::vector<std::string> frames = bodies_;
  frames.push_back("ground");
  for_each_named(top, "points", "point", [&](const std::string& name, const YamlNode& node) {
    TracedPoint point{.name = name};
    YamlMap map(node, "a point", mistakes_);
    point.body = map.choice("body", "body", bodies_);
    point.p_BP = map.vector("at", "m", Eigen::Vector3d::Zero());
    const int ground = static_cast<int>(bodies_.size());
    const int frame = map.choice("seen_from", "body", frames, ground);
    point.seen_from = frame == ground ? kGround : frame;
    map.finish();
    if (point.body >= 0 && point.body == point.seen_from)
      mistakes_.add(map.node().find("seen_from")->mark, "a point that is seen from its own body does not move",
                    "name another body, or ground");
    scenario_.points.push_back(point);
  });
}

}  // namespace unlatch::hil
