#include "hil/analysis/clearance.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace unlatch::hil {
namespace {

geometry::ShapeGroup build_group(const std::string& name, const std::vector<BodyShape>& shapes,
                                 const std::vector<int>& chosen) {
  std::vector<geometry::Shape> list;
  for (const int i : chosen) {
    if (i < 0 || static_cast<std::size_t>(i) >= shapes.size())
      throw std::invalid_argument("clearance: " + name + " has no shape " + std::to_string(i));
    list.push_back(shapes[static_cast<std::size_t>(i)].shape);
  }
  return geometry::build_group(name, list);
}

// Shapes of `a` that leave out the same shapes of `b`, by what they have left of it.
std::map<std::vector<int>, std::vector<int>> split(const ClearancePair& pair) {
  std::map<std::vector<int>, std::vector<int>> parts;
  for (const int i : pair.a.shapes) {
    std::vector<int> left;
    for (const int k : pair.b.shapes)
      if (std::find(pair.except.begin(), pair.except.end(), std::pair(i, k)) == pair.except.end()) left.push_back(k);
    if (!left.empty()) parts[left].push_back(i);
  }
  return parts;
}

}  // namespace

geometry::Placement to_placement(const BodyState& body) { return {body.p, rotation_matrix(body.q)}; }

geometry::Placement to_placement(const Pose& pose) {
  const Eigen::Vector3d& p = pose.p_WB;
  const Eigen::Quaterniond& q = pose.q_WB;
  return {{p.x(), p.y(), p.z()}, rotation_matrix(Quat{q.w(), q.x(), q.y(), q.z()})};
}

ClearanceMonitor::ClearanceMonitor(const std::vector<ClearancePair>& pairs,
                                   const std::vector<std::vector<BodyShape>>& shapes) {
  const auto get_shapes = [&](const ShapeSet& set) -> const std::vector<BodyShape>& {
    if (set.body < 0 || static_cast<std::size_t>(set.body) >= shapes.size() || set.shapes.empty())
      throw std::invalid_argument("clearance: " + set.name + " has no shape");
    return shapes[static_cast<std::size_t>(set.body)];
  };
  for (const ClearancePair& pair : pairs) {
    clearances_.push_back({.a = pair.a.body, .b = pair.b.body, .name_a = pair.a.name, .name_b = pair.b.name});
    std::vector<Part>& parts = parts_.emplace_back();
    for (const auto& [of_b, of_a] : split(pair))
      parts.push_back({.a = build_group(pair.a.name, get_shapes(pair.a), of_a),
                       .b = build_group(pair.b.name, get_shapes(pair.b), of_b),
                       .shapes_a = of_a,
                       .shapes_b = of_b});
    const geometry::ShapeGroup a = build_group(pair.a.name, get_shapes(pair.a), pair.a.shapes);
    const geometry::ShapeGroup b = build_group(pair.b.name, get_shapes(pair.b), pair.b.shapes);
    const bool of_b = std::isfinite(b.bound) && !(a.bound < b.bound);
    reaches_.push_back({.of_b = of_b, .centre = of_b ? b.centre : a.centre, .bound = of_b ? b.bound : a.bound});
    if (parts.empty()) throw std::invalid_argument("clearance: " + pair.a.name + " – " + pair.b.name + " has no shape");
  }
}

PairDistance ClearanceMonitor::calc(std::size_t pair, const geometry::Placement& a,
                                    const geometry::Placement& b) const {
  PairDistance out;
  const geometry::Placement near_a{{0, 0, 0}, a.R_WB}, near_b{b.p_WB - a.p_WB, b.R_WB};
  for (const Part& part : parts_[pair]) {
    if (geometry::calc_lower_bound(part.a, near_a, part.b, near_b) > out.least.distance) continue;
    const geometry::GroupDistance found = geometry::calc_distance(part.a, near_a, part.b, near_b);
    if (found.least.distance < out.least.distance)
      out = {found.least, part.shapes_a[static_cast<std::size_t>(found.shape_a)],
             part.shapes_b[static_cast<std::size_t>(found.shape_b)]};
  }
  out.least.on_a += a.p_WB;
  out.least.on_b += a.p_WB;
  return out;
}

double ClearanceMonitor::get_size(std::size_t pair) const {
  double size = 0;
  for (const Part& part : parts_[pair])
    for (const geometry::ShapeGroup* group : {&part.a, &part.b})
      if (std::isfinite(group->bound)) size = std::max(size, group->bound + norm(group->centre));
  return size;
}

void ClearanceMonitor::update(double time, const std::vector<Pose>& poses) {
  for (std::size_t i = 0; i < clearances_.size(); ++i) {
    Clearance& clearance = clearances_[i];
    const PairDistance found = calc(i, to_placement(poses.at(static_cast<std::size_t>(clearance.a))),
                                    to_placement(poses.at(static_cast<std::size_t>(clearance.b))));
    clearance.now = found.least.distance;
    if (clearance.now <= 0 && !clearance.touch) clearance.touch = time;
    if (clearance.now < clearance.smallest) {
      clearance.smallest = clearance.now;
      clearance.time = time;
    }
  }
}

}  // namespace unlatch::hil
