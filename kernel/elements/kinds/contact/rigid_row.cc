#include "kernel/elements/kinds/contact/rigid_row.h"

#include "kernel/elements/kinds/contact/contact.h"
#include "unlatch/contacts.h"

namespace unlatch {
namespace {

// The acceleration of a body's material at an arm from its origin that its turning alone brings about, W, m/s².
Vec3 calc_centripetal(const BodyFrame& body, const Vec3& arm) { return cross(body.w, cross(body.w, arm)); }

// Mobility along a wrench at the origin of the body that carries the shapes, held by nothing, 1/kg.
double calc_mobility(const PlanShapes& shapes, const BodyFrame& body, const Spatial& wrench) {
  const Vec3 turn = transpose_times(body.R, wrench.ang);
  return shapes.inverse_mass * dot(wrench.lin, wrench.lin) + dot(turn, shapes.inverse_inertia * turn);
}

}  // namespace

bool calc_rigid_row(const PlanData& plan, std::int32_t pair, const BodyFrame& base, const BodyFrame& follower,
                    RigidRow& row) noexcept {
  const ContactPair& own = plan.contact_pairs[at(pair)];
  const PlanContact& contact = plan.contacts[at(own.contact)];
  const PlanShapes &of_base = plan.shapes[at(contact.base)], &of_follower = plan.shapes[at(contact.follower)];
  const geometry::ShapeView on_base = get_shape(plan, of_base, own.base_shape),
                            on_follower = get_shape(plan, of_follower, own.follower_shape);
  // Of two spheres the follower's is taken for the sphere.
  const bool follows = on_follower.numbers.kind == geometry::ShapeKind::kSphere;
  const BodyFrame &carrier = follows ? follower : base, &other = follows ? base : follower;
  const geometry::SphereDistance d = geometry::calc_sphere_distance(
      follows ? on_follower : on_base, get_placement(carrier), follows ? on_base : on_follower, get_placement(other));
  if (!d.outside) return false;
  const Vec3 arm = d.centre - carrier.p, other_arm = d.centre - other.p;
  const Vec3 u = (carrier.v + cross(carrier.w, arm)) - (other.v + cross(other.w, other_arm));
  const Spatial on_carrier{d.normal, cross(arm, d.normal)}, on_other{-d.normal, -cross(other_arm, d.normal)};
  row.pair = pair;
  row.base = of_base.body;
  row.follower = of_follower.body;
  row.on_base = follows ? on_other : on_carrier;
  row.on_follower = follows ? on_carrier : on_other;
  row.gap = d.distance;
  row.rate = dot(d.normal, u);
  row.bias =
      dot(d.normal, calc_centripetal(carrier, arm) - calc_centripetal(other, other_arm) - 2.0 * cross(other.w, u)) +
      dot(u, d.calc_normal_rate(u));
  row.free = calc_mobility(of_base, base, row.on_base) + calc_mobility(of_follower, follower, row.on_follower);
  return true;
}

std::int32_t collect_rigid_rows(const PlanData& plan, const State& state, double t, Evaluation& ev) noexcept {
  ev.rigid.count = 0;
  for (const PlanContact& contact : plan.contacts) {
    if (!contact.rigid || calc_scale(state.elements[at(contact.element)], t) == 0) continue;
    for (std::int32_t i = contact.first_pair; i < contact.first_pair + contact.pairs; ++i) {
      if (state.contacts[at(i)].closed != 1) continue;  // neither open nor about to leave
      const BodyFrame base = get_body_frame(ev, plan.shapes[at(contact.base)].body),
                      follower = get_body_frame(ev, plan.shapes[at(contact.follower)].body);
      if (!calc_rigid_row(plan, i, base, follower, ev.rigid.rows[at(ev.rigid.count)])) return i;
      ++ev.rigid.count;
    }
  }
  return kNone;
}

void store_rigid_forces(const PlanData& plan, const Evaluation& ev, State& state) noexcept {
  for (std::size_t i = 0; i < state.rigid_forces.size(); ++i) {
    const PlanContact& contact = plan.contacts[at(plan.contact_pairs[i].contact)];
    state.rigid_forces[i] = contact.rigid && state.contacts[i].closed == 1 ? ev.pair_forces[i] : 0;
  }
}

void store_rigid_forces(const Plan& owner, const Workspace& workspace, State& state) noexcept {
  store_rigid_forces(get_data(owner), get_data(workspace).kept.evaluation, state);
}

}  // namespace unlatch
