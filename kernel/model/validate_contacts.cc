// Shapes and contacts: shapes have volume, contacts and distances are of two bodies and of shapes that have a distance.
#include <cmath>

#include "kernel/model/validate.h"
#include "unlatch/geometry.h"

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

void validate_contact(const Model& model, const Contact& c, ModelErrors& errors) {
  const std::string where = quoted("contact", c.name);
  check_shape_pair(model, where, c.base, c.follower, "between", errors);
  const auto check = [&](bool good, const char* key, double value, const char* mend) {
    if (!good || !std::isfinite(value)) errors.push_back({where, std::string(key) + " is " + show(value), mend, key});
  };
  check(c.stiffness > 0, "stiffness", c.stiffness, "greater than 0, and finite");
  check(c.exponent == 1 || c.exponent == 1.5, "exponent", c.exponent, "1 or 1.5");
  check(c.damping >= 0, "damping", c.damping, "0 or more, and finite, in s/m");
  check(c.friction >= 0, "friction", c.friction, "0 or more, and finite");
  check(c.slip_speed > 0, "slip_speed", c.slip_speed, "greater than 0, and finite, in m/s");
  if (!c.restitution) return;
  check(*c.restitution > 0 && *c.restitution <= 1, "restitution", *c.restitution,
        "greater than 0 and at most 1; a blow without any bounce has no finite damping");
  check(c.speed > 0, "speed", c.speed, "greater than 0, in m/s: the speed of the blow that has this restitution");
  if (c.damping != 0)
    errors.push_back(
        {where, "it has both a damping and a restitution", "one of them: each follows from the other", "damping"});
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

void validate_contacts(const Model& model, ModelErrors& errors) {
  validate_shapes(model, errors);
  for (const Contact& contact : model.contacts) validate_contact(model, contact, errors);
  const int parts = model.contact_substeps;
  if (parts != kAutomaticSubsteps && (parts < 1 || parts > kMaxContactSubsteps))
    errors.push_back({"model", "contact_substeps is " + std::to_string(parts),
                      "1 to " + std::to_string(kMaxContactSubsteps) + ", or automatic", "contact_substeps"});
}

}  // namespace unlatch
