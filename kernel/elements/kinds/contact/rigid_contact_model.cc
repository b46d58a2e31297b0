#include <algorithm>
#include <cmath>

#include "kernel/elements/kinds/contact/rigid_contact.h"
#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

// The first pair that has no row.
void check_shapes(const Contact& c, const Check& check) {
  if (!is_index(c.base, check.model.surfaces.size()) || !is_index(c.follower, check.model.surfaces.size())) return;
  const Surface &base = check.model.surfaces[at(c.base)], &follower = check.model.surfaces[at(c.follower)];
  for (const Surface* surface : {&base, &follower})
    if (is_index(surface->body, check.model.bodies.size()) && check.model.bodies[at(surface->body)].marker)
      return check.report("it is rigid, and '" + surface->name + "' is on a body that bends",
                          "a stiffness instead of `rigid`: a rigid contact is between bodies that do not bend",
                          "between");
  for (std::size_t i = 0; i < base.shapes.size(); ++i)
    for (std::size_t k = 0; k < follower.shapes.size(); ++k) {
      const std::pair pair(static_cast<int>(i), static_cast<int>(k));
      if (std::find(c.except.begin(), c.except.end(), pair) != c.except.end()) continue;
      if (has_rigid_row(base.shapes[i].kind, follower.shapes[k].kind)) continue;
      return check.report("it is rigid, and neither shape " + std::to_string(i + 1) + " of '" + base.name +
                              "' nor shape " + std::to_string(k + 1) + " of '" + follower.name +
                              "' is a sphere, or the other is hollow; nor are both capsules",
                          "spheres on one side, such as the ends of a rod or the feet of a box, and convex shapes or a "
                          "half-space on the other; or capsules on both, which cross; or a stiffness instead of "
                          "`rigid`",
                          "between");
    }
}

geometry::Placement get_start(const Model& model, int body) {
  if (body == kGround) return {};
  const Body& own = model.bodies[at(body)];
  return {to_vec(own.p_WB), rotation_matrix(to_quat(own.q_WB))};
}

// The two overlap at the start: nothing could part them but a jump.
void check_start(const Contact& c, const Check& check) {
  const Surface &base = check.model.surfaces[at(c.base)], &follower = check.model.surfaces[at(c.follower)];
  for (const Surface* surface : {&base, &follower})
    if (surface->body != kGround && !is_index(surface->body, check.model.bodies.size())) return;
  const auto is_good = [](const geometry::Shape& shape) { return geometry::check_shape(shape).empty(); };
  for (std::size_t i = 0; i < base.shapes.size(); ++i)
    for (std::size_t k = 0; k < follower.shapes.size(); ++k) {
      if (!is_good(base.shapes[i]) || !is_good(follower.shapes[k])) continue;
      if (std::find(c.except.begin(), c.except.end(), std::pair(static_cast<int>(i), static_cast<int>(k))) !=
          c.except.end())
        continue;
      const double distance =
          geometry::calc_distance(geometry::compile_shape(base.shapes[i]), get_start(check.model, base.body),
                                  geometry::compile_shape(follower.shapes[k]), get_start(check.model, follower.body))
              .distance;
      if (distance >= -kRigidStart) continue;
      return check.report("it is rigid, and shape " + std::to_string(i + 1) + " of '" + base.name + "' and shape " +
                              std::to_string(k + 1) + " of '" + follower.name + "' overlap by " + show(-distance) +
                              " m at the start",
                          "places at which they are apart or just touch", "between");
    }
}

// All rows of a model are solved together.
void check_number(const Contact& c, const Check& check) {
  std::size_t pairs = 0, rows = 0;
  const Contact* first = nullptr;
  for (const Contact& own : check.model.contacts) {
    if (!own.rigid || !is_index(own.base, check.model.surfaces.size()) ||
        !is_index(own.follower, check.model.surfaces.size()))
      continue;
    if (first == nullptr) first = &own;
    const std::size_t of_own =
        check.model.surfaces[at(own.base)].shapes.size() * check.model.surfaces[at(own.follower)].shapes.size() -
        own.except.size();
    pairs += of_own;
    rows += own.friction > 0 ? 3 * of_own : of_own;
  }
  if (first == &c && rows > at(kMostRigidRows))
    check.report("the rigid contacts have " + std::to_string(pairs) +
                     " pairs of shapes in all; rows, three for a pair with friction and one for any other: " +
                     std::to_string(rows),
                 "at most " + std::to_string(kMostRigidRows) + " of these: `except`, or fewer shapes", "between");
}

}  // namespace

void validate_rigid_contact(const Contact& c, const Check& check) {
  const std::size_t mistakes = check.errors.size();
  check_shapes(c, check);
  check_number(c, check);
  if (c.on && check.errors.size() == mistakes && is_index(c.base, check.model.surfaces.size()) &&
      is_index(c.follower, check.model.surfaces.size()))
    check_start(c, check);
  const auto expect = [&](bool good, const char* key, double value, const char* mend) {
    if (!good || !std::isfinite(value)) check.report(std::string(key) + " is " + show(value), mend, key);
  };
  if (c.restitution) expect(*c.restitution >= 0 && *c.restitution <= 1, "restitution", *c.restitution, "0 to 1");
  if (c.settle) expect(*c.settle > 0, "settle", *c.settle, "greater than 0, and finite, in s");
  if (c.stiffness != 0) check.report("it is rigid, and has a stiffness", "one of them", "stiffness");
  if (c.damping != 0)
    check.report("it is rigid, and has a damping", "a restitution, which a rigid contact loses energy by", "damping");
  expect(c.friction >= 0, "friction", c.friction, "0 or more, and finite");
}

void compile_rigid_contact(const Contact& c, PlanDraft& plan, PlanContact& own) {
  own.rigid = true;
  own.stiffness = own.damping = 0;
  own.restitution = c.restitution.value_or(0);
  own.settle = c.settle ? *c.settle : 0.5 * plan.options.dt;
  plan.contacts.push_back(own);  // rows are found through it
  const PlanData made = get_view(plan);
  const auto get_frame = [&](std::int32_t surface) {
    const std::int32_t body = plan.shapes[at(surface)].body;
    return body == kGround ? get_ground<double>() : calc_body_frame(plan.bodies[at(body)].initial);
  };
  RigidRow row{};
  for (std::int32_t i = own.first_pair; i < own.first_pair + own.pairs; ++i) {
    const bool good = calc_rigid_row(made, i, get_frame(own.base), get_frame(own.follower), row);
    plan.contact_pairs[at(i)].closed =
        c.on && good && std::abs(row.gap) <= kRigidStart && std::abs(row.rate) <= kRigidRest;
  }
  plan.contacts.pop_back();
  plan.rigid_pairs += own.pairs;
}

}  // namespace unlatch
