// Surfaces: their shapes have volume; contacts and distances are of two bodies and of shapes that have a distance.
#include <cmath>

#include "kernel/model/validate.h"
#include "unlatch/geometry.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch {
namespace {

void validate_shapes(const Model& model, ModelErrors& errors) {
  for (const Surface& set : model.surfaces) {
    const std::string where = quoted("surface", set.name);
    if (set.body != kGround && !is_index(set.body, model.bodies.size()))
      errors.push_back({where, "the body that carries them does not exist", "a body's index, or kGround", "body"});
    else if (set.body != kGround && model.bodies[static_cast<std::size_t>(set.body)].flexible)
      errors.push_back(
          {where,
           "the flexible body '" + model.bodies[static_cast<std::size_t>(set.body)].name + "' carries them itself",
           "name one of its markers", "body"});
    if (set.shapes.empty()) errors.push_back({where, "there are none", "at least one shape", "shapes"});
    for (std::size_t i = 0; i < set.shapes.size(); ++i)
      for (const geometry::ShapeError& e : geometry::check_shape(set.shapes[i]))
        errors.push_back({where + ", shape " + std::to_string(i + 1), e.what, e.mend, e.key});
  }
}

// The body that a set moves with: markers of one flexible body move together but for its deformation.
int find_carrier(const Model& model, int body) {
  if (!is_index(body, model.bodies.size())) return body;
  const std::optional<Marker>& marker = model.bodies[static_cast<std::size_t>(body)].marker;
  return marker ? marker->body : body;
}

}  // namespace

void check_shape_pair(const Model& model, const std::string& where, int a, int b, const std::string& key,
                      ModelErrors& errors) {
  if (!is_index(a, model.surfaces.size()) || !is_index(b, model.surfaces.size())) {
    errors.push_back({where, "surfaces that it names do not exist", "indices of two surfaces", key});
    return;
  }
  const Surface &of_a = model.surfaces[static_cast<std::size_t>(a)],
                &of_b = model.surfaces[static_cast<std::size_t>(b)];
  if (find_carrier(model, of_a.body) == find_carrier(model, of_b.body))
    errors.push_back({where, "one body carries both shapes, '" + of_a.name + "' and '" + of_b.name + "'",
                      "name shapes of two bodies", key});
  for (const geometry::Shape& i : of_a.shapes)
    for (const geometry::Shape& k : of_b.shapes)
      if (geometry::has_distance(i.kind, k.kind)) return;
  if (!of_a.shapes.empty() && !of_b.shapes.empty())
    errors.push_back({where, "'" + of_a.name + "' and '" + of_b.name + "' have no distance",
                      "not two half-spaces, and not two hollow shapes", key});
}

void validate_surfaces(const Model& model, ModelErrors& errors) {
  validate_shapes(model, errors);
  const int parts = model.contact_substeps;
  if (parts < -kMaxContactRefinement || parts == -1 || parts > kMaxContactSubsteps)
    errors.push_back({"model", "contact_substeps is " + std::to_string(parts),
                      "1 to " + std::to_string(kMaxContactSubsteps) + ", 0: automatic, or -2 to " +
                          std::to_string(-kMaxContactRefinement) + ": automatic and so many times as fine",
                      "contact_substeps"});
}

}  // namespace unlatch
