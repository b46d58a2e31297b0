// Vectors and shapes as JSON, for results, pages and exports: kinds and members as scenarios call them, in metres and
// body axes.
#pragma once

#include <nlohmann/json.hpp>

#include "hil/scenario/shapes/shapes.h"
#include "unlatch/geometry.h"

namespace unlatch::tools {

inline nlohmann::ordered_json to_json(const Vec3& v) { return nlohmann::ordered_json::array({v.x, v.y, v.z}); }

// {"kind": "cylinder", "from": […], …}. Walls of every kind are "hollow": `profile` of [z, r] along from–to, and
// `half`, the direction to the middle of the half, or null.
inline nlohmann::ordered_json build_shape_json(const geometry::Shape& shape) {
  using Json = nlohmann::ordered_json;
  using geometry::ShapeKind;
  const auto axial = [&](const char* kind) {
    return Json{{"kind", kind}, {"from", to_json(shape.from)}, {"to", to_json(shape.to)}, {"radius", shape.radius}};
  };
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return {{"kind", "sphere"}, {"centre", to_json(shape.from)}, {"radius", shape.radius}};
    case ShapeKind::kCapsule:
      return axial("capsule");
    case ShapeKind::kCylinder:
      return axial("cylinder");
    case ShapeKind::kCone:
      return axial("cone");
    case ShapeKind::kFrustum: {
      Json json = axial("frustum");
      json["end_radius"] = shape.end_radius;
      return json;
    }
    case ShapeKind::kBox:
      return {{"kind", "box"},
              {"centre", to_json(shape.from)},
              {"size", to_json(shape.size)},
              {"attitude", Json::array({shape.q_BS.w, shape.q_BS.x, shape.q_BS.y, shape.q_BS.z})}};
    case ShapeKind::kHull: {
      Json points = Json::array();
      for (const Vec3& point : shape.points) points.push_back(to_json(point));
      return {{"kind", "hull"}, {"points", points}};
    }
    case ShapeKind::kHalfSpace:
      return {{"kind", "half_space"}, {"point", to_json(shape.from)}, {"normal", to_json(shape.normal)}};
    case ShapeKind::kHollow: {
      Json profile = Json::array();
      for (const geometry::ProfilePoint& p : shape.profile) profile.push_back(Json::array({p.z, p.r}));
      return {{"kind", "hollow"},
              {"from", to_json(shape.from)},
              {"to", to_json(shape.to)},
              {"profile", profile},
              {"half", shape.half ? to_json(shape.side) : Json(nullptr)}};
    }
  }
  return {};
}

// {"kind": "mesh", "file": "part.stl", "vertices": [[x, y, z], …], "triangles": [[i, k, l], …]}: numbers of vertices
// from 0.
inline nlohmann::ordered_json build_shape_json(const hil::TriangleMesh& mesh) {
  using Json = nlohmann::ordered_json;
  Json vertices = Json::array();
  for (const Vec3& p : mesh.get_vertices()) vertices.push_back({p.x, p.y, p.z});
  return {{"kind", "mesh"},
          {"file", mesh.get_place().file},
          {"vertices", std::move(vertices)},
          {"triangles", mesh.get_triangles()}};
}

inline nlohmann::ordered_json build_shape_json(const hil::BodyShape& shape) {
  return shape.mesh ? build_shape_json(*shape.mesh) : build_shape_json(shape.shape);
}

}  // namespace unlatch::tools
