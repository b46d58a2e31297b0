#include "hil/scenario/shapes/clearance.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "hil/scenario/shapes/mesh_tree.h"

namespace unlatch::hil {
namespace {

enum class Meshes { kLeftOut, kAsSpheres };

geometry::ShapeGroup build_group(const std::string& name, const std::vector<BodyShape>& shapes,
                                 const std::vector<int>& chosen, Meshes about = Meshes::kLeftOut) {
  std::vector<geometry::Shape> list;
  for (const int i : chosen) {
    if (i < 0 || static_cast<std::size_t>(i) >= shapes.size())
      throw std::invalid_argument("clearance: " + name + " has no shape " + std::to_string(i));
    const BodyShape& shape = shapes[static_cast<std::size_t>(i)];
    if (!shape.mesh)
      list.push_back(shape.shape);
    else if (about == Meshes::kAsSpheres)
      list.push_back(
          {.kind = geometry::ShapeKind::kSphere, .from = shape.mesh->get_centre(), .radius = shape.mesh->get_bound()});
  }
  return geometry::build_group(name, list);
}

bool has_mesh(const std::vector<BodyShape>& shapes, int i) {
  return i >= 0 && static_cast<std::size_t>(i) < shapes.size() && shapes[static_cast<std::size_t>(i)].mesh;
}

// A hollow shape is a wall, a mesh anything.
bool is_convex(const std::vector<BodyShape>& shapes, int i) {
  return shapes[static_cast<std::size_t>(i)].shape.kind != geometry::ShapeKind::kHollow;
}

// Groups the kernel's shapes of `a` by the shapes of `b` that remain for them after the exceptions.
std::map<std::vector<int>, std::vector<int>> split(const ClearancePair& pair, const std::vector<BodyShape>& a,
                                                   const std::vector<BodyShape>& b) {
  std::map<std::vector<int>, std::vector<int>> parts;
  for (const int i : pair.a.shapes) {
    if (has_mesh(a, i)) continue;
    std::vector<int> left;
    for (const int k : pair.b.shapes)
      if (!has_mesh(b, k) && !pair.is_excepted(i, k)) left.push_back(k);
    if (!left.empty()) parts[left].push_back(i);
  }
  return parts;
}

}  // namespace

const char* get_method_name(DistanceMethod method) {
  return method == DistanceMethod::kMesh ? "mesh (triangles)" : "exact";
}

geometry::Placement to_placement(const BodyState& body) { return {body.p, rotation_matrix(body.q)}; }

geometry::Placement to_placement(const Pose& pose) {
  const Eigen::Vector3d& p = pose.p_WB;
  const Eigen::Quaterniond& q = pose.q_WB;
  return {{p.x(), p.y(), p.z()}, rotation_matrix(Quat{q.w(), q.x(), q.y(), q.z()})};
}

ClearanceMonitor::ClearanceMonitor(const std::vector<ClearancePair>& pairs,
                                   const std::vector<std::vector<BodyShape>>& shapes,
                                   const std::vector<BodyShape>& ground) {
  const auto get_shapes = [&](const ShapeSet& set) -> const std::vector<BodyShape>& {
    if (set.body == kGround && !set.shapes.empty()) return ground;
    if (set.body < 0 || static_cast<std::size_t>(set.body) >= shapes.size() || set.shapes.empty())
      throw std::invalid_argument("clearance: " + set.name + " has no shape");
    return shapes[static_cast<std::size_t>(set.body)];
  };
  for (const ClearancePair& pair : pairs) {
    clearances_.push_back({.a = pair.a.body, .b = pair.b.body, .name_a = pair.a.name, .name_b = pair.b.name});
    std::vector<Part>& parts = parts_.emplace_back();
    const std::vector<BodyShape>&of_pair_a = get_shapes(pair.a), &of_pair_b = get_shapes(pair.b);
    for (const auto& [of_b, of_a] : split(pair, of_pair_a, of_pair_b))
      parts.push_back({.groups = geometry::GroupPair(build_group(pair.a.name, of_pair_a, of_a),
                                                     build_group(pair.b.name, of_pair_b, of_b)),
                       .shapes_a = of_a,
                       .shapes_b = of_b});
    add_meshes(pair, of_pair_a, of_pair_b);
    add_shape_pairs(pair, of_pair_a, of_pair_b);
    const geometry::ShapeGroup a = build_group(pair.a.name, of_pair_a, pair.a.shapes, Meshes::kAsSpheres);
    const geometry::ShapeGroup b = build_group(pair.b.name, of_pair_b, pair.b.shapes, Meshes::kAsSpheres);
    const bool of_b = std::isfinite(b.bound) && !(a.bound < b.bound);
    reaches_.push_back({.of_b = of_b, .centre = of_b ? b.centre : a.centre, .bound = of_b ? b.bound : a.bound});
    if (parts.empty() && mesh_parts_.back().empty())
      throw std::invalid_argument("clearance: " + pair.a.name + " – " + pair.b.name + " has no shape");
  }
}

void ClearanceMonitor::add_meshes(const ClearancePair& pair, const std::vector<BodyShape>& a,
                                  const std::vector<BodyShape>& b) {
  std::vector<MeshPart>& parts = mesh_parts_.emplace_back();
  for (const int i : pair.a.shapes)
    for (const int k : pair.b.shapes) {
      if (pair.is_excepted(i, k) || !(has_mesh(a, i) || has_mesh(b, k))) continue;
      const BodyShape &of_a = a.at(static_cast<std::size_t>(i)), &of_b = b.at(static_cast<std::size_t>(k));
      MeshPart part;
      part.mesh_is_a = of_a.mesh != nullptr;
      part.shape_a = i;
      part.shape_b = k;
      part.mesh = part.mesh_is_a ? of_a.mesh : of_b.mesh;
      const BodyShape& other = part.mesh_is_a ? of_b : of_a;
      part.other_mesh = other.mesh;
      if (!other.mesh) part.other = geometry::build_group(pair.b.name, {&other.shape, 1});
      parts.push_back(std::move(part));
    }
  if (!parts.empty()) clearances_.back().method = DistanceMethod::kMesh;
}

void ClearanceMonitor::add_shape_pairs(const ClearancePair& pair, const std::vector<BodyShape>& a,
                                       const std::vector<BodyShape>& b) {
  const std::size_t number = sides_.size();
  Sides& sides = sides_.emplace_back();
  std::vector<ShapePair>& pairs = shape_pairs_.emplace_back();
  int mesh = 0;
  for (std::size_t i = 0; i < pair.a.shapes.size(); ++i)
    for (std::size_t k = 0; k < pair.b.shapes.size(); ++k) {
      const int of_a = pair.a.shapes[i], of_b = pair.b.shapes[k];
      if (pair.is_excepted(of_a, of_b)) continue;
      const bool meshes = has_mesh(a, of_a) || has_mesh(b, of_b);
      pairs.push_back({.a = i, .b = k, .pair = number, .mesh = meshes ? mesh++ : kNone});
      pairs.back().convex = !meshes && is_convex(a, of_a) && is_convex(b, of_b);
    }
  for (const int i : pair.a.shapes) sides.a.push_back(build_group(pair.a.name, a, {i}, Meshes::kAsSpheres));
  for (const int k : pair.b.shapes) sides.b.push_back(build_group(pair.b.name, b, {k}, Meshes::kAsSpheres));
  for (ShapePair& shapes : pairs) shapes.size = std::min(sides.a[shapes.a].bound, sides.b[shapes.b].bound);
}

namespace {

// Places as seen from the origin of `a`: a large distance from the origin of W loses no digits.
struct NearPlaces {
  geometry::Placement a, b;
};
NearPlaces bring_near(const geometry::Placement& a, const geometry::Placement& b) {
  return {{{0, 0, 0}, a.R_WB}, {b.p_WB - a.p_WB, b.R_WB}};
}

}  // namespace

geometry::Distance ClearanceMonitor::calc_pair(const ShapePair& shapes, const geometry::Placement& a,
                                               const geometry::Placement& b) const {
  const NearPlaces near = bring_near(a, b);
  if (shapes.mesh != kNone)
    return calc_mesh(mesh_parts_[shapes.pair][static_cast<std::size_t>(shapes.mesh)], near.a, near.b,
                     std::numeric_limits<double>::infinity());
  const Sides& sides = sides_[shapes.pair];
  return geometry::calc_distance(sides.a[shapes.a], near.a, sides.b[shapes.b], near.b).least;
}

geometry::Distance ClearanceMonitor::calc_mesh(const MeshPart& part, const geometry::Placement& a,
                                               const geometry::Placement& b, double limit) {
  const geometry::Placement &own = part.mesh_is_a ? a : b, &other = part.mesh_is_a ? b : a;
  const MeshTree& tree = part.mesh->get_tree();
  geometry::Distance d = part.other_mesh ? tree.calc_distance(own, part.other_mesh->get_tree(), other, limit)
                                         : tree.calc_distance(own, part.other, other, limit);
  if (!part.mesh_is_a) {
    std::swap(d.on_a, d.on_b);
    d.normal = -d.normal;
  }
  return d;
}

PairDistance ClearanceMonitor::calc(std::size_t pair, const geometry::Placement& a,
                                    const geometry::Placement& b) const {
  PairDistance out;
  const auto [near_a, near_b] = bring_near(a, b);
  for (const Part& part : parts_[pair]) {
    const geometry::ShapeGroup &of_a = part.groups.get_a(), &of_b = part.groups.get_b();
    if (geometry::calc_lower_bound(of_a, near_a, of_b, near_b) > out.least.distance) continue;
    const geometry::GroupDistance found = part.groups.calc_distance(near_a, near_b);
    if (found.least.distance < out.least.distance)
      out = {found.least, part.shapes_a[static_cast<std::size_t>(found.shape_a)],
             part.shapes_b[static_cast<std::size_t>(found.shape_b)]};
  }
  for (const MeshPart& part : mesh_parts_[pair]) {
    const geometry::Distance found = calc_mesh(part, near_a, near_b, out.least.distance);
    if (found.distance < out.least.distance) out = {found, part.shape_a, part.shape_b};
  }
  out.least.on_a += a.p_WB;
  out.least.on_b += a.p_WB;
  return out;
}

double ClearanceMonitor::get_size(std::size_t pair) const {
  double size = 0;
  for (const Part& part : parts_[pair])
    for (const geometry::ShapeGroup* group : {&part.groups.get_a(), &part.groups.get_b()})
      if (std::isfinite(group->bound)) size = std::max(size, group->bound + norm(group->centre));
  for (const MeshPart& part : mesh_parts_[pair]) {
    for (const auto& mesh : {part.mesh, part.other_mesh})
      if (mesh) size = std::max(size, mesh->get_bound() + norm(mesh->get_centre()));
    if (!part.other_mesh && std::isfinite(part.other.bound))
      size = std::max(size, part.other.bound + norm(part.other.centre));
  }
  return size;
}

double ClearanceMonitor::get_resolution(std::size_t pair) const {
  constexpr double kRounding = 1e-13;  // relative to the size
  return kRounding * get_size(pair);
}

void ClearanceMonitor::update(double time, const std::vector<Pose>& poses) {
  const auto place = [&](int body) {
    return to_placement(body == kGround ? Pose{} : poses.at(static_cast<std::size_t>(body)));
  };
  for (std::size_t i = 0; i < clearances_.size(); ++i) {
    Clearance& clearance = clearances_[i];
    const PairDistance found = calc(i, place(clearance.a), place(clearance.b));
    clearance.now = found.least.distance;
    if (clearance.now <= 0 && !clearance.touch) clearance.touch = time;
    if (clearance.now < clearance.smallest) {
      clearance.smallest = clearance.now;
      clearance.time = time;
    }
  }
}

}  // namespace unlatch::hil
