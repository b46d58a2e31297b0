// Distances of triangle meshes, by bounding volumes of FCL (the Flexible Collision Library: Pan, Chitta, Manocha 2012),
// in the module unlatch-meshes.
//
// Two meshes: FCL's distance of oriented bounding boxes and rectangle swept spheres (Gottschalk, Lin, Manocha 1996;
// Larsen, Gottschalk, Lin, Manocha 2000). A mesh and shapes of the kernel: the same tree of boxes, traversed here;
// boxes and triangles have the kernel's distances (unlatch/geometry.h), so the only error is that of the facets.
#pragma once

#include "hil/scenario/shapes/triangle_mesh.h"
#include "unlatch/geometry.h"

namespace unlatch::hil {

class MeshTree {
 public:
  MeshTree() = default;
  virtual ~MeshTree() = default;
  MeshTree(const MeshTree&) = delete;
  MeshTree& operator=(const MeshTree&) = delete;

  // Least distance, m, from this mesh to shapes or to another mesh, with witness points; never negative: 0 where
  // triangles cross or touch the other. A distance not below `limit` may be returned as infinite. Allocates.
  [[nodiscard]] virtual geometry::Distance calc_distance(const geometry::Placement& at,
                                                         const geometry::ShapeGroup& other,
                                                         const geometry::Placement& at_other, double limit) const = 0;
  [[nodiscard]] virtual geometry::Distance calc_distance(const geometry::Placement& at, const MeshTree& other,
                                                         const geometry::Placement& at_other, double limit) const = 0;
};

}  // namespace unlatch::hil
