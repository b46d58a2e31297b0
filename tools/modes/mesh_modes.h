// From a finite-element program's shapes on a shell mesh to a modes file: mass points, attachment frames.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/flexible/modes_file.h"
#include "tools/modes/calculix.h"

namespace unlatch::tools {

struct MarkerRequest {
  std::string name;
  Eigen::Vector3d position;  // m; the nearest node is taken
};

// Masses are those of Gauss points (2 × 2 a quadrilateral, 3 a triangle): positive, and exact for the shell's mass.
// Lumped on nodes, corners of eight-node elements would get negative ones. Modes below `rigid_hz` are left out as rigid
// motions. At most `count` elastic ones, 0: all. Numbers are rounded to `digits` behind the first of the largest of
// their kind: finite-element shapes are no better, and the file is half as long.
hil::Modes build_modes(const MeshModes& found, double surface_density, double rigid_hz, int count, int digits,
                       const std::vector<MarkerRequest>& markers);

}  // namespace unlatch::tools
