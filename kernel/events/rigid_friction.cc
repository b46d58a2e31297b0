#include "kernel/events/rigid_friction.h"

#include <algorithm>
#include <cmath>

#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/events/cone_impulses.h"
#include "kernel/events/guards.h"
#include "kernel/integration/integrator.h"

namespace unlatch {
namespace {

// The impulses of a pair, and of the rows that they are of.
struct Triple {
  double n, first, second;
};

// Λ of a pair's own three rows, with its yield.
struct OwnMatrix {
  double nn, n1, n2, a11, a12, a22;
};

OwnMatrix get_own(const RigidScratch& s, int r) {
  const std::size_t n = s.loads.size();
  const auto get = [&](int i, int k) { return s.matrix[at(r + i) * n + at(r + k)]; };
  const double yield = s.yield * get_pair_mobility(s, r);
  return {get(0, 0) + yield, get(0, 1), get(0, 2), get(1, 1) + yield, get(1, 2), get(2, 2) + yield};
}

// The impulse that gives a pair the rates −b: rows that nothing moves have none.
Triple solve_own(const OwnMatrix& m, const RigidRow* rows, const Triple& b) {
  constexpr double kNothing = 1e-12;  // of the free mobility
  const double d0 = m.nn, l1 = m.n1 / d0, l2 = m.n2 / d0;
  const double d1 = m.a11 - l1 * m.n1, c = m.a12 - l1 * m.n2;
  const bool first = d1 > kNothing * rows[1].free;
  const double l12 = first ? c / d1 : 0, d2 = m.a22 - l2 * m.n2 - l12 * c;
  const bool second = d2 > kNothing * rows[2].free;
  const double y0 = -b.n, y1 = -b.first - l1 * y0, y2 = -b.second - l2 * y0 - l12 * (first ? y1 : 0);
  Triple p{};
  p.second = second ? y2 / d2 : 0;
  p.first = first ? y1 / d1 - l12 * p.second : 0;
  p.n = y0 / d0 - l1 * p.first - l2 * p.second;
  return p;
}

// The impulse of a pair whose slip goes on: its direction is a fixed point, which is reached at once where mobility is
// the same in all directions. False if friction outgrows what the normal impulse decides.
bool slip_own(const OwnMatrix& m, double friction, const Triple& b, Triple& p) {
  constexpr int kMost = 200;
  constexpr double kLeast = 1e-6, kSame = 1e-15;
  const double half = 0.5 * (m.a11 - m.a22);
  const double most = 0.5 * (m.a11 + m.a22) + std::sqrt(half * half + m.a12 * m.a12);
  double x = b.first, y = b.second;
  if (!(x * x + y * y > 0)) x = 1;
  for (int i = 0; i < kMost; ++i) {
    const double size = std::sqrt(x * x + y * y);
    if (!(size > 0)) break;
    const double dx = x / size, dy = y / size;
    const double pivot = m.nn - friction * (m.n1 * dx + m.n2 * dy);
    if (!(pivot > kLeast * m.nn)) return false;
    const double normal = -b.n / pivot, side = friction * normal;
    const Triple next{normal, -side * dx, -side * dy};
    const bool same = std::abs(next.first - p.first) + std::abs(next.second - p.second) <= kSame * std::abs(side);
    p = next;
    if (same && i > 0) break;
    x = b.first + normal * m.n1 + side * (most * dx - m.a11 * dx - m.a12 * dy);
    y = b.second + normal * m.n2 + side * (most * dy - m.a12 * dx - m.a22 * dy);
  }
  return true;
}

double calc_rate_surplus(const RigidScratch& s, int r) {
  const double* row = &s.matrix[at(r) * s.loads.size()];
  double sum = -s.loads[at(r)];
  for (int c = 0; c < s.count; ++c) sum += row[c] * s.forces[at(c)];
  return sum;
}

// One pair, given the impulses of the others: `part` of the way to those that it would have. False if it is wedged.
// `change`: the greatest change of a rate so far.
bool solve_pair(RigidScratch& s, int r, Slips slips, double part, double& change) {
  const RigidRow* rows = &s.rows[at(r)];
  double* const p = &s.forces[at(r)];
  if (!(rows[0].friction > 0)) {
    const double own = s.matrix[at(r) * s.loads.size() + at(r)];
    const double next = own > 0 ? std::max(0.0, p[0] - calc_rate_surplus(s, r) / own) : 0;
    change = std::max(change, std::abs(next - p[0]) * rows[0].free);
    p[0] = next;
    return true;
  }
  if (!(s.matrix[at(r) * s.loads.size() + at(r)] > 0)) return true;
  const OwnMatrix m = get_own(s, r);
  const double yield = s.yield * get_pair_mobility(s, r);
  const Triple b{calc_rate_surplus(s, r) - ((m.nn - yield) * p[0] + m.n1 * p[1] + m.n2 * p[2]),
                 calc_rate_surplus(s, r + 1) - (m.n1 * p[0] + (m.a11 - yield) * p[1] + m.a12 * p[2]),
                 calc_rate_surplus(s, r + 2) - (m.n2 * p[0] + m.a12 * p[1] + (m.a22 - yield) * p[2])};
  Triple next{0, 0, 0};
  if (is_directed(s, r, slips)) {
    constexpr double kLeast = 1e-6;
    const double mu = rows[0].friction, *slide = rows[0].slide;
    const double pivot = m.nn - mu * (m.n1 * slide[0] + m.n2 * slide[1]);
    if (!(pivot > kLeast * m.nn)) return false;
    next.n = std::max(0.0, -b.n / pivot);
    next.first = -mu * next.n * slide[0];
    next.second = -mu * next.n * slide[1];
  } else if (b.n < 0) {
    next = solve_own(m, rows, b);
    const double most = rows[0].friction * next.n;
    const bool sticks = next.n >= 0 && next.first * next.first + next.second * next.second <= most * most;
    if (!sticks && !slip_own(m, rows[0].friction, b, next)) return false;
  }
  const Triple was{p[0], p[1], p[2]};
  p[0] += part * (next.n - was.n);
  p[1] += part * (next.first - was.first);
  p[2] += part * (next.second - was.second);
  change = std::max({change, std::abs(next.n - was.n) * rows[0].free, std::abs(next.first - was.first) * rows[1].free,
                     std::abs(next.second - was.second) * rows[2].free});
  return true;
}

// All pairs, one after the other, until nothing changes: true, or not within `most` sweeps, or, and `wedged` is that, a
// pair is by itself.
bool sweep_pairs(RigidScratch& s, Slips slips, int most, double part, double fastest, int& wedged) {
  constexpr double kSame = 1e-14;  // of the fastest rate: rounding
  for (int i = 0; i < most; ++i) {
    double change = 0;
    for (int r = 0; r < s.count; ++r) {
      if (s.rows[at(r)].tangent != 0 || solve_pair(s, r, slips, part, change)) continue;
      wedged = r;
      return false;
    }
    if (change <= kSame * fastest) return true;
  }
  return false;
}

double find_fastest(const RigidScratch& s) {
  double fastest = 0;
  for (int r = 0; r < s.count; ++r) fastest = std::max(fastest, std::abs(s.loads[at(r)]));
  return fastest;
}

// The impulses of all pairs that have the present yield, to a part of the fastest rate: from those that there are, then
// from none. False if they are not found.
bool solve_cones(Slips slips, double residual, double fastest, RigidScratch& s) {
  constexpr int kSweeps = 10, kStarts = 3;
  constexpr double kHalf = 0.5;
  for (int i = 0; i < 2 * kStarts; ++i) {
    if (i == kStarts) std::fill_n(s.forces.begin(), s.count, 0.0);
    int wedged = kNone;
    (void)sweep_pairs(s, slips, kSweeps, i % kStarts == 0 ? 1 : kHalf, fastest, wedged);
    if (improve_cone_impulses(fastest, slips, s) <= residual) return true;
  }
  return false;
}

// The impulses of all pairs, as cone_impulses.h says. False, with the contact, if they are not found.
bool solve_all(const PlanData& plan, Evaluation& ev) {
  constexpr int kSweeps = 200;
  constexpr double kYields[] = {0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3};
  RigidScratch& s = ev.rigid;
  const double fastest = find_fastest(s);
  int wedged = kNone;
  s.yield = 0;
  if (sweep_pairs(s, Slips::kFree, kSweeps, 1, fastest, wedged)) return true;
  for (const double yield : kYields) {
    s.yield = yield;
    if (solve_cones(Slips::kFree, kImpulseResidual, fastest, s)) return true;
  }
  s.wedged = wedged != kNone;
  s.failed = plan.contact_pairs[at(s.rows[at(std::max(wedged, 0))].pair)].contact;
  return false;
}

// What the impulses add to the kinetic energy, J, and the size of its parts.
double calc_work(const RigidScratch& s, double& size) {
  const std::size_t n = s.loads.size();
  double work = 0;
  for (int r = 0; r < s.count; ++r) {
    double after = s.rows[at(r)].rate;
    for (int c = 0; c < s.count; ++c) after += s.matrix[at(r) * n + at(c)] * s.forces[at(c)];
    const double part = 0.5 * s.forces[at(r)] * (s.rows[at(r)].rate + after);
    work += part;
    size += std::abs(part);
  }
  return work;
}

void set_mode(Run& run, std::size_t pair, std::int64_t mode, const Vec3& direction) {
  run.state().contacts[pair] = {mode, 0};
  run.state().rigid_slips[pair] = direction;
}

// m/s: slower than this a slip has just begun, or its end was located.
constexpr double kJust = 1e-7;

// Acceleration of the slip along row r, m/s².
double calc_slip_rate(const Evaluation& ev, int r) {
  const RigidRow& row = ev.rigid.rows[at(r)];
  const auto get = [&](int body) {
    return body == kGround ? Spatial{{0, 0, 0}, {0, 0, 0}} : ev.get_acceleration(body);
  };
  return row.bias + apply_rigid_row(row, get(row.base), get(row.follower));
}

int find_row(const Evaluation& ev, std::size_t pair) {
  for (int r = 0; r < ev.rigid.count; ++r)
    if (at(ev.rigid.rows[at(r)].pair) == pair) return r;
  return kNone;
}

}  // namespace

bool find_friction_impulses(const PlanData& plan, std::span<const double> restitutions, Evaluation& ev) noexcept {
  constexpr double kRounding = 1e-13;
  constexpr int kHalvings = 40;
  RigidScratch& s = ev.rigid;
  const auto solve = [&](double part) {
    for (int r = 0; r < s.count; ++r) s.loads[at(r)] = -(1 + part * restitutions[at(r)]) * s.rows[at(r)].rate;
    std::fill_n(s.forces.begin(), s.count, 0.0);
    return solve_all(plan, ev);
  };
  const auto grows = [&] {
    double size = 0;
    const double work = calc_work(s, size);
    return work > kRounding * size;
  };
  if (!solve(1)) return false;
  if (!grows()) return true;
  double low = 0, high = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    if (!solve(middle)) return false;
    (grows() ? high : low) = middle;
  }
  return solve(low);
}

bool would_stick(const Run& run, std::size_t pair, double largest_force) noexcept {
  constexpr double kNothing = 1e-9;  // of accelerations that is rounding
  if (run.state().contacts[pair].closed != kPairCreeps) return false;
  const Evaluation& ev = run.ev();
  const int r = find_row(ev, pair);
  if (r == kNone) return false;
  if (ev.rigid.rows[at(r)].slip > kJust) return false;
  return calc_slip_rate(ev, r + 1) < -kNothing * ev.rigid.rows[at(r + 1)].free * largest_force;
}

bool would_turn(const Run& run, std::size_t pair, Vec3& direction) noexcept {
  constexpr double kNothing = 1e-6, kSame = 1e-9;  // of what friction alone would do; rad
  if (run.state().contacts[pair].closed != kPairCreeps) return false;
  const Evaluation& ev = run.ev();
  const int r = find_row(ev, pair);
  if (r == kNone) return false;
  const RigidRow* rows = &ev.rigid.rows[at(r)];
  if (rows[0].slip > kJust) return false;
  const double brake = rows[0].friction * std::abs(ev.pair_forces[pair]) * std::max(rows[1].free, rows[2].free);
  double first = calc_slip_rate(ev, r + 1);
  const double second = calc_slip_rate(ev, r + 2);
  if (!(std::sqrt(first * first + second * second) > kNothing * brake)) return false;
  first += brake;  // which makes the direction a fixed point that is reached at once by a block
  const double size = std::sqrt(first * first + second * second);
  if (!(std::abs(second) > kSame * size)) return false;
  direction = (1 / size) * (first * rows[1].along + second * rows[2].along);
  return true;
}

void turn_slip(Run& run, std::size_t pair, const Vec3& direction) noexcept {
  set_mode(run, pair, kPairCreeps, direction);
}

bool is_undecided(const Run& run, std::size_t pair) noexcept {
  if (run.state().rigid_slips.empty() || run.state().contacts[pair].closed != kPairClosed) return false;
  if (!(run.plan.contacts[at(run.plan.contact_pairs[pair].contact)].friction > 0)) return false;
  const Vec3& reference = run.state().rigid_slips[pair];
  return !(dot(reference, reference) > 0);
}

bool is_friction_changing(const Run& run, std::size_t pair) noexcept {
  constexpr double kSlow = 1e-5, kNear = 1e-4;  // m/s that a located slip has at most; of the cone
  const Evaluation& ev = run.ev();
  const PlanContact& contact = run.plan.contacts[at(run.plan.contact_pairs[pair].contact)];
  if (!(contact.friction > 0)) return false;
  const bool sticks = run.state().contacts[pair].closed == kPairSticks;
  const double near = sticks ? kNear * contact.friction * std::abs(ev.pair_forces[pair]) : kSlow;
  return ev.pair_slides[pair] >= -near;
}

bool change_friction(Run& run, std::size_t pair) noexcept {
  const Evaluation& ev = run.ev();
  const int r = find_row(ev, pair);
  if (r == kNone) return false;
  const RigidRow* rows = &ev.rigid.rows[at(r)];
  const double* forces = &ev.rigid.forces[at(r)];
  if (is_undecided(run, pair)) {
    set_friction(run, r, rows[1].rate, rows[2].rate, kRigidRest);
    return false;
  }
  if (rows[0].mode != RigidMode::kSticks) {
    for (int i = 0; i < ev.rigid.count; ++i) {
      const RigidRow& row = ev.rigid.rows[at(i)];
      const bool ends = row.mode == RigidMode::kCreeps && row.slip <= kJust;
      if (row.tangent == 0 && (i == r || ends))
        set_mode(run, at(row.pair), kPairSticks, ev.rigid.rows[at(i + 1)].along);
    }
    return rows[0].slip > kRigidRest;
  }
  const double size = std::sqrt(forces[1] * forces[1] + forces[2] * forces[2]);
  if (size > 0) set_mode(run, pair, kPairCreeps, -(1 / size) * (forces[1] * rows[1].along + forces[2] * rows[2].along));
  return false;
}

void rest_slow_pairs(Run& run) noexcept {
  const Evaluation& ev = run.ev();
  for (int r = 0; r < ev.rigid.count; ++r) {
    const RigidRow* rows = &ev.rigid.rows[at(r)];
    if (rows[0].tangent != 0 || rows[0].mode == RigidMode::kSmooth || rows[0].mode == RigidMode::kSticks) continue;
    const bool back = rows[0].mode == RigidMode::kCreeps && rows[1].rate <= kRigidRest;
    if (back || rows[0].slip <= kJust) set_mode(run, at(rows[0].pair), kPairSticks, rows[1].along);
  }
}

bool find_friction_modes(Run& run) noexcept {
  constexpr double kYields[] = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5}, kPart = 1e-8, kEdge = 100, kNothing = 1e-9;
  RigidScratch& s = run.ev().rigid;
  const double fastest = find_fastest(s);
  std::fill_n(s.forces.begin(), s.count, 0.0);
  bool found = false;
  for (const double yield : kYields) {
    s.yield = yield;
    found = solve_cones(Slips::kDirected, kPart, fastest, s);
    if (found) break;
  }
  if (!found) return false;
  double largest = 0;
  for (int r = 0; r < s.count; ++r) largest = std::max(largest, std::abs(s.forces[at(r)]));
  for (int r = 0; r < s.count; ++r) {
    const RigidRow* rows = &s.rows[at(r)];
    const double* const p = &s.forces[at(r)];
    if (rows[0].tangent != 0) continue;
    const std::size_t pair = at(rows[0].pair);
    if (!(p[0] > kNothing * largest)) {
      run.state().contacts[pair].closed = kPairLeaves;
    } else if (rows[0].mode == RigidMode::kSticks) {
      const double side = std::sqrt(p[1] * p[1] + p[2] * p[2]);
      if (side < rows[0].friction * p[0] * (1 - kEdge * s.yield)) continue;
      set_mode(run, pair, kPairCreeps, -(1 / side) * (p[1] * rows[1].along + p[2] * rows[2].along));
    }
  }
  return true;
}

void set_friction(Run& run, int row, double first, double second, double rest) noexcept {
  const RigidRow* rows = &run.ev().rigid.rows[at(row)];
  const double slip = std::sqrt(first * first + second * second);
  const std::size_t pair = at(rows[0].pair);
  if (slip > rest)
    set_mode(run, pair, kPairClosed, (1 / slip) * (first * rows[1].along + second * rows[2].along));
  else
    set_mode(run, pair, kPairSticks, rows[1].along);
}

bool begin_slips(Run& run, double now) noexcept {
  constexpr double kFaster = 1.5;  // so that a slip does not go to and fro between having a direction and not
  Evaluation& ev = run.ev();
  bool turned = false;
  for (int r = 0; r < ev.rigid.count; ++r) {
    RigidRow* rows = &ev.rigid.rows[at(r)];
    if (rows[0].tangent != 0 || rows[0].mode == RigidMode::kSmooth) continue;
    const std::size_t pair = at(rows[0].pair);
    if (run.state().contacts[pair].closed == kPairLeaves) continue;
    const double least = calc_least_slip(run.plan, calc_slip_braking(ev, rows));
    const Vec3 slide = rows[0].slide[0] * rows[1].along + rows[0].slide[1] * rows[2].along;
    if (rows[0].mode == RigidMode::kSticks) {
      run.state().rigid_slips[pair] = rows[1].along;
    } else if (rows[0].mode == RigidMode::kSlips) {
      if (rows[0].slip < least) rows[0].mode = RigidMode::kCreeps;
      set_mode(run, pair, rows[0].slip < least ? kPairCreeps : kPairClosed, slide);
    } else if (rows[0].slip > kFaster * least && rows[1].rate > 0) {
      set_mode(run, pair, kPairClosed,
               (1 / rows[0].slip) * (rows[1].rate * rows[1].along + rows[2].rate * rows[2].along));
      turned = true;
    } else {
      run.state().rigid_slips[pair] = rows[1].along;
    }
  }
  if (!turned) return true;
  const Instant instant = run.get_instant(now);
  if (!run.check(evaluate(instant, Changed::kCommands, ev))) return false;
  update_guards(instant, ev, run.search().stack);
  return true;
}

}  // namespace unlatch
