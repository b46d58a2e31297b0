// Shapes of bodies, for distances, contacts and pictures, and named sets of them. They have no mass. Lengths are in
// metres, in the axes of the body.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hil/scenario/shapes/triangle_mesh.h"
#include "unlatch/geometry.h"

namespace unlatch::hil {

// One of the shapes whose union is a body.
struct BodyShape {
  std::string name;       // unique in its body; empty: none
  std::string group;      // group of shapes of the body; empty: none
  geometry::Shape shape;  // valid; body axes, or those of the marker; unused if there is a `mesh`
  // Triangle mesh in place of a shape: for distances in reports and for pictures. Null: a shape of the kernel.
  std::shared_ptr<const TriangleMesh> mesh{};
};

// Shapes of one body: all, one by its name, or a group.
struct ShapeSet {
  int body = 0;             // or kGround
  std::string name;         // name in scenarios: "core", "core.skirt"
  std::vector<int> shapes;  // indices in Scenario::shapes[body], ascending
};

// Two watched sets: their distance is the least of their pairs of shapes.
struct ClearancePair {
  ShapeSet a, b;
  std::vector<std::pair<int, int>> except;  // indices in a.shapes and b.shapes: mated faces, which are excepted

  [[nodiscard]] bool is_excepted(int shape_a, int shape_b) const {
    return std::find(except.begin(), except.end(), std::pair(shape_a, shape_b)) != except.end();
  }
};

}  // namespace unlatch::hil
