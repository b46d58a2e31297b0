#include "kernel/compile/contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernel/compile/elements.h"
#include "kernel/math/index.h"
#include "unlatch/contacts.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

geometry::Placement get_start(const PlanData& plan, int body) {
  if (body == kGround) return {};
  const BodyState& start = plan.bodies[at(body)].initial;
  return {start.p, rotation_matrix(start.q)};
}

// Energy left over by restitution at x = d v less that of e: negative below the root, positive above it. The series in
// x where the closed form cancels.
double calc_surplus(double e, double x) {
  if (x < 0.25) {
    double sum = 0, power = 1, e_power = e * e, sign = 1;
    for (int j = 2; j < 40; ++j) {
      sum += power * (e_power - sign) / j;
      power *= x;
      e_power *= e;
      sign = -sign;
    }
    return sum;
  }
  return (1 + x) - (1 - e * x) * elementary::exp(x * (1 + e));
}

// The carrier's mobility; of a body with a mass law, that of its lightest knot.
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

}  // namespace

double calc_contact_damping(double e, double speed) {
  if (!(e < 1)) return 0;
  double low = 0, high = 1 / e;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (calc_surplus(e, middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high) / speed;
}

void compile_contacts(const Model& model, PlanData& plan) {
  for (const Surface& set : model.surfaces) {
    plan.shapes.push_back({set.body, geometry::build_group(set.name, set.shapes)});
    add_mobility(model, plan.shapes.back());
  }
  for (const Contact& c : model.contacts) {
    const auto place = static_cast<std::int32_t>(plan.contacts.size());
    const std::int32_t element = add_element(plan, c.on);
    PlanContact out{c.base,
                    c.follower,
                    element,
                    static_cast<std::int32_t>(plan.contact_pairs.size()),
                    0,
                    static_cast<std::int32_t>(plan.initial_auxiliary.size()),
                    c.exponent > 1,
                    c.stiffness,
                    c.restitution ? calc_contact_damping(*c.restitution, c.speed) : c.damping,
                    c.friction,
                    c.slip_speed};
    plan.initial_auxiliary.insert(plan.initial_auxiliary.end(), sizeof(ContactTotals) / sizeof(double), 0.0);
    const PlanShapes &a = plan.shapes[at(c.base)], &b = plan.shapes[at(c.follower)];
    const geometry::Placement at_a = get_start(plan, a.body), at_b = get_start(plan, b.body);
    for (std::size_t i = 0; i < a.group.shapes.size(); ++i)
      for (std::size_t k = 0; k < b.group.shapes.size(); ++k) {
        const double distance = geometry::calc_distance(a.group.shapes[i], at_a, b.group.shapes[k], at_b).distance;
        const std::pair pair(static_cast<int>(i), static_cast<int>(k));
        const bool left_out = std::find(c.except.begin(), c.except.end(), pair) != c.except.end();
        if (left_out || !std::isfinite(distance)) continue;  // infinite: this pair has none
        plan.contact_pairs.push_back(
            {place, static_cast<std::int32_t>(i), static_cast<std::int32_t>(k), c.on && distance < 0});
        ++out.pairs;
      }
    plan.contacts.push_back(out);
  }
  plan.contact_substeps = model.contact_substeps;
}

}  // namespace unlatch
