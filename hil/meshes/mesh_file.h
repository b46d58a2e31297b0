// Files with triangles: STL (binary, ASCII) and OBJ; and the text by which a recording holds a mesh.
//
// Both formats are small, and files of others come from anywhere: they are read here, strictly and in bounded memory,
// rather than by a library of forty formats that mends what it finds. Coordinates are kept in single precision, as
// binary STL has them; corners at one place are one vertex; triangles without area are left out, and normals, colours
// and textures ignored.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "hil/meshes/triangle_mesh.h"

namespace unlatch::hil {

inline constexpr std::size_t kMaxMeshFile = 64u << 20;  // bytes

// what(): "line 7: …", or of the whole file.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The content of a file; its name ends in .stl or .obj, in whatever case. Polygons of OBJ are cut into fans from their
// first corner: they are to be flat and convex. Throws MeshError.
MeshData read_mesh(std::string_view bytes, const std::string& name);

// "unlatch-mesh 1", the counts, and the numbers in base64: single precision and 16 bits, little-endian.
std::string write_mesh_text(const MeshData& mesh);
bool is_mesh_text(std::string_view text);        // its first line is that
MeshData read_mesh_text(std::string_view text);  // throws MeshError

}  // namespace unlatch::hil
