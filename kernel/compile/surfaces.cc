#include "kernel/compile/surfaces.h"

#include <Eigen/LU>

namespace unlatch {
namespace {

// Mobility of the body that carries the shapes; with a mass law, that at its lightest knot.
void add_mobility(const Model& model, PlanShapes& shapes) {
  if (shapes.body == kGround) return;
  const Body* body = &model.bodies[at(shapes.body)];
  if (body->marker) {
    shapes.inverse_mass += body->marker->shape.squaredNorm();  // of the modes, whose modal masses are 1
    body = &model.bodies[at(body->marker->body)];
  }
  double mass = body->mass;
  Eigen::Matrix3d inertia = body->inertia;
  if (body->law)
    for (const MassLaw::Knot& knot : body->law->knots)
      if (knot.mass < mass || &knot == body->law->knots.data()) {
        mass = knot.mass;
        inertia = knot.inertia;
      }
  shapes.inverse_mass += 1 / mass;
  const Eigen::Matrix3d inverse = inertia.inverse();
  const auto column = [&](int i) { return Vec3{inverse(0, i), inverse(1, i), inverse(2, i)}; };
  shapes.inverse_inertia = {column(0), column(1), column(2)};
}

void append_shape(const geometry::CompiledShape& shape, PlanDraft& plan) {
  geometry::ShapeNumbers numbers = shape;
  const auto append = [&](auto& list, const auto& points) {
    numbers.first = static_cast<std::int32_t>(list.size());
    numbers.count = static_cast<std::int32_t>(points.size());
    list.insert(list.end(), points.begin(), points.end());
  };
  if (shape.kind == geometry::ShapeKind::kHull) append(plan.hull_points, shape.points);
  if (shape.kind == geometry::ShapeKind::kHollow) append(plan.profile_points, shape.profile);
  plan.shape_parts.push_back(numbers);
}

}  // namespace

void compile_surfaces(const Model& model, PlanDraft& plan) {
  for (const Surface& set : model.surfaces) {
    const geometry::ShapeGroup group = geometry::build_group(set.name, set.shapes);
    plan.shapes.push_back({set.body, static_cast<std::int32_t>(plan.shape_parts.size()),
                           static_cast<std::int32_t>(group.parts->size()), group});
    for (const geometry::CompiledShape& shape : *group.parts) append_shape(shape, plan);
    add_mobility(model, plan.shapes.back());
  }
}

}  // namespace unlatch
