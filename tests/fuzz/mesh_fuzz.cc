// Files of triangles: STL, OBJ, and the text of recordings. The first byte selects the format.
#include "hil/scenario/shapes/mesh_file.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

namespace {

void check(const hil::MeshData& mesh) {
  fuzz::require(!mesh.triangles.empty(), "a mesh without triangles");
  for (const auto& vertex : mesh.vertices)
    for (const float x : vertex) fuzz::require(std::isfinite(x), "a coordinate that is not finite");
  for (const auto& triangle : mesh.triangles)
    for (const std::uint16_t i : triangle) fuzz::require(i < mesh.vertices.size(), "a corner that is not there");
  const std::string text = hil::write_mesh_text(mesh);
  const hil::MeshData again = hil::read_mesh_text(text);
  fuzz::require(again.vertices == mesh.vertices && again.triangles == mesh.triangles, "a text of another mesh");
  const hil::TriangleMesh placed({.file = "part.stl", .scale = 1e-3}, mesh);
  fuzz::require(std::isfinite(placed.get_bound()) && placed.get_bound() > 0, "a mesh without a size");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string bytes = fuzz::to_text(data + 1, size - 1);
  try {
    switch (data[0] % 3) {
      case 0:
        check(hil::read_mesh(bytes, "part.stl"));
        break;
      case 1:
        check(hil::read_mesh(bytes, "part.obj"));
        break;
      default:
        check(hil::read_mesh_text(bytes));
    }
  } catch (const hil::MeshError& error) {
    fuzz::require(error.what()[0] != 0, "a refusal without a mistake");
  }
  return 0;
}
