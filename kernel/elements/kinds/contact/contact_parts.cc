#include "kernel/elements/kinds/contact/contact_parts.h"

#include <algorithm>
#include <cmath>

#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/kinds/load.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

// Largest parts, in 1 / rate. RK4's error of a blow is some (ω h)⁴/120 of its depth; of sticking, whose slip decays,
// less is needed.
constexpr double kBlow = 0.2, kSlip = 1.0;

// Mobility of a carrier, 1/kg: acceleration along the unit vector u of its material at a point, per force along u
// there.
double calc_mobility(const PlanShapes& shapes, const BodyFrame& body, const Vec3& point, const Vec3& u) {
  const Vec3 lever = transpose_times(body.R, cross(point - body.p, u));
  return shapes.inverse_mass + dot(lever, shapes.inverse_inertia * lever);
}

struct Blow {
  double force, stiffness;  // at its greatest depth: N, N/m
};

// `energy`: that the spring of the contact has to take up, J > 0, at the contact's switch scale.
Blow calc_blow(const PlanContact& contact, double energy, double scale) {
  const double k = scale * contact.stiffness;
  if (!contact.hertzian) return {std::sqrt(2 * energy * k), k};
  const double depth = elementary::exp(0.4 * elementary::log(std::max(2.5 * energy / k, 1e-300)));
  const double root = std::sqrt(depth);
  return {k * depth * root, 1.5 * k * root};
}

// Speed at which a pair closes within the step, m/s: the present one, and what it gains in the step.
double calc_approach(const PlanData& plan, const ClosedPair& pair, const PlanShapes& base, const BodyFrame& at_base,
                     const PlanShapes& follower, const BodyFrame& at_follower, const Evaluation& ev) {
  const auto calc_acceleration = [&](const PlanShapes& shapes, const BodyFrame& body) {
    if (shapes.body == kGround) return Vec3{0, 0, 0};
    const Spatial a = ev.get_acceleration(shapes.body);
    return a.lin + cross(a.ang, pair.point - body.p);
  };
  if (!plan.rigid) return std::abs(pair.rate);  // accelerations of markers are not known before the readings
  const Vec3 gained = calc_acceleration(base, at_base) - calc_acceleration(follower, at_follower);
  return std::abs(pair.rate) + std::max(0.0, dot(pair.normal, gained)) * plan.options.dt;
}

// Parts per second that the pair needs.
double calc_rate(const PlanData& plan, const ClosedPair& pair, const PlanContact& contact, double scale,
                 const Evaluation& ev) {
  const PlanShapes &a = plan.shapes[at(contact.base)], &b = plan.shapes[at(contact.follower)];
  const BodyFrame base = get_body_frame(ev, a.body), follower = get_body_frame(ev, b.body);
  const auto calc = [&](const Vec3& u) {
    return calc_mobility(a, base, pair.point, u) + calc_mobility(b, follower, pair.point, u);
  };
  const double along_normal = calc(pair.normal);
  if (!(along_normal > 0)) return 0;
  const double approach = calc_approach(plan, pair, a, base, b, follower, ev);
  const double energy = scale * calc_stored(contact, pair.depth) + 0.5 * approach * approach / along_normal;
  if (!(energy > 0)) return 0;
  const Blow blow = calc_blow(contact, energy, scale);
  const double omega = std::sqrt(blow.stiffness * along_normal), damping = blow.force * contact.damping * along_normal;
  double fastest = std::max(omega, damping) / kBlow;
  if (contact.friction > 0) {
    const Vec3 helper = std::abs(pair.normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 across = cross(pair.normal, helper), t = (1 / norm(across)) * across;
    const double along = std::max(calc(t), calc(cross(pair.normal, t)));
    const double slip = std::sqrt(dot(pair.slip, pair.slip) + contact.slip_speed * contact.slip_speed);
    fastest = std::max(fastest, contact.friction * blow.force * along / (slip * kSlip));
  }
  return fastest;
}

}  // namespace

int count_contact_parts(const PlanData& plan, const State& state, double t, const Evaluation& ev) noexcept {
  double fastest = -1;  // no pair is closed
  for (const PlanContact& contact : plan.contacts)
    for (std::size_t i = at(contact.first_pair); i < at(contact.first_pair + contact.pairs); ++i) {
      if (state.contacts[i].closed == 0) continue;
      if (plan.contact_substeps != kAutomaticSubsteps) return plan.contact_substeps;
      const double scale = calc_scale(state.elements[at(contact.element)], t);
      fastest = std::max(fastest, scale > 0 ? calc_rate(plan, ev.closed_pairs[i], contact, scale, ev) : 0);
    }
  int parts = 1;
  while (parts < kMaxAutomaticSubsteps && plan.options.dt * fastest > parts) parts *= 2;
  return parts;
}

}  // namespace unlatch
