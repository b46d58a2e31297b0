// Finite-element meshes as CalculiX knows them, and a structured one of a half shell of revolution: a cylinder, and a
// cone on top of it.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace unlatch::tools {

// Elements by the numbers that .frd files give them; nodes by index.
enum class ElementType { kTriangle3 = 7, kTriangle6 = 8, kQuad4 = 9, kQuad8 = 10 };
struct Element {
  ElementType type = ElementType::kQuad8;
  std::vector<int> nodes;  // corners counter-clockwise, then mid-sides 1-2, 2-3, 3-4, 4-1
};
struct Mesh {
  std::vector<Eigen::Vector3d> nodes;
  std::vector<Element> elements;
};

// Axis z from the base; half: y ≥ 0, free edges at (±radius, 0, z). Lengths in m.
struct HalfShell {
  double radius = 2, cylinder = 8, cone = 6;  // height of the cone; 0: none
  double nose = 0.01;                         // radius where the cone ends, > 0: an apex would be no quadrilateral
  double thickness = 0.01;
  double young = 2e12, density = 4000, poisson = 0.3;   // N/m², kg/m³
  int around = 24, cylinder_rows = 18, cone_rows = 16;  // elements
};

// Eight-node quadrilaterals. Rows are denser at the ends of each part, where free edges and the kink bend the shell
// over lengths of √(radius · thickness).
Mesh build_half_shell(const HalfShell& shell);

}  // namespace unlatch::tools
