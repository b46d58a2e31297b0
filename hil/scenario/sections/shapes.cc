// Shapes of bodies, and the points whose path is drawn.
#include <algorithm>

#include "hil/scenario/base/from_eigen.h"
#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/shapes/mesh_file.h"

namespace unlatch::hil {
namespace {

using geometry::Shape;
using geometry::ShapeKind;

// Kinds of shapes by their names in scenarios.
struct KindOfShape {
  const char* key;
  ShapeKind kind;
};
constexpr KindOfShape kKinds[] = {
    {"sphere", ShapeKind::kSphere},
    {"capsule", ShapeKind::kCapsule},
    {"cylinder", ShapeKind::kCylinder},
    {"cone", ShapeKind::kCone},
    {"frustum", ShapeKind::kFrustum},
    {"box", ShapeKind::kBox},
    {"hull", ShapeKind::kHull},
    {"half_space", ShapeKind::kHalfSpace},
    {"hollow_cylinder", ShapeKind::kHollow},
    {"hollow_frustum", ShapeKind::kHollow},
    {"hollow_profile", ShapeKind::kHollow},
};

constexpr const char* kMesh = "mesh";

// Keys of a scenario that set a member of Shape.
std::vector<std::string> list_keys(const std::string& member) {
  if (member == "from") return {"from", "centre", "point"};
  if (member == "to") return {"to", "axis"};
  if (member == "side") return {"half"};
  return {member};
}

}  // namespace

std::vector<BodyShape> ScenarioReader::read_shapes(const YamlNode& node) {
  std::vector<BodyShape> shapes;
  if (!node.is_sequence()) mistakes_.add(node.mark, "shape is not a list", "write [{sphere: {radius: 1}}]");
  for (const YamlNode& item : node.items) shapes.push_back(read_body_shape(item));
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const std::string& name = shapes[i].name;
    for (std::size_t k = 0; k < shapes.size() && !name.empty(); ++k)
      if ((k < i && shapes[k].name == name) || shapes[k].group == name)
        mistakes_.add(node.items[i].find("name")->mark, "another shape or group of this body is called '" + name + "'",
                      "give it a name of its own; several shapes with one `group` have one name together");
  }
  return shapes;
}

// Reads shapes that are fixed in W.
void ScenarioReader::read_ground(YamlMap& top) {
  const YamlNode* const node = top.find("ground");
  if (node == nullptr) return;
  YamlMap map(*node, "the ground", mistakes_);
  if (const YamlNode* shape = map.require("shape")) scenario_.ground_shapes = read_shapes(*shape);
  map.finish();
}

BodyShape ScenarioReader::read_body_shape(const YamlNode& node) {
  BodyShape out;
  YamlMap map(node, "a shape", mistakes_);
  std::vector<std::string> keys;
  for (const KindOfShape& kind : kKinds) keys.emplace_back(kind.key);
  keys.emplace_back(kMesh);
  const std::string key = map.only_one_of(keys, "a kind");
  if (const YamlNode* name = map.find("name")) out.name = read_name(*name, mistakes_);
  if (const YamlNode* group = map.find("group")) out.group = read_name(*group, mistakes_);
  map.finish();
  if (key == kMesh)
    out.mesh = read_mesh_shape(*node.find(key));
  else if (!key.empty())
    out.shape = read_shape(key, *node.find(key));
  return out;
}

// Reads {file: part.stl, scale: 1 mm, origin: [x, y, z], attitude: …}. Null: a mistake has been noted.
std::shared_ptr<const TriangleMesh> ScenarioReader::read_mesh_shape(const YamlNode& node) {
  YamlMap map(node, kMesh, mistakes_);
  const YamlNode* file = map.require("file");
  MeshPlace place;
  place.scale = read_bounded(map, get_number_key("scenario.mesh.scale"), place.scale, mistakes_);
  place.origin = to_vec3(map.vector("origin", "m", Eigen::Vector3d::Zero()));
  if (const YamlNode* attitude = map.find("attitude")) {
    const Eigen::Quaterniond q = read_attitude(*attitude);
    place.q_BM = {q.w(), q.x(), q.y(), q.z()};
  }
  map.finish();
  if (file == nullptr) return nullptr;
  const std::string name = read_text(*file, mistakes_);
  try {
    place.file = resolve_include("", name);
    for (const std::shared_ptr<const TriangleMesh>& known : known_meshes_)
      if (is_same(known->get_place(), place)) {
        sources_.read(place.file);
        return known;
      }
    const auto convert = [&](const std::string& bytes) { return write_mesh_text(read_mesh(bytes, place.file)); };
    const std::string& text = sources_.read(place.file, {"mesh", kMaxMeshFile, convert});
    const MeshData data = is_mesh_text(text) ? read_mesh_text(text) : read_mesh(text, place.file);
    return known_meshes_.emplace_back(std::make_shared<const TriangleMesh>(place, data));
  } catch (const std::runtime_error& error) {
    mistakes_.add(file->mark, "this mesh cannot be read: " + std::string(error.what()),
                  "an STL or OBJ file in or below the scenario's folder");
    return nullptr;
  }
}

Shape ScenarioReader::read_shape(const std::string& key, const YamlNode& node) {
  Shape shape;
  shape.kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const KindOfShape& k) { return key == k.key; })->kind;
  const std::size_t before = mistakes_.count();
  YamlMap map(node, key, mistakes_);
  switch (shape.kind) {
    case ShapeKind::kSphere:
      shape.from = to_vec3(map.vector("centre", "m", Eigen::Vector3d::Zero()));
      shape.radius = map.number("radius", "m");
      break;
    case ShapeKind::kBox:
      shape.from = to_vec3(map.vector("centre", "m", Eigen::Vector3d::Zero()));
      shape.size = to_vec3(map.vector("size", "m"));
      if (const YamlNode* attitude = map.find("attitude")) {
        const Eigen::Quaterniond q = read_attitude(*attitude);
        shape.q_BS = {q.w(), q.x(), q.y(), q.z()};
      }
      break;
    case ShapeKind::kHull: {
      const YamlNode* points = map.require("points");
      if (points && !points->is_sequence()) mistakes_.add(points->mark, "points is not a list", "write [[x, y, z], …]");
      for (const YamlNode& point : points ? points->items : std::vector<YamlNode>())
        shape.points.push_back(to_vec3(read_vector(point, "m", Eigen::Vector3d::Zero(), mistakes_)));
      break;
    }
    case ShapeKind::kHalfSpace:
      shape.from = to_vec3(map.vector("point", "m", Eigen::Vector3d::Zero()));
      shape.normal = to_vec3(map.vector("normal", ""));
      break;
    case ShapeKind::kHollow:
      read_hollow(key, map, shape);
      break;
    default:
      shape.from = to_vec3(map.vector("from", "m"));
      shape.to = to_vec3(map.vector("to", "m"));
      shape.radius = map.number("radius", "m");
      if (shape.kind == ShapeKind::kFrustum) shape.end_radius = map.number("end_radius", "m");
  }
  map.finish();
  if (mistakes_.count() == before) report_shape(shape, node);
  return shape;
}

// Reads the profile of a wall: a cylinder's, a frustum's, or a given one.
void ScenarioReader::read_hollow(const std::string& key, YamlMap& map, Shape& shape) {
  shape.from = to_vec3(map.vector("from", "m"));
  if (key == "hollow_profile") {
    shape.to = shape.from + to_vec3(map.vector("axis", ""));
    const YamlNode* profile = map.require("profile");
    if (profile && !profile->is_sequence())
      mistakes_.add(profile->mark, "profile is not a list", "write [[z, r], …], in m");
    for (const YamlNode& point : profile ? profile->items : std::vector<YamlNode>()) {
      const std::vector<double> zr = read_numbers(point, 2, "m", mistakes_);
      shape.profile.push_back({zr[0], zr[1]});
    }
  } else {
    shape.to = to_vec3(map.vector("to", "m"));
    shape.radius = map.number("radius", "m");
    shape.end_radius = key == "hollow_frustum" ? map.number("end_radius", "m") : shape.radius;
    if (key == "hollow_cylinder" && !(shape.radius > 0))
      mistakes_.add(map.node().find("radius") ? map.node().find("radius")->mark : map.node().mark,
                    "a wall without extent", "a radius greater than 0");
    shape.profile = {{0, shape.radius}, {norm(shape.to - shape.from), shape.end_radius}};
  }
  if (const YamlNode* half = map.find("half")) {
    shape.half = true;
    shape.side = to_vec3(read_vector(*half, "", Eigen::Vector3d::Zero(), mistakes_));
  }
}

// Reports the geometry's mistakes, at the keys that they concern.
void ScenarioReader::report_shape(const Shape& shape, const YamlNode& node) {
  for (const geometry::ShapeError& error : geometry::check_shape(shape)) {
    SourceMark mark = node.mark;
    for (const std::string& key : list_keys(error.key))
      if (const YamlNode* value = node.find(key)) mark = value->mark;
    mistakes_.add(mark, error.what, error.mend);
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
