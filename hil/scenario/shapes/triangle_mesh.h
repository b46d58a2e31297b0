// Triangles of a body's surface, from a file of another program, for distances in reports and for pictures.
//
// A mesh is a surface, not a solid: its distance is the distance to the nearest triangle, inside as well as outside,
// and 0 where it is crossed. A body inside a closed mesh has its distance from the wall.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "unlatch/math.h"

namespace unlatch::hil {

class MeshTree;

// Corners and triangles of a file, in its axes and unit.
struct MeshData {
  std::vector<std::array<float, 3>> vertices;           // finite, all different
  std::vector<std::array<std::uint16_t, 3>> triangles;  // indices of vertices; each triangle has an area
};

inline constexpr std::size_t kMaxMeshVertices = 65536, kMaxMeshTriangles = 131072;

// Place of a file's mesh in a body.
struct MeshPlace {
  std::string file;       // path from the scenario's folder
  double scale = 1;       // m, one unit of the file
  Vec3 origin{0, 0, 0};   // m, the file's origin in the body
  Quat q_BM{1, 0, 0, 0};  // attitude of the file's axes in the body
};

bool is_same(const MeshPlace& a, const MeshPlace& b);

class TriangleMesh {
 public:
  TriangleMesh(MeshPlace place, const MeshData& data);
  ~TriangleMesh();
  TriangleMesh(const TriangleMesh&) = delete;
  TriangleMesh& operator=(const TriangleMesh&) = delete;

  [[nodiscard]] const MeshPlace& get_place() const { return place_; }
  [[nodiscard]] const std::vector<Vec3>& get_vertices() const { return vertices_; }  // m, body axes
  [[nodiscard]] const std::vector<std::array<std::uint16_t, 3>>& get_triangles() const { return triangles_; }
  // Bounding sphere: its centre in the body and its radius, m.
  [[nodiscard]] const Vec3& get_centre() const { return centre_; }
  [[nodiscard]] double get_bound() const { return bound_; }

  // Bounding volumes, built at the first call; takes milliseconds for each ten thousand triangles. Thread-safe. Throws
  // ModuleError if the module of FCL is missing.
  [[nodiscard]] const MeshTree& get_tree() const;

 private:
  MeshPlace place_;
  std::vector<Vec3> vertices_;
  std::vector<std::array<std::uint16_t, 3>> triangles_;
  Vec3 centre_{0, 0, 0};
  double bound_ = 0;
  mutable std::once_flag built_;
  mutable std::unique_ptr<const MeshTree> tree_;
};

}  // namespace unlatch::hil
