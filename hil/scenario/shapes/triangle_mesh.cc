#include "hil/scenario/shapes/triangle_mesh.h"

#include <algorithm>
#include <limits>

#include "hil/scenario/base/module.h"
#include "hil/scenario/shapes/mesh_tree.h"

namespace unlatch::hil {

using BuildMeshTree = MeshTree*(const TriangleMesh&);  // as in mesh_module.cc

bool is_same(const MeshPlace& a, const MeshPlace& b) {
  const auto same = [](const Vec3& u, const Vec3& v) { return u.x == v.x && u.y == v.y && u.z == v.z; };
  return a.file == b.file && a.scale == b.scale && same(a.origin, b.origin) && a.q_BM.w == b.q_BM.w &&
         same({a.q_BM.x, a.q_BM.y, a.q_BM.z}, {b.q_BM.x, b.q_BM.y, b.q_BM.z});
}

TriangleMesh::TriangleMesh(MeshPlace place, const MeshData& data)
    : place_(std::move(place)), triangles_(data.triangles) {
  const Mat3 R = rotation_matrix(place_.q_BM);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinite, kInfinite, kInfinite}, high = -low;
  for (const std::array<float, 3>& v : data.vertices) {
    const Vec3 p = place_.origin + R * (place_.scale * Vec3{static_cast<double>(v[0]), static_cast<double>(v[1]),
                                                            static_cast<double>(v[2])});
    vertices_.push_back(p);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  if (!vertices_.empty()) centre_ = 0.5 * (low + high);
  for (const Vec3& p : vertices_) bound_ = std::max(bound_, norm(p - centre_));
}

TriangleMesh::~TriangleMesh() = default;

const MeshTree& TriangleMesh::get_tree() const {
  std::call_once(built_, [this] {
    tree_.reset(find_function<BuildMeshTree>("unlatch-meshes", "unlatch_build_mesh_tree")(*this));
  });
  return *tree_;
}

}  // namespace unlatch::hil
