// Shapes of bodies, for distances, contacts and pictures, and the sets of them that a name stands for. They have no
// mass. Lengths are in metres, in the axes of the body.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hil/meshes/triangle_mesh.h"
#include "unlatch/geometry.h"

namespace unlatch::hil {

// One of the shapes whose union is a body.
struct BodyShape {
  std::string name;       // unique in its body; empty: none
  std::string group;      // of shapes of the body; empty: none
  geometry::Shape shape;  // without mistakes; body axes, of a marker the marker's; does not count beside `mesh`
  // Triangles instead: for distances in reports and for pictures. Null: a shape of the kernel.
  std::shared_ptr<const TriangleMesh> mesh{};
};

// Shapes of one body: all, one by its name, or a group.
struct ShapeSet {
  int body = 0;
  std::string name;         // as scenarios write it: "core", "core.skirt"
  std::vector<int> shapes;  // indices in Scenario::shapes[body], rising
};

// Two sets whose distance is watched: the least of their pairs of shapes.
struct ClearancePair {
  ShapeSet a, b;
  std::vector<std::pair<int, int>> except;  // indices in a.shapes and b.shapes: mated faces, which are left out
};

}  // namespace unlatch::hil
