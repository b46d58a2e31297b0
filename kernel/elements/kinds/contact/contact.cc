#include "kernel/elements/kinds/contact/contact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "kernel/elements/kinds/contact/contact_parts.h"
#include "kernel/elements/push.h"
#include "kernel/geometry/distance.h"
#include "kernel/geometry/groups.h"

namespace unlatch {
namespace {

// Multiple of the way that bodies go in a step at their present speeds: pairs farther apart than that cannot touch
// within it.
constexpr double kMargin = 2;

// Velocity of a body's material at a point of W, world axes, m/s.
Vec3 calc_velocity(const BodyFrame& body, const Vec3& point) { return body.v + cross(body.w, point - body.p); }

const geometry::ShapeNumbers& get_numbers(const PlanData& plan, const PlanShapes& of, std::int32_t part) {
  return plan.shape_parts[at(of.first + part)];
}

geometry::GroupDistance calc_group_distance(const PlanData& plan, const PlanShapes& a, const BodyFrame& at_a,
                                            const PlanShapes& b, const BodyFrame& at_b) {
  const auto get_part = [&](const PlanShapes& of) {
    return [&plan, group = &of](std::size_t i) { return get_shape(plan, *group, static_cast<std::int32_t>(i)); };
  };
  return geometry::calc_least(at(a.count), get_part(a), get_placement(at_a), at(b.count), get_part(b),
                              get_placement(at_b));
}

geometry::Distance calc_pair_distance(const PlanData& plan, const ContactPair& pair, const BodyFrame& base,
                                      const BodyFrame& follower) {
  const PlanContact& contact = plan.contacts[at(pair.contact)];
  return geometry::calc_distance(get_shape(plan, plan.shapes[at(contact.base)], pair.base_shape), get_placement(base),
                                 get_shape(plan, plan.shapes[at(contact.follower)], pair.follower_shape),
                                 get_placement(follower));
}

Vec3 calc_middle(const geometry::Distance& distance) { return 0.5 * (distance.on_a + distance.on_b); }

// Velocity of the follower's material at a point of W, seen from the base's there, world axes, m/s.
Vec3 calc_velocity(const BodyFrame& base, const BodyFrame& follower, const Vec3& point) {
  return calc_velocity(follower, point) - calc_velocity(base, point);
}

// Rate of the distance, m/s: the witnesses lie along the normal, about which they may turn.
double calc_rate(const geometry::Distance& distance, const Vec3& velocity) { return dot(distance.normal, velocity); }

// A contact's totals among auxiliary states, or their rates.
ContactTotals read_totals(std::span<const double> auxiliary, const PlanContact& contact) {
  std::array<double, sizeof(ContactTotals) / sizeof(double)> numbers;
  std::copy_n(auxiliary.begin() + contact.auxiliary, numbers.size(), numbers.begin());
  return std::bit_cast<ContactTotals>(numbers);
}
void write_totals(const ContactTotals& totals, std::span<double> auxiliary, const PlanContact& contact) {
  const auto numbers = std::bit_cast<std::array<double, sizeof(ContactTotals) / sizeof(double)>>(totals);
  std::copy(numbers.begin(), numbers.end(), auxiliary.begin() + contact.auxiliary);
}

}  // namespace

void ContactRates::store(const PlanContact& contact, Evaluation& ev) const noexcept {
  write_totals({force_, slip_.get(), loss_}, ev.auxiliary.rate, contact);
}

void add_impulse(const PlanContact& contact, double impulse, double loss, Evaluation& ev) noexcept {
  ContactTotals totals = read_totals(ev.auxiliary.now, contact);
  totals.impulse += impulse;
  totals.dissipated += loss;
  write_totals(totals, ev.auxiliary.now, contact);
}

namespace {

// Pairs whose bounds are within this part of their size are computed in any case: there an acceleration matters.
constexpr double kNear = 1e-4;

double calc_speed(const PlanShapes& a, const BodyFrame& at_a, const PlanShapes& b, const BodyFrame& at_b) {
  return geometry::calc_closing_speed(a.group, {at_a.v, norm(at_a.w), 0}, b.group, {at_b.v, norm(at_b.w), 0});
}

// Lower bound of the distance of two surfaces by their bounding spheres; negative infinity if they may come near
// `threshold` within `interval`.
double calc_far_bound(const PlanShapes& a, const BodyFrame& at_a, const PlanShapes& b, const BodyFrame& at_b,
                      double threshold, double interval) {
  const double bound = geometry::calc_lower_bound(a.group, get_placement(at_a), b.group, get_placement(at_b));
  if (!(bound > threshold)) return -HUGE_VAL;
  return bound > threshold + kMargin * calc_speed(a, at_a, b, at_b) * interval ? bound : -HUGE_VAL;
}

// Two bodies with shapes that may touch, and what all pairs of them share: how the follower turns relative to the base.
struct TwoBodies {
  MovingFrame base, follower;
  Vec3 turn;                              // rad/s
  double spin, turning;                   // rad/s; what a point at 1 m of a turn's axis gains, at most, m/s²
  double carried_base, carried_follower;  // rad/s, of each body's own turn
};
TwoBodies relate(const MovingFrame& base, const MovingFrame& follower) {
  TwoBodies out{base, follower, follower.frame.w - base.frame.w, 0, 0, norm(base.frame.w), norm(follower.frame.w)};
  out.spin = norm(out.turn);
  out.turning = norm(follower.acceleration.ang - base.acceleration.ang);
  return out;
}

// How fast the slab between two shapes may narrow, or have narrowed before, m/s and m/s²: a slab that is fixed in one
// of the bodies, across `n`, from A to B. `of_follower`: the other body, which moves, is the follower; `centre`,
// `bound`: of the sphere about its shape.
struct Narrowing {
  double speed, increase;
};
Narrowing calc_narrowing(const TwoBodies& bodies, bool of_follower, const Vec3& n, const Vec3& centre, double bound) {
  const auto calc_motion = [&centre](const MovingFrame& body) {
    const Vec3 arm = centre - body.frame.p, turning = cross(body.frame.w, arm);
    return Spatial{(body.acceleration.lin + cross(body.acceleration.ang, arm)) + cross(body.frame.w, turning),
                   body.frame.v + turning};  // acceleration, velocity
  };
  const Spatial of_base = calc_motion(bodies.base), of_other = calc_motion(bodies.follower);
  const Vec3 v = of_other.ang - of_base.ang, a = of_other.lin - of_base.lin;
  const double spin = bodies.spin, carried = of_follower ? bodies.carried_base : bodies.carried_follower;
  return {std::abs(dot(n, v)) + bound * norm(cross(n, bodies.turn)),
          std::abs(dot(n, a)) + bound * (bodies.turning + spin * (spin + 2 * carried)) + 2 * carried * norm(v)};
}

// Two shapes of a pair at their places.
struct PlacedPair {
  const geometry::ShapeNumbers &a, &b;  // of the base, of the follower
  double near;                          // m: within this a pair is computed in any case
};
PlacedPair get_placed(const PlanData& plan, const ContactPair& pair) {
  const PlanContact& contact = plan.contacts[at(pair.contact)];
  const geometry::ShapeNumbers& a = get_numbers(plan, plan.shapes[at(contact.base)], pair.base_shape);
  const geometry::ShapeNumbers& b = get_numbers(plan, plan.shapes[at(contact.follower)], pair.follower_shape);
  return {a, b, kNear * (a.bound + b.bound)};
}

// A slab that parts two shapes, fixed in the body of one of them.
struct PartingSlab {
  double width = -HUGE_VAL;  // m
  Vec3 normal{0, 0, 0};      // from the fixed shape to the other, W
  bool of_follower = true;   // the other is the follower's
  Vec3 centre{0, 0, 0};      // of the sphere about the other, W
  double bound = 0;          // m, its radius
};

// The widest slab between the boxes about the shapes.
PartingSlab calc_slab(const PlacedPair& pair, const TwoBodies& bodies) {
  const Vec3 origin = bodies.base.frame.p;
  const geometry::Box box_a = geometry::build_box(pair.a, get_placement(bodies.base.frame), origin),
                      box_b = geometry::build_box(pair.b, get_placement(bodies.follower.frame), origin);
  const geometry::Slab slab = geometry::calc_widest_slab(box_a, box_b);
  if (pair.b.bound <= pair.a.bound)
    return {slab.width, slab.normal, true, origin + box_b.c, pair.b.bound};  // the smaller one turns less far
  return {slab.width, -slab.normal, false, origin + box_a.c, pair.a.bound};
}

// Whether the slab stays open for `interval`, and was open for as long: at the end of a sub-step that tells whether the
// shapes touched and parted again within it.
bool stays_open(const PartingSlab& slab, double near, const TwoBodies& bodies, double interval) {
  if (!(slab.width > near)) return false;
  const Narrowing narrowing = calc_narrowing(bodies, slab.of_follower, slab.normal, slab.centre, slab.bound);
  return slab.width > near + kMargin * (narrowing.speed + 0.5 * narrowing.increase * interval) * interval;
}

// Lower bound of the distance of a pair of shapes, for touches: by the sphere about one and the box about the other, or
// by a plane between them, which parts bodies that slide along each other; negative infinity if they may touch.
// `way`: the distance that bodies may go in the interval. Accelerations of markers are not known yet.
double calc_far_bound(const PlanData& plan, const ContactPair& own, const TwoBodies& bodies, double way,
                      double interval) {
  const PlacedPair pair = get_placed(plan, own);
  const geometry::Placement base = get_placement(bodies.base.frame), follower = get_placement(bodies.follower.frame);
  const geometry::SphereBound sphere = geometry::calc_sphere_bound(pair.a, base, pair.b, follower);
  if (sphere.distance > way + pair.near) return sphere.distance;
  if (!plan.rigid || !std::isfinite(pair.near)) return -HUGE_VAL;
  const geometry::ShapeNumbers& round = sphere.of_b ? pair.b : pair.a;
  const PartingSlab slab{sphere.width, sphere.normal, sphere.of_b, sphere.centre, round.bound};
  if (stays_open(slab, pair.near, bodies, interval)) return slab.width;
  if (round.kind == geometry::ShapeKind::kSphere) return -HUGE_VAL;  // boxes part it no better
  const PartingSlab boxes = calc_slab(pair, bodies);
  return stays_open(boxes, pair.near, bodies, interval) ? boxes.width : -HUGE_VAL;
}

// Time until pairs are examined again: a part of the step if closed contacts cut it, else the step.
double calc_interval(const PlanData& plan, const State& state) {
  for (const ContactState& pair : state.contacts)
    if (pair.closed != 0) return plan.options.dt / get_fewest_parts(plan);
  return plan.options.dt;
}

}  // namespace

geometry::ShapeView get_shape(const PlanData& plan, const PlanShapes& of, std::int32_t part) noexcept {
  const geometry::ShapeNumbers& numbers = get_numbers(plan, of, part);
  const std::size_t first = at(numbers.first), count = at(numbers.count);
  if (numbers.kind == geometry::ShapeKind::kHull) return {numbers, plan.hull_points.subspan(first, count), {}};
  if (numbers.kind == geometry::ShapeKind::kHollow) return {numbers, {}, plan.profile_points.subspan(first, count)};
  return {numbers, {}, {}};
}

double calc_stored(const PlanContact& contact, double depth) noexcept {
  if (!(depth > 0)) return 0;
  return contact.hertzian ? contact.stiffness * (depth * depth) * std::sqrt(depth) / 2.5
                          : 0.5 * contact.stiffness * (depth * depth);
}

PairForce calc_pair_force(const PlanContact& contact, const geometry::Distance& distance, const BodyFrame& base,
                          const BodyFrame& follower, double scale) noexcept {
  PairForce out;
  out.point = calc_middle(distance);
  const Vec3 v = calc_velocity(base, follower, out.point);
  const double parting = calc_rate(distance, v);
  const Vec3 slip = v - parting * distance.normal;
  out.rate = -parting;
  out.slip_velocity = slip;
  out.slip = norm(slip);
  if (!(distance.distance < 0)) return out;
  out.depth = -distance.distance;
  const double root = contact.hertzian ? std::sqrt(out.depth) : 1;
  out.stiffness = scale * contact.stiffness * root * (contact.hertzian ? 1.5 : 1);
  out.elastic = scale * contact.stiffness * out.depth * root;
  out.stored = scale * calc_stored(contact, out.depth);
  out.normal = std::max(0.0, out.elastic * (1 + contact.damping * out.rate));
  const double size = std::sqrt(out.slip * out.slip + contact.slip_speed * contact.slip_speed);
  const double per_slip = contact.friction * out.normal / size;
  out.friction = per_slip * out.slip;
  out.force = out.normal * distance.normal - per_slip * slip;
  return out;
}

PairSlopes calc_slopes(const PlanContact& contact, const ClosedPair& pair, double scale) noexcept {
  const double damped = 1 + contact.damping * pair.rate;
  if (!(pair.depth > 0 && damped > 0)) return {};
  const double steep = scale * contact.stiffness * (contact.hertzian ? std::sqrt(pair.depth) : 1);
  const double elastic = steep * pair.depth;
  const double slip = norm(pair.slip), speed = contact.slip_speed, size = std::sqrt(slip * slip + speed * speed);
  const double across = contact.friction * (elastic * damped) / size, bend = speed / size;
  return {steep * (contact.hertzian ? 1.5 : 1) * damped, elastic * contact.damping, across * (bend * bend), across};
}

double calc_depth_acceleration(const PlanData& plan, const ContactPair& pair, const MovingFrame& base,
                               const MovingFrame& follower, double rate, double step) noexcept {
  constexpr double kMoment = 0.01;  // of the step
  const double t = kMoment * step;
  const auto advance = [t](const MovingFrame& body) {
    const BodyFrame& at = body.frame;
    const Vec3 turn = t * (at.w + (0.5 * t) * body.acceleration.ang);
    const auto rotate = [&turn](const Vec3& axis) {
      const Vec3 once = cross(turn, axis);
      return axis + (once + 0.5 * cross(turn, once));
    };
    BodyFrame out = at;
    out.R = {rotate(at.R.x), rotate(at.R.y), rotate(at.R.z)};
    out.p = at.p + t * (at.v + (0.5 * t) * body.acceleration.lin);
    out.v = at.v + t * body.acceleration.lin;
    out.w = at.w + t * body.acceleration.ang;
    return out;
  };
  const BodyFrame later_base = advance(base), later_follower = advance(follower);
  const geometry::Distance d = calc_pair_distance(plan, pair, later_base, later_follower);
  return (-calc_rate(d, calc_velocity(later_base, later_follower, calc_middle(d))) - rate) / t;
}

void ContactKind::add_forces(const Instant& now, const PlanContact& contact, double scale, Evaluation& ev) {
  if (contact.rigid) return;
  const PlanData& plan = now.plan;
  const std::int32_t body_a = plan.shapes[at(contact.base)].body, body_b = plan.shapes[at(contact.follower)].body;
  const BodyFrame base = get_body_frame(ev, body_a), follower = get_body_frame(ev, body_b);
  ContactRates rates;
  for (std::size_t i = at(contact.first_pair); i < at(contact.first_pair + contact.pairs); ++i) {
    if (now.state.contacts[i].closed == 0) continue;
    const geometry::Distance distance = calc_pair_distance(plan, plan.contact_pairs[i], base, follower);
    const PairForce f = calc_pair_force(contact, distance, base, follower, scale);
    ev.pair_distances[i] = distance.distance;
    ev.closed_pairs[i] = {f.point, distance.normal, f.slip_velocity, -distance.distance, f.rate};
    push(ev, body_b, f.force, cross(f.point - follower.p, f.force));
    push(ev, body_a, -f.force, cross(f.point - base.p, -f.force));
    rates.add(f.normal, f.slip, f.calc_loss());
  }
  rates.store(contact, ev);
}

void ContactKind::add_energy(const StageMotion& motion, const PlanContact& contact, std::size_t, EnergySum& sum) {
  const State& state = motion.state();
  sum.flow.dissipated += read_totals(state.auxiliary, contact).dissipated;
  const ElementState& element = state.elements[at(contact.element)];
  if (calc_scale(element, motion.time()) == 0) return;
  for (std::size_t i = at(contact.first_pair); i < at(contact.first_pair + contact.pairs); ++i)
    if (state.contacts[i].closed != 0)
      sum.store(element, motion.time(), calc_stored(contact, -motion.ev.pair_distances[i]));
}

double calc_shape_distance(const PlanData& plan, const Evaluation& ev, int a, int b) noexcept {
  const PlanShapes &of_a = plan.shapes[at(a)], &of_b = plan.shapes[at(b)];
  return calc_group_distance(plan, of_a, get_body_frame(ev, of_a.body), of_b, get_body_frame(ev, of_b.body))
      .least.distance;
}

double calc_guarded_distance(const PlanData& plan, const Evaluation& ev, int a, int b, double threshold) noexcept {
  const PlanShapes &of_a = plan.shapes[at(a)], &of_b = plan.shapes[at(b)];
  const double bound = calc_far_bound(of_a, get_body_frame(ev, of_a.body), of_b, get_body_frame(ev, of_b.body),
                                      threshold, plan.options.dt);
  return std::isfinite(bound) ? bound : calc_shape_distance(plan, ev, a, b);
}

void update_open_pairs(const Instant& now, Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  const double interval = calc_interval(plan, now.state);
  const auto get_moving = [&](std::int32_t body) {
    const bool still = body == kGround || !plan.rigid;
    return MovingFrame{get_body_frame(ev, body), still ? Spatial{} : ev.get_acceleration(body)};
  };
  TwoBodies bodies{};
  std::int32_t of_base = kNone - 1, of_follower = of_base;  // whose these are: mostly contacts in a row have the same
  for (const PlanContact& contact : plan.contacts) {
    if (calc_scale(now.state.elements[at(contact.element)], now.t) == 0) continue;
    const PlanShapes &a = plan.shapes[at(contact.base)], &b = plan.shapes[at(contact.follower)];
    if (a.body != of_base || b.body != of_follower)
      bodies = relate(get_moving(of_base = a.body), get_moving(of_follower = b.body));
    const BodyFrame &base = bodies.base.frame, &follower = bodies.follower.frame;
    const double all = calc_far_bound(a, base, b, follower, 0, plan.options.dt);
    const bool far = std::isfinite(all);
    const double way = far ? 0 : kMargin * calc_speed(a, base, b, follower) * interval;
    for (std::size_t i = at(contact.first_pair); i < at(contact.first_pair + contact.pairs); ++i) {
      if (now.state.contacts[i].closed != 0) continue;
      const ContactPair& pair = plan.contact_pairs[i];
      const double bound = far ? all : calc_far_bound(plan, pair, bodies, way, interval);
      ev.pair_distances[i] = bound;
      ev.pair_rates[i] = 0;
      if (std::isfinite(bound)) continue;
      const geometry::Distance distance = calc_pair_distance(plan, pair, base, follower);
      ev.pair_distances[i] = distance.distance;
      ev.pair_rates[i] = calc_rate(distance, calc_velocity(base, follower, calc_middle(distance)));
    }
  }
}

double calc_open_distance(const PlanData& plan, std::size_t pair, const Evaluation& ev) noexcept {
  const ContactPair& own = plan.contact_pairs[pair];
  const PlanContact& contact = plan.contacts[at(own.contact)];
  return calc_pair_distance(plan, own, get_body_frame(ev, plan.shapes[at(contact.base)].body),
                            get_body_frame(ev, plan.shapes[at(contact.follower)].body))
      .distance;
}

PairFeature calc_pair_feature(const PlanData& plan, std::size_t pair, bool off, const Evaluation& ev) noexcept {
  const ContactPair& own = plan.contact_pairs[pair];
  const PlanContact& contact = plan.contacts[at(own.contact)];
  PairFeature out;
  out.fill(std::numeric_limits<double>::quiet_NaN());
  if (off || contact.rigid) return out;
  const PlanShapes &a = plan.shapes[at(contact.base)], &b = plan.shapes[at(contact.follower)];
  const ClosedPair& closed = ev.closed_pairs[pair];
  const Vec3 half = (0.5 * closed.depth) * closed.normal;
  const geometry::PairMargins margins =
      geometry::calc_pair_margins(get_shape(plan, a, own.base_shape), get_placement(get_body_frame(ev, a.body)),
                                  get_shape(plan, b, own.follower_shape), get_placement(get_body_frame(ev, b.body)),
                                  {-closed.depth, closed.point + half, closed.point - half, closed.normal});
  out = {margins.on_a.x, margins.on_a.y, margins.on_a.z, margins.on_b.x, margins.on_b.y, margins.on_b.z};
  // Likewise the law's corner where a pair parts so fast that it has no force any more. It stands in the last place of
  // a shape that is round, which has two margins at most; where neither is, no margin is known.
  const geometry::ShapeKind kind = get_numbers(plan, b, own.follower_shape).kind;
  const bool is_round = kind == geometry::ShapeKind::kSphere || kind == geometry::ShapeKind::kCapsule;
  out[is_round ? 5 : 2] = 1 + contact.damping * closed.rate;
  return out;
}

std::span<const ContactState> get_contact_pairs(const Plan& plan, const State& state, int contact) noexcept {
  const PlanContact& own = get_data(plan).contacts[at(contact)];
  return state.contacts.subspan(at(own.first_pair), at(own.pairs));
}

ContactTotals get_contact_totals(const Plan& plan, const State& state, int contact) noexcept {
  return read_totals(state.auxiliary, get_data(plan).contacts[at(contact)]);
}

namespace {

bool is_closed(const State& state, const PlanContact& contact) {
  const auto pairs = state.contacts.subspan(at(contact.first_pair), at(contact.pairs));
  return std::any_of(pairs.begin(), pairs.end(), [](const ContactState& pair) { return pair.closed != 0; });
}

// `base`, `follower`: bodies of the surfaces at this instant.
// `rigid_forces`, `rigid_frictions`: per pair, of rigid contacts.
ContactReading read_contact(const PlanData& plan, const State& state, double scale, const PlanContact& own,
                            const BodyFrame& base, const BodyFrame& follower, std::span<const double> rigid_forces,
                            std::span<const Vec3> rigid_frictions) {
  ContactReading out;
  Vec3 point{0, 0, 0};
  SlipMean slip;
  for (std::size_t i = at(own.first_pair); i < at(own.first_pair + own.pairs); ++i) {
    if (state.contacts[i].closed == 0) continue;
    const geometry::Distance distance = calc_pair_distance(plan, plan.contact_pairs[i], base, follower);
    PairForce f = calc_pair_force(own, distance, base, follower, scale);
    if (own.rigid) {
      f.normal = rigid_forces[i];
      f.force = f.normal * distance.normal;
      if (own.friction > 0) {
        f.friction = norm(rigid_frictions[i]);
        f.force += rigid_frictions[i];
      }
    }
    if (!out.closed) out.point = f.point;
    out.closed = true;
    out.depth = std::max(out.depth, f.depth);
    out.normal += f.normal;
    out.friction += f.friction;
    out.stiffness += f.stiffness;
    slip.add(f.normal, f.slip);
    out.force += f.force;
    point += f.normal * f.point;
  }
  if (out.normal > 0) out.point = (1 / out.normal) * point;
  out.slip = slip.get();
  return out;
}

}  // namespace

ContactReading calc_contact(const Instant& now, const Evaluation& ev, int contact) noexcept {
  const PlanContact& own = now.plan.contacts[at(contact)];
  const double scale = calc_scale(now.state.elements[at(own.element)], now.t);
  if (scale == 0 || !is_closed(now.state, own)) return {};
  return read_contact(now.plan, now.state, scale, own, get_body_frame(ev, now.plan.shapes[at(own.base)].body),
                      get_body_frame(ev, now.plan.shapes[at(own.follower)].body), ev.pair_forces, ev.pair_frictions);
}

ContactReading calc_contact(const Plan& owner, const State& state, int contact) noexcept {
  const PlanData& plan = get_data(owner);
  const PlanContact& own = plan.contacts[at(contact)];
  const double scale = calc_scale(state.elements[at(own.element)], plan.get_time(state.header->tick));
  if (scale == 0 || !is_closed(state, own)) return {};
  return read_contact(plan, state, scale, own, calc_body_frame(state, plan.shapes[at(own.base)].body),
                      calc_body_frame(state, plan.shapes[at(own.follower)].body), state.rigid_forces,
                      state.rigid_frictions);
}

geometry::GroupDistance calc_shape_distance(const Plan& owner, const State& state, int a, int b) noexcept {
  const PlanData& plan = get_data(owner);
  const PlanShapes &of_a = plan.shapes[at(a)], &of_b = plan.shapes[at(b)];
  return calc_group_distance(plan, of_a, calc_body_frame(state, of_a.body), of_b, calc_body_frame(state, of_b.body));
}

}  // namespace unlatch
