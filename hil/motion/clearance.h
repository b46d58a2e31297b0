// Signed distance between bodies, their groups and shapes: positive apart, negative the depth of an overlap. From the
// kernel's geometry (unlatch/geometry.h), which states definitions and errors; of triangle meshes from
// hil/meshes/mesh_tree.h, without depths. For reports, off the cyclic thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/scenario/shapes.h"
#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch::hil {

struct Pose {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
};

geometry::Placement to_placement(const BodyState& body);
geometry::Placement to_placement(const Pose& pose);

// The nearest pair of shapes of a watched pair, with its witnesses.
struct PairDistance {
  geometry::Distance least;              // from a to b
  int shape_a = kNone, shape_b = kNone;  // indices in the bodies' shapes
};

// Origin of a pair's distance. kExact: the kernel's shapes. kMesh: some of its shapes are triangle meshes, whose
// distance is that of their facets, and never negative.
enum class DistanceMethod { kExact, kMesh };
const char* get_method_name(DistanceMethod method);  // "exact", "mesh (triangles)"

struct Clearance {
  int a = 0, b = 0;            // bodies
  std::string name_a, name_b;  // "core", "core.skirt"
  DistanceMethod method = DistanceMethod::kExact;
  double now = std::numeric_limits<double>::infinity();       // m, at the last update
  double smallest = std::numeric_limits<double>::infinity();  // m, of all updates
  double time = 0;                                            // s, when it was smallest
  std::optional<double> touch{};                              // s, when it was first not greater than 0
  // Times at which it is no greater than the smallest, to 1e-6 m: one instant, or the distance does not change for
  // long.
  struct Tie {
    double from = 0, to = 0;  // s
    int count = 0;            // knots of the motion
  };
  Tie tie{};
  // From the time at which nothing joins the two any longer; absent for bodies that were never joined, or still are.
  struct AfterRelease {
    double from, smallest, time;  // s, m, s
  };
  std::optional<AfterRelease> after_release{};
  double rate = 0;  // m/s, at the last update; below 0 they close
};

// The distances of watched pairs. What is left out of a pair is left out by computing parts of it that lack it.
class ClearanceMonitor {
 public:
  // `shapes`: of each body. Throws std::invalid_argument if a pair names a shape that is not there, or has none.
  ClearanceMonitor(const std::vector<ClearancePair>& pairs, const std::vector<std::vector<BodyShape>>& shapes);

  void update(double time, const std::vector<Pose>& poses);  // of all bodies, at `time`
  // Of a pair by its number, with its bodies at these places. Computed from the place of the one seen from the other,
  // so that a large distance from the origin of W costs no digits.
  [[nodiscard]] PairDistance calc(std::size_t pair, const geometry::Placement& a, const geometry::Placement& b) const;
  // m: distances carry rounding of some 1e-16 of it.
  [[nodiscard]] double get_size(std::size_t pair) const;
  // The bounding sphere of one side of the pair: a motion relative to the other side changes the distance by no more
  // than the way of its centre and the turn times its radius.
  struct Reach {
    bool of_b = true;
    Vec3 centre{0, 0, 0};  // m, in the body
    double bound = 0;      // m; infinite if both sides are unbounded
  };
  [[nodiscard]] const Reach& get_reach(std::size_t pair) const { return reaches_[pair]; }
  const std::vector<Clearance>& get() const { return clearances_; }

 private:
  // Every shape of one group against every one of the other; of the kernel.
  struct Part {
    geometry::ShapeGroup a, b;
    std::vector<int> shapes_a, shapes_b;  // their indices in the bodies
  };
  // A shape against a mesh, or a mesh against a mesh.
  struct MeshPart {
    std::shared_ptr<const TriangleMesh> mesh{}, other_mesh{};  // the latter null: `other`
    geometry::CompiledShape other{};
    bool mesh_is_a = true;
    int shape_a = 0, shape_b = 0;  // their indices in the bodies
  };
  static geometry::Distance calc_mesh(const MeshPart& part, const geometry::Placement& a, const geometry::Placement& b,
                                      double limit);
  void add_meshes(const ClearancePair& pair, const std::vector<BodyShape>& a, const std::vector<BodyShape>& b);

  std::vector<Clearance> clearances_;
  std::vector<std::vector<Part>> parts_;           // of each pair
  std::vector<std::vector<MeshPart>> mesh_parts_;  // of each pair
  std::vector<Reach> reaches_;
};

}  // namespace unlatch::hil
