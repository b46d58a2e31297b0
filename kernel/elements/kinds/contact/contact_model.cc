#include <algorithm>
#include <cmath>
#include <utility>

#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/kinds/contact/rigid_contact.h"
#include "kernel/model/validate.h"
#include "kernel/plan/plan_lists.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

geometry::Placement get_start(const PlanDraft& plan, int body) {
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

ElementTraits ContactKind::describe(const Model& model, const Contact& c) {
  const auto get_body = [&](int surface) {
    return is_index(surface, model.surfaces.size()) ? model.surfaces[at(surface)].body : kGround;
  };
  return {.kind = "contact",
          .base = get_body(c.base),
          .follower = get_body(c.follower),
          .has_coordinate = false,
          .is_contact = true};
}

void ContactKind::validate(const Contact& c, const Check& element) {
  const Check own{element.model, quoted("contact", c.name), element.errors};
  check_shape_pair(own.model, own.where, c.base, c.follower, "between", own.errors);
  if (c.rigid) return validate_rigid_contact(c, own);
  const auto check = [&](bool good, const char* key, double value, const char* mend) {
    if (!good || !std::isfinite(value)) own.report(std::string(key) + " is " + show(value), mend, key);
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
    own.report("it has both a damping and a restitution", "one of them: each follows from the other", "damping");
}

PlanContact ContactKind::compile(const Contact& c, ElementCompiler& compiler) {
  PlanDraft& plan = compiler.plan;
  const auto place = static_cast<std::int32_t>(plan.contacts.size());
  PlanContact out{c.base,
                  c.follower,
                  compiler.get_element(),
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
  const PlanData made = get_view(plan);
  for (std::size_t i = 0; i < at(a.count); ++i)
    for (std::size_t k = 0; k < at(b.count); ++k) {
      const double distance = geometry::calc_distance(get_shape(made, a, static_cast<std::int32_t>(i)), at_a,
                                                      get_shape(made, b, static_cast<std::int32_t>(k)), at_b)
                                  .distance;
      const std::pair pair(static_cast<int>(i), static_cast<int>(k));
      const bool left_out = std::find(c.except.begin(), c.except.end(), pair) != c.except.end();
      if (left_out || !std::isfinite(distance)) continue;  // infinite: this pair has none
      plan.contact_pairs.push_back(
          {place, static_cast<std::int32_t>(i), static_cast<std::int32_t>(k), c.on && !c.rigid && distance < 0});
      ++out.pairs;
    }
  if (c.rigid) compile_rigid_contact(c, plan, out);
  return out;
}

}  // namespace unlatch
