// Files with triangles: STL (binary, ASCII) and OBJ; and the text that stores a mesh in a recording.
//
// Both formats are small, and files come from unknown sources: this reader is strict and uses bounded memory, instead
// of a library of forty formats that repairs faulty files. Coordinates are kept in single precision, as binary STL has
// them; corners at one place are one vertex; triangles without area are dropped, and normals, colours and textures
// ignored.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "hil/scenario/shapes/triangle_mesh.h"

namespace unlatch::hil {

inline constexpr std::size_t kMaxMeshFile = 64u << 20;  // bytes

// Error of a mesh file. what(): "line 7: …", or about the whole file.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Reads the content of a file whose name ends in .stl or .obj, in upper or lower case. Polygons of OBJ are cut into
// fans from their first corner: they must be flat and convex. Throws MeshError.
MeshData read_mesh(std::string_view bytes, const std::string& name);

// Text of a mesh: "unlatch-mesh 1", the counts, and the numbers in base64: single precision and 16 bits, little-endian.
std::string write_mesh_text(const MeshData& mesh);
bool is_mesh_text(std::string_view text);        // true if the first line is "unlatch-mesh 1"
MeshData read_mesh_text(std::string_view text);  // throws MeshError

}  // namespace unlatch::hil
