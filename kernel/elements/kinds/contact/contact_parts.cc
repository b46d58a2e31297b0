#include "kernel/elements/kinds/contact/contact_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/elements/kinds/load.h"
#include "unlatch/elementary.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch {
namespace {

// Largest parts, in 1 / rate: of a blow, of a vibration that is small beside the depth, and of all closed pairs
// together, whose rates add up where they hold one body (RK4 is stable to 2.8).
constexpr double kBlow = 0.12, kSettled = 1.0, kStable = 2.0;
// Largest part in which a slip may change, of the time in which it changes by as much as may be left of it.
constexpr double kSlip = 0.75;

// An implicit part errs by a part of (ω h)³ of the vibration, of which so much of the depth is allowed, and by the
// third power of the change of its slip, which may be so much of what an explicit part's may.
constexpr double kImplicitVibration = 1e-5, kImplicitChange = 0.25;
// An implicit part costs as much as so many explicit ones, and so does one of order eight.
constexpr int kImplicitCost = 2, kEighthCost = 2;

// Largest part of order eight of a blow, in 1 / rate. It errs by a part of (ω h)⁸ of the vibration.
constexpr double kEighthBlow = 0.3;

// Rates of a pair, 1/s: of the vibration, of its damping, of the slip's decay at the least slip of the part; and the
// parts per second that it needs, explicit ones, those of order eight and implicit ones.
struct PairRates {
  double omega = 0, damping = 0, slip = 0, parts = 0, eighth_parts = 0, implicit_parts = 0;
};

// Acceleration of a carrier, of its origin, W.
Spatial get_acceleration(const PlanShapes& shapes, const Evaluation& ev) {
  if (shapes.body == kGround) return {{0, 0, 0}, {0, 0, 0}};
  return ev.get_acceleration(shapes.body);
}

// The longest parts, in 1 / rate.
struct Longest {
  double explicit_part, eighth_part, implicit_part;
};
constexpr Longest kLongestOfBlow{kBlow, kEighthBlow, kBlow};

// ω h ≤ ∛(depth / vibration · kImplicitVibration).
double calc_implicit_part(double vibration, double depth) {
  constexpr double kMost = 1e3;
  const double cube = kImplicitVibration * depth / vibration;
  return cube < kMost * kMost * kMost ? elementary::exp(elementary::log(std::max(cube, 1e-300)) / 3) : kMost;
}

// RK4's error of a blow is some (ω h)⁴/120 of the vibration, which may be as large as the depth while shapes meet and
// part, and is small beside it once they rest on each other or slide.
Longest calc_longest(const PlanData& plan, std::size_t i, const PairRates& rates, const ClosedPair& pair,
                     const BodyFrame& base, const BodyFrame& follower, const Evaluation& ev) {
  if (!plan.rigid || !(rates.omega > 0)) return kLongestOfBlow;  // accelerations of markers are not known yet
  const PlanContact& contact = plan.contacts[at(plan.contact_pairs[i].contact)];
  const double second = calc_depth_acceleration(
      plan, plan.contact_pairs[i], {base, get_acceleration(plan.shapes[at(contact.base)], ev)},
      {follower, get_acceleration(plan.shapes[at(contact.follower)], ev)}, pair.rate, plan.options.dt);
  const double fast = pair.rate / rates.omega, bent = second / (rates.omega * rates.omega);
  const double vibration = std::sqrt(fast * fast + bent * bent),
               depth = std::sqrt(pair.depth * pair.depth + fast * fast);
  const double implicit_part = calc_implicit_part(vibration, depth);
  constexpr double kLeast = (kBlow / kSettled) * (kBlow / kSettled) * (kBlow / kSettled) * (kBlow / kSettled);
  if (!(vibration > kLeast * depth)) return {kSettled, kSettled, implicit_part};
  const double fourth_root = std::max(1.0, std::sqrt(std::sqrt(depth / vibration)));
  return {kBlow * fourth_root, std::min(kSettled, kEighthBlow * std::sqrt(fourth_root)), implicit_part};
}

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

// Acceleration of the follower's material at a pair, seen from the base's, W, m/s². 0 where accelerations of markers
// are not known before the readings.
Vec3 calc_acceleration(const PlanData& plan, const ClosedPair& pair, const PlanShapes& base, const BodyFrame& at_base,
                       const PlanShapes& follower, const BodyFrame& at_follower, const Evaluation& ev) {
  if (!plan.rigid) return {0, 0, 0};
  const auto calc = [&](const PlanShapes& shapes, const BodyFrame& body) {
    const Spatial a = get_acceleration(shapes, ev);
    return a.lin + cross(a.ang, pair.point - body.p);
  };
  return calc(follower, at_follower) - calc(base, at_base);
}

// The change of the slip within the longest part, m/s, whichever way it goes: as large as the slip that may be left at
// the part's end, or as v_s. So it resolves the law's bend at v_s, through which a slip reverses, before it gets there.
double calc_slip_change(double slip, double slip_speed) {
  return slip > slip_speed ? 0.5 * (slip + slip_speed * slip_speed / slip) : slip_speed;
}

// `i`: number of the pair.
PairRates calc_rates(const PlanData& plan, std::size_t i, const PlanContact& contact, double scale,
                     const Evaluation& ev) {
  const ClosedPair& pair = ev.closed_pairs[i];
  const PlanShapes &a = plan.shapes[at(contact.base)], &b = plan.shapes[at(contact.follower)];
  const BodyFrame base = get_body_frame(ev, a.body), follower = get_body_frame(ev, b.body);
  const auto calc = [&](const Vec3& u) {
    return calc_mobility(a, base, pair.point, u) + calc_mobility(b, follower, pair.point, u);
  };
  const double along_normal = calc(pair.normal);
  PairRates out;
  if (!(along_normal > 0)) return out;
  const Vec3 relative = calc_acceleration(plan, pair, a, base, b, follower, ev);
  // the speed at which it closes within the step: the present one, and what it gains in the step
  const double gained = -dot(pair.normal, relative);
  const double approach = std::abs(pair.rate) + std::max(0.0, gained) * plan.options.dt;
  const double energy = scale * calc_stored(contact, pair.depth) + 0.5 * approach * approach / along_normal;
  if (!(energy > 0)) return out;
  const Blow blow = calc_blow(contact, energy, scale);
  out.omega = std::sqrt(blow.stiffness * along_normal);
  out.damping = blow.force * contact.damping * along_normal;
  if (contact.friction > 0) {
    const Vec3 helper = std::abs(pair.normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 across = cross(pair.normal, helper), t = (1 / norm(across)) * across;
    const double along = std::max(calc(t), calc(cross(pair.normal, t)));
    const double change = calc_slip_change(norm(pair.slip), contact.slip_speed);
    const double braking = contact.friction * blow.force * along;  // m/s²
    const double gaining = norm(relative + gained * pair.normal);
    out.slip = braking / change;
    out.parts = out.eighth_parts = std::max(braking, gaining) / (kSlip * change);
    out.implicit_parts = gaining / (kImplicitChange * change);
  }
  const double fast = std::max(out.omega, out.damping);
  const bool needs_parts = fast * plan.options.dt > kBlow;
  const Longest longest = needs_parts ? calc_longest(plan, i, out, pair, base, follower, ev) : kLongestOfBlow;
  out.parts = std::max(fast / longest.explicit_part, out.parts);
  out.eighth_parts = std::max(fast / longest.eighth_part, out.eighth_parts);
  out.implicit_parts = std::max(fast / longest.implicit_part, out.implicit_parts);
  return out;
}

// The least number of parts of `rest` seconds that are not longer than 1 / needed, of which a step holds at most so
// many as it may have.
std::int32_t count_parts(double needed, double rest, double dt) {
  const double parts = needed * rest, most = rest / dt * kMaxAutomaticSubsteps;
  if (!(parts > 1) || !(most > 2)) return 1;
  if (!(parts < most)) return static_cast<std::int32_t>(std::min<double>(most, kMaxAutomaticSubsteps));
  const auto whole = static_cast<std::int32_t>(parts);
  return whole < parts && whole + 1 <= most ? whole + 1 : whole;
}

// Parts of the step itself, if the friction of rigid contacts alone asks for them: the least power of two that is as
// many as needed.
ContactParts cut_for_slips(double needed) {
  constexpr std::uint32_t kMost = kMaxAutomaticSubsteps;
  const std::uint32_t parts = needed < kMost ? std::bit_ceil(static_cast<std::uint32_t>(std::ceil(needed))) : kMost;
  return {static_cast<std::int32_t>(parts), Contacts::kExplicit, false};
}

// Parts per second that the friction of rigid contacts needs: of a slip that may turn, so many that it keeps half of
// its speed in each; of one that begins, that it does not outgrow the speed at which it gets a direction of its own.
double calc_slip_parts(const PlanData& plan, const Evaluation& ev) {
  double most = 0;
  for (std::int32_t r = 0; r < ev.rigid.count; ++r) {
    const RigidRow& row = ev.rigid.rows[at(r)];
    if (row.mode != RigidMode::kSlips && row.mode != RigidMode::kCreeps) continue;
    const double change = calc_slip_braking(ev, &row);
    const double least = calc_least_slip(plan, change);
    if (row.mode == RigidMode::kSlips && row.slip > 0) most = std::max(most, 2 * change / row.slip);
    if (row.mode == RigidMode::kCreeps && least > 0) most = std::max(most, calc_slip_acceleration(ev, &row) / least);
  }
  return most;
}

}  // namespace

bool may_be_implicit(const PlanData& plan) noexcept {
  return has_automatic_parts(plan.contact_substeps) && !plan.contacts.empty() && plan.rigid && plan.compliant.empty() &&
         plan.rigid_pairs == 0 && plan.bodies.size() <= kMostImplicitBodies &&
         plan.initial_auxiliary.size() <= kMostImplicitAuxiliary;
}

ContactParts choose_contact_parts(const PlanData& plan, const State& state, double t, double rest,
                                  const Evaluation& ev) noexcept {
  const double slips = plan.rigid_pairs > 0 ? calc_slip_parts(plan, ev) : 0;
  if (slips > 0 && !has_automatic_parts(plan.contact_substeps))
    return {plan.contact_substeps, Contacts::kExplicit, false};
  double most = slips, eighth_most = 0, implicit_most = 0, square = 0, damping = 0, slip = 0;
  std::size_t closed = 0;
  for (const PlanContact& contact : plan.contacts) {
    if (contact.rigid) continue;  // smooth while it is closed, but for its friction
    for (std::size_t i = at(contact.first_pair); i < at(contact.first_pair + contact.pairs); ++i) {
      if (state.contacts[i].closed == 0) continue;
      if (!has_automatic_parts(plan.contact_substeps)) return {plan.contact_substeps, Contacts::kExplicit, false};
      const double scale = calc_scale(state.elements[at(contact.element)], t);
      if (!(scale > 0)) continue;
      const PairRates own = calc_rates(plan, i, contact, scale, ev);
      ++closed;
      most = std::max(most, own.parts);
      eighth_most = std::max(eighth_most, own.eighth_parts);
      implicit_most = std::max(implicit_most, own.implicit_parts);
      square += own.omega * own.omega;
      damping += own.damping;
      slip += own.slip;
    }
  }
  const double stable = std::max(std::sqrt(square), std::max(damping, slip)) / kStable;
  const double refined = get_contact_refinement(plan.contact_substeps), dt = plan.options.dt;
  if (closed == 0) return cut_for_slips(refined * dt * slips);
  const std::int32_t parts = count_parts(refined * std::max(most, stable), rest, dt);
  if (!may_be_implicit(plan)) return {parts, Contacts::kExplicit, true};
  const std::int32_t eighth_parts = count_parts(refined * std::max(eighth_most, stable), rest, dt),
                     implicit_parts = count_parts(refined * implicit_most, rest, dt);
  const bool is_unstable = dt * stable > kMaxAutomaticSubsteps;  // with explicit parts
  const bool saves = kImplicitCost * implicit_parts <= parts && implicit_parts <= eighth_parts;
  if (closed <= kMostImplicitPairs && (is_unstable || saves)) return {implicit_parts, Contacts::kImplicit, true};
  if (kEighthCost * eighth_parts <= parts) return {eighth_parts, Contacts::kEighthOrder, true};
  return {parts, Contacts::kExplicit, true};
}

}  // namespace unlatch
