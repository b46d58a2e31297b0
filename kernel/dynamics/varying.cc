#include "kernel/dynamics/varying.h"

#include "kernel/elements/gravity.h"
#include "kernel/math/table.h"

namespace unlatch {
namespace {

// Between two knots, or at the nearer end. `slope`: part of their difference per unit of the law's variable.
struct Interval {
  const MassKnot *low, *high;
  double part, slope;
};

Interval find_interval(std::span<const MassKnot> knots, double s) {
  if (s < knots.front().at || knots.size() == 1) return {&knots.front(), &knots.front(), 0, 0};
  if (s >= knots.back().at) return {&knots.back(), &knots.back(), 0, 0};
  const MassKnot* low = &knots[find_piece(knots.size(), s, [&](std::size_t i) { return knots[i].at; })];
  const MassKnot* high = low + 1;
  const double width = high->at - low->at;
  return {low, high, (s - low->at) / width, 1 / width};
}

Sym3 add(const Sym3& a, double k, const Sym3& b) {
  return {a.xx + k * b.xx, a.yy + k * b.yy, a.zz + k * b.zz, a.xy + k * b.xy, a.xz + k * b.xz, a.yz + k * b.yz};
}

// Distance from a tick within which a knot is on it, s: times of ticks are rounded, and a step is whole nanoseconds.
constexpr double kOnTick = 4e-10;
// Part of the range of the knots of what is burnt within which it is at one: a sub-step that is to end there does
// (kernel/events/event_search.cc).
constexpr double kAtKnot = 1e-9;

// Where the slopes of the law are those of `side`. Of what is burnt, stages have those of the beginning of their
// sub-step, since what they burn until its end may be beyond the knot at which it ends.
double get_place_of_slope(const PlanVarying& law, std::span<const MassKnot> knots, double t, KnotSide side,
                          const Auxiliary& auxiliary, std::size_t i) {
  if (!law.by_burnt) return side == KnotSide::kAfter ? t + kOnTick : t - kOnTick;
  const double burnt = side == KnotSide::kAfter ? auxiliary.now[i] : auxiliary.start[i];
  return burnt + kAtKnot * (knots.back().at - knots.front().at);
}

}  // namespace

void update_masses(const PlanData& plan, double t, KnotSide side, Evaluation& ev) noexcept {
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const PlanVarying& law = plan.varying[i];
    VaryingBody& body = ev.varying[i];
    const std::span<const MassKnot> knots = std::span(plan.mass_knots).subspan(at(law.first), at(law.count));
    const Interval p = find_interval(knots, law.by_burnt ? ev.auxiliary.now[i] : t);
    const Sym3 change = add(p.high->inertia, -1, p.low->inertia);
    body.mass = p.low->mass + p.part * (p.high->mass - p.low->mass);
    body.centre_B = p.low->centre + p.part * (p.high->centre - p.low->centre);
    body.inertia_B = add(p.low->inertia, p.part, change);
    const Interval s = find_interval(knots, get_place_of_slope(law, knots, t, side, ev.auxiliary, i));
    body.mass_slope = s.slope * (s.high->mass - s.low->mass);
    body.centre_slope_B = s.slope * (s.high->centre - s.low->centre);
    body.inertia_slope_B = add({0, 0, 0, 0, 0, 0}, s.slope, add(s.high->inertia, -1, s.low->inertia));
  }
}

void update_varying_kinematics(const PlanData& plan, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const Place place = ev.places[at(plan.varying[i].body)];
    const Mat3 R = read(blocks, place, &BodyLane::R);
    ev.varying[i].centre = R * ev.varying[i].centre_B;
    write(blocks, place, &SharedLane::inertia, rotate(R, ev.varying[i].inertia_B));
  }
}

void add_varying_forces(const PlanData& plan, const Vec3& origin, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const PlanVarying& law = plan.varying[i];
    const VaryingBody& body = ev.varying[i];
    const Place place = ev.places[at(law.body)];
    const Vec3 w = read(blocks, place, &BodyLane::w_W), p = read(blocks, place, &BodyLane::motion).p;
    const Vec3 force = body.mass * (calc_free_fall(plan, origin, p + body.centre) - cross(w, cross(w, body.centre)));
    Vec3 torque = cross(body.centre, force);
    if (law.jet_damping) {
      const Mat3 R = read(blocks, place, &BodyLane::R);
      const double rate = law.by_burnt ? ev.auxiliary.rate[i] : 1;
      const Vec3 r = R * law.exit - body.centre;
      torque += rate * (body.mass_slope * cross(r, cross(w, r)) - rotate(R, body.inertia_slope_B) * w);
    }
    add(blocks, place, &SharedLane::force, {force, torque});
  }
}

void add_varying_blocks(const PlanData& plan, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const Place place = ev.places[at(plan.varying[i].body)];
    const double m = ev.varying[i].mass;
    const Vec3 c = ev.varying[i].centre;
    // M = m, H = −m c̃ by columns, I += −m c̃ c̃
    add(blocks, place, &SubtreeLane::A,
        {{m, m, m, 0, 0, 0},
         {{0, -m * c.z, m * c.y}, {m * c.z, 0, -m * c.x}, {-m * c.y, m * c.x, 0}},
         {m * (c.y * c.y + c.z * c.z), m * (c.z * c.z + c.x * c.x), m * (c.x * c.x + c.y * c.y), -m * c.x * c.y,
          -m * c.x * c.z, -m * c.y * c.z}});
  }
}

}  // namespace unlatch
