#include "tools/modes/shell_mesh.h"

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace unlatch::tools {
namespace {

struct Ring {
  double z, radius;
};

// Rings of corner and mid-side nodes from one end of a part to the other, the last left out.
void add_rings(const Ring& from, const Ring& to, int rows, std::vector<Ring>& rings) {
  constexpr double kGrading = 0.7;  // 0: equal rows; 1: none at the ends
  const auto corner = [&](int row) {
    const double s = static_cast<double>(row) / rows;
    return s - kGrading * std::sin(2 * std::numbers::pi * s) / (2 * std::numbers::pi);
  };
  for (int half = 0; half < 2 * rows; ++half) {
    const double s = 0.5 * (corner(half / 2) + corner((half + 1) / 2));
    rings.push_back({from.z + s * (to.z - from.z), from.radius + s * (to.radius - from.radius)});
  }
}

}  // namespace

Mesh build_half_shell(const HalfShell& shell) {
  const Ring base{0, shell.radius}, junction{shell.cylinder, shell.radius};
  std::vector<Ring> rings;
  add_rings(base, junction, shell.cylinder_rows, rings);
  if (shell.cone > 0) {
    const Ring nose{shell.cylinder + shell.cone * (1 - shell.nose / shell.radius), shell.nose};
    add_rings(junction, nose, shell.cone_rows, rings);
    rings.push_back(nose);
  } else {
    rings.push_back(junction);
  }

  Mesh mesh;
  std::map<std::pair<int, int>, int> at;  // (half columns around, half rows up) to node
  const int columns = 2 * shell.around, rows = static_cast<int>(rings.size()) - 1;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      if (i % 2 == 1 && j % 2 == 1) continue;  // no node in an element's middle
      const double angle = std::numbers::pi * i / columns;
      const Ring& ring = rings[static_cast<std::size_t>(j)];
      at[{i, j}] = static_cast<int>(mesh.nodes.size());
      mesh.nodes.emplace_back(ring.radius * std::cos(angle), ring.radius * std::sin(angle), ring.z);
    }
  for (int j = 0; j < rows; j += 2)
    for (int i = 0; i < columns; i += 2) {
      Element element;
      for (const auto& [di, dj] : {std::pair{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}})
        element.nodes.push_back(at.at({i + di, j + dj}));
      mesh.elements.push_back(element);
    }
  return mesh;
}

}  // namespace unlatch::tools
