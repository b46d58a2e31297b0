// Signed distance between bodies, their groups and shapes: positive apart; negative, the depth of an overlap. The
// kernel's geometry (unlatch/geometry.h) states definitions and errors; distances of triangle meshes come from
// hil/scenario/shapes/mesh_tree.h, without depths. For reports, off the cyclic thread.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/scenario/base/pose.h"
#include "hil/scenario/shapes/shapes.h"
#include "unlatch/geometry/group_pair.h"
#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch::hil {

geometry::Placement to_placement(const BodyState& body);
geometry::Placement to_placement(const Pose& pose);

// Nearest pair of shapes of a watched pair, with its witness points.
struct PairDistance {
  geometry::Distance least;              // from a to b
  int shape_a = kNone, shape_b = kNone;  // indices in the bodies' shapes
};

// Method of a pair's distance. kExact: the kernel's shapes. kMesh: some of its shapes are triangle meshes, whose
// distance is that of their facets, and never negative.
enum class DistanceMethod { kExact, kMesh };
const char* get_method_name(DistanceMethod method);  // "exact", "mesh (triangles)"

struct Clearance {
  int a = 0, b = 0;            // bodies, or kGround
  std::string name_a, name_b;  // "core", "core.skirt"
  DistanceMethod method = DistanceMethod::kExact;
  double now = std::numeric_limits<double>::infinity();       // m, at the last update
  double smallest = std::numeric_limits<double>::infinity();  // m, of all updates
  double time = 0;                                            // s, time of the smallest value
  std::optional<double> touch{};                              // s, first time at which it was not greater than 0
  // Times at which it equals the smallest to 1e-6 m: one instant, or an interval during which the distance does not
  // change.
  struct Tie {
    double from = 0, to = 0;  // s
    int count = 0;            // knots of the motion
  };
  Tie tie{};
  // Values since the last joint between the two became free; absent for bodies that were never joined, or still are.
  struct AfterRelease {
    double from, smallest, time;  // s, m, s
  };
  std::optional<AfterRelease> after_release{};
  double rate = 0;  // m/s, at the last update; below 0 the bodies approach
};

// Distances of watched pairs, for one thread. Excepted shapes are handled by dividing a pair into parts without them.
class ClearanceMonitor {
 public:
  // `shapes`: shapes of each body; `ground`: those fixed in W. Throws std::invalid_argument if a pair names an unknown
  // shape, or has none.
  ClearanceMonitor(const std::vector<ClearancePair>& pairs, const std::vector<std::vector<BodyShape>>& shapes,
                   const std::vector<BodyShape>& ground = {});

  void update(double time, const std::vector<Pose>& poses);  // poses of all bodies, at `time`
  // Distance of a pair by its number, with its bodies at these placements. Computed from the place of one body relative
  // to the other, so that a large distance from the origin of W loses no digits.
  [[nodiscard]] PairDistance calc(std::size_t pair, const geometry::Placement& a, const geometry::Placement& b) const;
  // Size of a pair, m: distances carry rounding of some 1e-16 of it.
  [[nodiscard]] double get_size(std::size_t pair) const;
  // Smallest depth of a dip over time that is not rounding, m.
  [[nodiscard]] double get_resolution(std::size_t pair) const;
  // Bounding sphere of one side of the pair: a motion relative to the other side changes the distance by no more than
  // the path of its centre plus the rotation angle times its radius.
  struct Reach {
    bool of_b = true;
    Vec3 centre{0, 0, 0};  // m, in the body
    double bound = 0;      // m; infinite if both sides are unbounded
  };
  [[nodiscard]] const Reach& get_reach(std::size_t pair) const { return reaches_[pair]; }
  const std::vector<Clearance>& get() const { return clearances_; }

  // One shape of each side of a watched pair.
  struct ShapePair {
    std::size_t a = 0, b = 0;  // among the shapes of both sides
    std::size_t pair = 0;      // watched pair
    int mesh = kNone;          // part of its meshes; kNone: shapes of the kernel
    double size = 0;           // m, radius of the smaller one's bounding sphere; infinite if both are unbounded
    bool convex = true;        // both are
  };
  // All of a watched pair.
  [[nodiscard]] const std::vector<ShapePair>& get_shape_pairs(std::size_t pair) const { return shape_pairs_[pair]; }
  // Its shapes one by one, of either side, to which ShapePair refers; a mesh as its bounding sphere.
  [[nodiscard]] const std::vector<geometry::ShapeGroup>& get_shapes_a(std::size_t pair) const { return sides_[pair].a; }
  [[nodiscard]] const std::vector<geometry::ShapeGroup>& get_shapes_b(std::size_t pair) const { return sides_[pair].b; }
  // Its distance with the bodies at these placements; the normal is in W, the witnesses as seen from the origin of `a`.
  [[nodiscard]] geometry::Distance calc_pair(const ShapePair& shapes, const geometry::Placement& a,
                                             const geometry::Placement& b) const;

 private:
  // All shapes of one group against all shapes of the other; shapes of the kernel.
  struct Part {
    mutable geometry::GroupPair groups;   // keeps bounds, no result
    std::vector<int> shapes_a, shapes_b;  // indices in the bodies
  };
  // A shape and a mesh, or two meshes.
  struct MeshPart {
    std::shared_ptr<const TriangleMesh> mesh{}, other_mesh{};  // the latter is null for a shape: `other`
    geometry::ShapeGroup other{};
    bool mesh_is_a = true;
    int shape_a = 0, shape_b = 0;  // indices in the bodies
  };
  static geometry::Distance calc_mesh(const MeshPart& part, const geometry::Placement& a, const geometry::Placement& b,
                                      double limit);
  void add_meshes(const ClearancePair& pair, const std::vector<BodyShape>& a, const std::vector<BodyShape>& b);
  void add_shape_pairs(const ClearancePair& pair, const std::vector<BodyShape>& a, const std::vector<BodyShape>& b);

  std::vector<Clearance> clearances_;
  std::vector<std::vector<Part>> parts_;           // parts of each pair
  std::vector<std::vector<MeshPart>> mesh_parts_;  // parts of each pair
  std::vector<Reach> reaches_;
  // The shapes of each pair's sides one by one, a mesh as its bounding sphere.
  struct Sides {
    std::vector<geometry::ShapeGroup> a, b;
  };
  std::vector<Sides> sides_;
  std::vector<std::vector<ShapePair>> shape_pairs_;
};

}  // namespace unlatch::hil
