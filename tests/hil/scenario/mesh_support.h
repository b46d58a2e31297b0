// Meshes for tests: of solids with known distances, and as files.
#pragma once

#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "hil/scenario/shapes/mesh_file.h"

namespace unlatch::test {

struct Facet {
  Vec3 a, b, c;
};
using Facets = std::vector<Facet>;

inline void add_quad(Facets& to, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  to.push_back({a, b, c});
  to.push_back({a, c, d});
}

// Box about the origin, edge lengths 2 · half.
inline Facets build_box_facets(const Vec3& half) {
  const auto corner = [&](int x, int y, int z) { return Vec3{x * half.x, y * half.y, z * half.z}; };
  Facets facets;
  for (const int s : {-1, 1}) {
    add_quad(facets, corner(s, -1, -1), corner(s, 1, -1), corner(s, 1, 1), corner(s, -1, 1));
    add_quad(facets, corner(-1, s, -1), corner(1, s, -1), corner(1, s, 1), corner(-1, s, 1));
    add_quad(facets, corner(-1, -1, s), corner(1, -1, s), corner(1, 1, s), corner(-1, 1, s));
  }
  return facets;
}

// Surface of revolution about z: each (z, r) of the profile is a ring of corners; r = 0 a point. Closed by its ends.
inline Facets build_revolved_facets(const std::vector<std::array<double, 2>>& profile, int around) {
  const auto corner = [&](std::size_t ring, int k) {
    const double angle = 2 * 3.14159265358979323846 * (k % around) / around, r = profile[ring][1];
    return Vec3{r * std::cos(angle), r * std::sin(angle), profile[ring][0]};
  };
  Facets facets;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i)
    for (int k = 0; k < around; ++k)
      add_quad(facets, corner(i, k), corner(i, k + 1), corner(i + 1, k + 1), corner(i + 1, k));
  return facets;  // the reader drops triangles without area
}

inline Facets build_sphere_facets(double radius, int around) {
  std::vector<std::array<double, 2>> profile;
  for (int i = 0; i <= around / 2; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / around;
    profile.push_back({-radius * std::cos(angle), i == 0 || i == around / 2 ? 0.0 : radius * std::sin(angle)});
  }
  return build_revolved_facets(profile, around);
}

inline Facets build_cylinder_facets(double radius, double half_length, int around) {
  return build_revolved_facets({{-half_length, 0}, {-half_length, radius}, {half_length, radius}, {half_length, 0}},
                               around);
}

template <class T>
void append_bytes(std::string& to, const T& value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  to.append(bytes, sizeof(T));
}

inline std::string write_binary_stl(const Facets& facets) {
  std::string bytes(80, ' ');
  append_bytes(bytes, static_cast<std::uint32_t>(facets.size()));
  for (const Facet& f : facets) {
    for (const Vec3& p : {Vec3{0, 0, 0}, f.a, f.b, f.c})
      for (const double x : {p.x, p.y, p.z}) append_bytes(bytes, static_cast<float>(x));
    append_bytes(bytes, std::uint16_t{0});
  }
  return bytes;
}

inline std::string to_words(const Vec3& p) {
  char line[100];
  std::snprintf(line, sizeof line, "%.9g %.9g %.9g", p.x, p.y, p.z);
  return line;
}

inline std::string write_ascii_stl(const Facets& facets) {
  std::string text = "solid part of a test\n";
  for (const Facet& f : facets) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const Vec3& p : {f.a, f.b, f.c}) text += "      vertex " + to_words(p) + "\n";
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid part of a test\n";
}

inline std::string write_obj(const Facets& facets) {
  std::string text = "# of a test\no part\n";
  for (const Facet& f : facets) {
    for (const Vec3& p : {f.a, f.b, f.c}) text += "v " + to_words(p) + "\n";
    text += "f -3 -2 -1\n";
  }
  return text;
}

inline void write_file(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace unlatch::test
