#include "kernel/elements/kinds/contact/rigid_row.h"

#include <algorithm>
#include <cmath>

#include "kernel/elements/kinds/contact/contact.h"
#include "unlatch/contacts.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch {
namespace {

// The acceleration of a body's material at an arm from its origin that its turning alone brings about, W, m/s².
Vec3 calc_centripetal(const BodyFrame& body, const Vec3& arm) { return cross(body.w, cross(body.w, arm)); }

// Mobility along a wrench at the origin of the body that carries the shapes, held by nothing, 1/kg.
double calc_wrench_mobility(const PlanShapes& shapes, const BodyFrame& body, const Spatial& wrench) {
  const Vec3 turn = transpose_times(body.R, wrench.ang);
  return shapes.inverse_mass * dot(wrench.lin, wrench.lin) + dot(turn, shapes.inverse_inertia * turn);
}

// Square of the sine of the least angle between the axes of two capsules whose pair has a row.
constexpr double kLeastCrossing = 1e-6;

// A pair of a sphere or capsule, which one of the bodies carries, and another shape, which the other does.
struct SpherePair {
  geometry::SphereDistance d;
  bool usable;
  bool follows;  // the follower carries the sphere; of two spheres or capsules that is the one
  double radius;
  BodyFrame carrier, other;
  Vec3 u;            // v_S(x) − v_O(x)
  Vec3 slide;        // σ
  Vec3 normal_rate;  // n', seen from O
};

Vec3 calc_place_velocity(const BodyFrame& body, const Vec3& point) { return body.v + cross(body.w, point - body.p); }

SpherePair calc_sphere_pair(const PlanData& plan, std::int32_t pair, const BodyFrame& base, const BodyFrame& follower) {
  const ContactPair& own = plan.contact_pairs[at(pair)];
  const PlanContact& contact = plan.contacts[at(own.contact)];
  const geometry::ShapeView on_base = get_shape(plan, plan.shapes[at(contact.base)], own.base_shape),
                            on_follower = get_shape(plan, plan.shapes[at(contact.follower)], own.follower_shape);
  const bool capsules = on_follower.numbers.kind == geometry::ShapeKind::kCapsule &&
                        on_base.numbers.kind == geometry::ShapeKind::kCapsule;
  const bool follows = capsules || on_follower.numbers.kind == geometry::ShapeKind::kSphere;
  const BodyFrame &carrier = follows ? follower : base, &other = follows ? base : follower;
  const geometry::ShapeView &sphere = follows ? on_follower : on_base, &shape = follows ? on_base : on_follower;
  geometry::CapsuleDistance of;
  if (capsules)
    of = geometry::calc_capsule_distance(sphere, get_placement(carrier), shape, get_placement(other));
  else
    of.sphere = geometry::calc_sphere_distance(sphere, get_placement(carrier), shape, get_placement(other));
  const geometry::SphereDistance& d = of.sphere;
  const Vec3 arm = d.centre - carrier.p, other_arm = d.centre - other.p;
  const Vec3 u = (carrier.v + cross(carrier.w, arm)) - (other.v + cross(other.w, other_arm));
  const Vec3 turned = d.calc_normal_rate(of.axis);  // (dn/dx) a
  const double crossing = dot(of.axis, turned);
  const bool slides = capsules && dot(of.axis, of.axis) > 0;
  const bool usable = d.outside && (!slides || crossing > kLeastCrossing * d.bend);
  Vec3 slide{0, 0, 0};
  if (slides && usable)
    slide = (-(dot(turned, u) + dot(d.normal, cross(carrier.w - other.w, of.axis))) / crossing) * of.axis;
  return {d, usable, follows, sphere.numbers.r0, carrier, other, u, slide, d.calc_normal_rate(u + slide)};
}

// A row of unit wrenches along `along`, at `place` of both bodies; without its numbers.
void set_rigid_row(const PlanData& plan, std::int32_t pair, const SpherePair& s, const Vec3& place, const Vec3& along,
                   RigidRow& row) {
  const PlanContact& contact = plan.contacts[at(plan.contact_pairs[at(pair)].contact)];
  const PlanShapes &of_base = plan.shapes[at(contact.base)], &of_follower = plan.shapes[at(contact.follower)];
  const Spatial on_carrier{along, cross(place - s.carrier.p, along)},
      on_other{-along, -cross(place - s.other.p, along)};
  row.pair = pair;
  row.base = of_base.body;
  row.follower = of_follower.body;
  row.on_base = s.follows ? on_other : on_carrier;
  row.on_follower = s.follows ? on_carrier : on_other;
  row.free = calc_wrench_mobility(of_base, s.follows ? s.other : s.carrier, row.on_base) +
             calc_wrench_mobility(of_follower, s.follows ? s.carrier : s.other, row.on_follower);
  row.tangent = 0;
  row.mode = RigidMode::kSmooth;
  row.friction = row.slip = row.slide[0] = row.slide[1] = 0;
  row.along = along;
}

// Place of the sphere's surface that touches; its velocity as the two materials have it there, one seen from the other;
// that across the normal.
Vec3 calc_touched(const SpherePair& s) { return s.d.centre - s.radius * s.d.normal; }
Vec3 calc_touching(const SpherePair& s) {
  const Vec3 place = calc_touched(s);
  return calc_place_velocity(s.carrier, place) - calc_place_velocity(s.other, place);
}
Vec3 calc_slip(const SpherePair& s) {
  const Vec3 u = calc_touching(s);
  return u - dot(s.d.normal, u) * s.d.normal;
}

// A unit vector across n: along the reference, or in any direction.
Vec3 choose_across(const Vec3& n, const Vec3& reference) {
  const Vec3 along = reference - dot(n, reference) * n;
  const double size = norm(along);
  if (size > 0.5 * norm(reference) && size > 0) return (1 / size) * along;
  const Vec3 helper = std::abs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 across = cross(n, helper);
  return (1 / norm(across)) * across;
}

RigidMode get_rigid_mode(const ContactState& state, const Vec3& reference, double slip) {
  if (state.closed == kPairSticks) return RigidMode::kSticks;
  if (state.closed == kPairCreeps) return RigidMode::kCreeps;
  const bool decided = dot(reference, reference) > 0;
  return decided || slip > kRigidRest ? RigidMode::kSlips : RigidMode::kSticks;
}

// Direction of the slip in the two rows; that of the first where the slip has none of its own.
void set_slide(RigidRow* rows) {
  RigidRow& normal = rows[0];
  if (normal.mode == RigidMode::kSticks) return;
  const bool follows = normal.mode == RigidMode::kSlips && rows[1].rate > 0;
  normal.slide[0] = follows ? rows[1].rate / normal.slip : 1;
  normal.slide[1] = follows ? rows[2].rate / normal.slip : 0;
}

}  // namespace

bool calc_rigid_row(const PlanData& plan, std::int32_t pair, const BodyFrame& base, const BodyFrame& follower,
                    RigidRow& row) noexcept {
  const SpherePair s = calc_sphere_pair(plan, pair, base, follower);
  const geometry::SphereDistance& d = s.d;
  if (!s.usable) return false;
  set_rigid_row(plan, pair, s, d.centre, d.normal, row);
  const Vec3 arm = d.centre - s.carrier.p, other_arm = d.centre - s.other.p;
  row.gap = d.distance;
  row.rate = dot(d.normal, s.u);
  row.slip = norm(calc_slip(s));
  row.bias = dot(d.normal, calc_centripetal(s.carrier, arm) - calc_centripetal(s.other, other_arm) -
                               2.0 * cross(s.other.w, s.u) + cross(s.carrier.w - s.other.w, s.slide)) +
             dot(s.u, s.normal_rate);
  return true;
}

void calc_slip_rows(const PlanData& plan, const ContactState& state, const Vec3& reference, const BodyFrame& base,
                    const BodyFrame& follower, RigidRow* rows) noexcept {
  const std::int32_t pair = rows[0].pair;
  const SpherePair s = calc_sphere_pair(plan, pair, base, follower);
  const Vec3& n = s.d.normal;
  const Vec3 place = calc_touched(s), slip = calc_touching(s);
  const Vec3 way =
      calc_place_velocity(s.carrier, s.d.centre) + s.slide - s.radius * (cross(s.other.w, n) + s.normal_rate);  // c'
  const Vec3 carried =
      cross(s.carrier.w, way) - cross(s.carrier.w, s.carrier.v) - (cross(s.other.w, way) - cross(s.other.w, s.other.v));
  const Vec3 first = choose_across(n, reference);
  for (int k = 1; k <= 2; ++k) {
    RigidRow& row = rows[k];
    set_rigid_row(plan, pair, s, place, k == 1 ? first : cross(n, first), row);
    row.tangent = k;
    row.gap = 0;
    row.rate = dot(row.along, slip);
    row.bias = dot(row.along, carried);
  }
  rows[0].friction = plan.contacts[at(plan.contact_pairs[at(pair)].contact)].friction;
  rows[0].slip = std::sqrt(rows[1].rate * rows[1].rate + rows[2].rate * rows[2].rate);
  rows[0].mode = get_rigid_mode(state, reference, rows[0].slip);
  set_slide(rows);
}

bool collect_rigid_rows(const PlanData& plan, const State& state, double t, Evaluation& ev) noexcept {
  ev.rigid.count = 0;
  for (const PlanContact& contact : plan.contacts) {
    if (!contact.rigid || calc_scale(state.elements[at(contact.element)], t) == 0) continue;
    for (std::int32_t i = contact.first_pair; i < contact.first_pair + contact.pairs; ++i) {
      if (!is_held(state.contacts[at(i)])) continue;
      const BodyFrame base = get_body_frame(ev, plan.shapes[at(contact.base)].body),
                      follower = get_body_frame(ev, plan.shapes[at(contact.follower)].body);
      RigidRow* const rows = &ev.rigid.rows[at(ev.rigid.count)];
      if (!calc_rigid_row(plan, i, base, follower, *rows)) {
        ev.rigid.failed = plan.contact_pairs[at(i)].contact;
        ev.rigid.degenerate = true;
        return false;
      }
      ++ev.rigid.count;
      if (!(contact.friction > 0)) continue;
      calc_slip_rows(plan, state.contacts[at(i)], state.rigid_slips[at(i)], base, follower, rows);
      ev.rigid.count += 2;
    }
  }
  return true;
}

double calc_slip_acceleration(const Evaluation& ev, const RigidRow* rows) noexcept {
  const auto get = [&](int body) {
    return body == kGround ? Spatial{{0, 0, 0}, {0, 0, 0}} : ev.get_acceleration(body);
  };
  double square = 0;
  for (int k = 1; k <= 2; ++k) {
    const double rate = rows[k].bias + apply_rigid_row(rows[k], get(rows[k].base), get(rows[k].follower));
    square += rate * rate;
  }
  return std::sqrt(square);
}

double calc_slip_braking(const Evaluation& ev, const RigidRow* rows) noexcept {
  const double friction = rows[0].friction * std::abs(ev.pair_forces[at(rows[0].pair)]);
  return std::max(calc_slip_acceleration(ev, rows), friction * std::max(rows[1].free, rows[2].free));
}

double calc_least_slip(const PlanData& plan, double change) noexcept {
  const bool automatic = has_automatic_parts(plan.contact_substeps);
  return 2 * change * plan.options.dt / (automatic ? kMaxAutomaticSubsteps : plan.contact_substeps);
}

void store_rigid_forces(const PlanData& plan, const Evaluation& ev, State& state) noexcept {
  for (std::size_t i = 0; i < state.rigid_forces.size(); ++i) {
    const PlanContact& contact = plan.contacts[at(plan.contact_pairs[i].contact)];
    const bool held = contact.rigid && is_held(state.contacts[i]);
    state.rigid_forces[i] = held ? ev.pair_forces[i] : 0;
    if (!state.rigid_frictions.empty())
      state.rigid_frictions[i] = held && contact.friction > 0 ? ev.pair_frictions[i] : Vec3{0, 0, 0};
  }
}

void store_rigid_forces(const Plan& owner, const Workspace& workspace, State& state) noexcept {
  store_rigid_forces(get_data(owner), get_data(workspace).kept.evaluation, state);
}

}  // namespace unlatch
