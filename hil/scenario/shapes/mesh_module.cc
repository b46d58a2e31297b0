// The module unlatch-meshes: bounding volumes of triangle meshes, by FCL.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hil/scenario/shapes/mesh_tree.h"

namespace unlatch::hil {
namespace {

using geometry::Distance;
using geometry::Placement;
using geometry::ShapeGroup;
using Model = fcl::BVHModel<fcl::OBBRSSd>;

// Bytes. FCL's library reads transforms as SSE2 and NEON want them, as Eigen aligns them by default. Here Eigen does
// not (EIGEN_DONT_VECTORIZE), and a transform on the stack may lie where FCL's reads fault.
constexpr std::size_t kFclAlignment = 16;

constexpr double kRounding = 1e-12;  // relative to the sizes: margin of the boxes for rounding

Vec3 to_vec3(const fcl::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
fcl::Vector3d to_fcl(const Vec3& v) { return {v.x, v.y, v.z}; }

fcl::Transform3d to_transform(const Placement& at) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() << to_fcl(at.R_WB.x), to_fcl(at.R_WB.y), to_fcl(at.R_WB.z);
  out.translation() = to_fcl(at.p_WB);
  return out;
}

class FclTree final : public MeshTree {
 public:
  explicit FclTree(const TriangleMesh& mesh) : size_(norm(mesh.get_centre()) + mesh.get_bound()) {
    model_.beginModel(static_cast<int>(mesh.get_triangles().size()), static_cast<int>(mesh.get_vertices().size()));
    std::vector<fcl::Vector3d> points;
    for (const Vec3& p : mesh.get_vertices()) points.push_back(to_fcl(p));
    std::vector<fcl::Triangle> triangles;
    for (const auto& t : mesh.get_triangles()) triangles.emplace_back(t[0], t[1], t[2]);
    model_.addSubModel(points, triangles);
    model_.endModel();
    for (int i = 0; i < model_.getNumBVs(); ++i) boxes_.push_back(build_box(model_.getBV(i).bv.obb));
  }

  Distance calc_distance(const Placement& at, const ShapeGroup& other, const Placement& at_other,
                         double limit) const override {
    Search search{*this, at, other, at_other, {}};
    search.best.distance = limit;
    search.descend(0);
    if (!(search.best.distance < limit)) return {};
    return clamp(search.best);
  }

  Distance calc_distance(const Placement& at, const MeshTree& other, const Placement& at_other,
                         double limit) const override {
    const auto& that = static_cast<const FclTree&>(other);
    fcl::DistanceRequestd request(true);
    fcl::DistanceResultd result;
    alignas(kFclAlignment) const fcl::Transform3d own = to_transform(at);
    alignas(kFclAlignment) const fcl::Transform3d others = to_transform(at_other);
    fcl::distance(&model_, own, &that.model_, others, request, result);
    if (!(result.min_distance < limit)) return {};
    Distance out;
    out.distance = result.min_distance;
    out.on_a = to_vec3(result.nearest_points[0]);
    out.on_b = to_vec3(result.nearest_points[1]);
    if (out.distance > 0) out.normal = (1 / out.distance) * (out.on_b - out.on_a);
    return clamp(out);
  }

 private:
  struct Search {
    const FclTree& tree;
    const Placement& at;
    const ShapeGroup& other;
    const Placement& at_other;
    Distance best;

    // Lower bound of the distance from the shapes to the triangles below a node, m.
    double calc_bound(int node) const {
      const ShapeGroup& box = tree.boxes_[static_cast<std::size_t>(node)];
      const Vec3 between = (at.p_WB + at.R_WB * box.centre) - (at_other.p_WB + at_other.R_WB * other.centre);
      const double margin = kRounding * ((norm(between) + tree.size_) + box.bound);
      const double apart = (norm(between) - (box.bound + other.bound)) - margin;
      if (!std::isnan(apart) && apart > best.distance) return apart;
      return geometry::calc_distance(box, at, other, at_other).least.distance - margin;
    }

    void look_at(int triangle) {
      const fcl::Triangle& corners = tree.model_.tri_indices[triangle];
      geometry::Shape flat{.kind = geometry::ShapeKind::kHull};
      for (int k = 0; k < 3; ++k) flat.points.push_back(to_vec3(tree.model_.vertices[corners[k]]));
      const Distance d = geometry::calc_distance(build_group(flat), at, other, at_other).least;
      if (d.distance < best.distance) best = d;
    }

    // Visits the nearer of two nodes first.
    void descend(int node) {
      if (best.distance <= 0) return;
      const auto& own = tree.model_.getBV(node);
      if (own.isLeaf()) return look_at(own.primitiveId());
      int near = own.leftChild(), far = own.rightChild();
      double to_near = calc_bound(near), to_far = calc_bound(far);
      if (to_far < to_near) {
        std::swap(near, far);
        std::swap(to_near, to_far);
      }
      if (to_near < best.distance) descend(near);
      if (to_far < best.distance) descend(far);
    }
  };

  static ShapeGroup build_group(const geometry::Shape& shape) { return geometry::build_group("", {&shape, 1}); }
  static ShapeGroup build_box(const fcl::OBBd& obb) {
    const Eigen::Quaterniond q(obb.axis);
    return build_group({.kind = geometry::ShapeKind::kBox,
                        .from = to_vec3(obb.To),
                        .size = 2.0 * to_vec3(obb.extent),
                        .q_BS = {q.w(), q.x(), q.y(), q.z()}});
  }

  // Clamps negative distances to 0: triangles have no inside, and their crossing has no depth.
  static Distance clamp(Distance d) {
    if (d.distance > 0) return d;
    d.distance = 0;
    d.on_b = d.on_a;
    return d;
  }

  double size_;  // m, distance of its farthest point from the body's origin
  Model model_;
  std::vector<ShapeGroup> boxes_;  // by FCL's number of the node
};

}  // namespace
}  // namespace unlatch::hil

extern "C" unlatch::hil::MeshTree* unlatch_build_mesh_tree(const unlatch::hil::TriangleMesh& mesh) {
  return new unlatch::hil::FclTree(mesh);
}
