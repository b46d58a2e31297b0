#include "kernel/integration/rigid_rows.h"

#include <algorithm>
#include <cmath>

#include "kernel/dispatch/kernels.h"
#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/push.h"
#include "kernel/solver/loops/loop_rows.h"

namespace unlatch {
namespace {

constexpr Spatial kNoForce{{0, 0, 0}, {0, 0, 0}};

Spatial get_acceleration(const Evaluation& ev, int body) {
  return body == kGround ? kNoForce : ev.get_acceleration(body);
}

double apply_row(const RigidRow& row, const Evaluation& ev) {
  return apply_rigid_row(row, get_acceleration(ev, row.base), get_acceleration(ev, row.follower));
}

void push_row(Evaluation& ev, const RigidRow& row, double size) {
  push_apart(ev, row.base, row.follower, {size * row.on_base, size * row.on_follower});
}

void clear_forces(const PlanData& plan, Evaluation& ev) {
  for (const Place& place : plan.places) write(ev.blocks.data(), place, &SharedLane::force, kNoForce);
}
void keep_forces(const PlanData& plan, Evaluation& ev) {
  for (std::size_t b = 0; b < plan.places.size(); ++b)
    ev.rigid.body_forces[b] = read(ev.blocks.data(), plan.places[b], &SharedLane::force);
}
void restore_forces(const PlanData& plan, Evaluation& ev) {
  for (std::size_t b = 0; b < plan.places.size(); ++b)
    write(ev.blocks.data(), plan.places[b], &SharedLane::force, ev.rigid.body_forces[b]);
}

double calc_target(const RigidRow& row, RigidTarget target) {
  switch (target) {
    case RigidTarget::kAcceleration:
      return -row.bias;
    case RigidTarget::kPosition:
      return -row.gap;
    case RigidTarget::kVelocity:
      return -row.rate;
  }
  return 0;
}

// LDLᵀ of the rows of `set` in their order: `independent` of them, the rank, get a pivot, of those in `may`; each row
// of the factor has the entries of L for these.
int factor(RigidSet set, RigidSet may, Evaluation& ev) {
  RigidScratch& s = ev.rigid;
  const std::size_t n = s.loads.size();
  int rank = 0;
  for (int r = 0; r < s.count; ++r) {
    if (!has_rigid(set, r)) continue;
    double* row = &s.factor[at(r) * n];
    double pivot = s.matrix[at(r) * n + at(r)], lost = 0;
    const double own = pivot;
    for (int k = 0; k < rank; ++k) {
      const int p = s.independent[at(k)];
      double entry = s.matrix[at(r) * n + at(p)];
      for (int m = 0; m < k; ++m) entry -= row[m] * s.pivots[at(m)] * s.factor[at(p) * n + at(m)];
      row[k] = entry / s.pivots[at(k)];
      pivot -= entry * row[k];
      lost += row[k] * row[k] * s.matrix[at(p) * n + at(p)];
    }
    if (!has_rigid(may, r) || !is_independent({own, lost, s.rows[at(r)].free}, pivot)) continue;
    s.independent[at(rank)] = r;
    s.pivots[at(rank)] = pivot;
    row[rank++] = 1;
    for (int later = 0; later < r; ++later) s.factor[at(later) * n + at(rank - 1)] = 0;
  }
  for (int k = rank; k < s.count; ++k) s.independent[at(k)] = kNone;
  return rank;
}

int count_independent(const Evaluation& ev) {
  int rank = 0;
  for (int k = 0; k < ev.rigid.count; ++k) rank += ev.rigid.independent[at(k)] != kNone ? 1 : 0;
  return rank;
}

// What a row of the latest set gets beyond its load.
double calc_surplus(const Evaluation& ev, int r) {
  const RigidScratch& s = ev.rigid;
  const std::size_t n = s.loads.size();
  double sum = -s.loads[at(r)];
  for (int c = 0; c < s.count; ++c) sum += s.matrix[at(r) * n + at(c)] * s.forces[at(c)];
  return sum;
}

bool has_slip_rows(const Evaluation& ev) {
  for (int r = 0; r < ev.rigid.count; ++r)
    if (ev.rigid.rows[at(r)].tangent != 0) return true;
  return false;
}

// The rows that hold: those along normals, and the two of each pair that sticks.
RigidSet get_holding_rows(const Evaluation& ev) {
  RigidSet set = 0;
  for (int r = 0; r < ev.rigid.count; ++r) {
    const RigidRow& row = ev.rigid.rows[at(r)];
    const RigidRow& normal = ev.rigid.rows[at(r - row.tangent)];
    if (row.tangent == 0 || normal.mode == RigidMode::kSticks) set |= RigidSet{1} << r;
  }
  return set;
}

bool slides(const RigidRow& row) { return row.mode == RigidMode::kSlips || row.mode == RigidMode::kCreeps; }

// What the force along row c does to row r, with the friction that it brings about.
double calc_sliding_entry(const RigidScratch& s, int r, int c) {
  const double* row = &s.matrix[at(r) * s.loads.size()];
  const RigidRow& of = s.rows[at(c)];
  if (of.tangent != 0 || !slides(of)) return row[c];
  return row[c] - of.friction * (of.slide[0] * row[c + 1] + of.slide[1] * row[c + 2]);
}

// The forces of the rows that hold, in s.forces, and the friction of those that slide; independent rows are taken from
// `may`. kNone, or the row at which the pivots fall to nothing.
int solve_sliding_rows(RigidSet may, Evaluation& ev) {
  constexpr double kLeastPivot = 1e-6;  // of that without friction
  RigidScratch& s = ev.rigid;
  const std::size_t n = s.loads.size();
  const RigidSet set = get_holding_rows(ev);
  const int rank = factor(set, may, ev);
  const auto L = [&](int r, int k) -> double { return s.factor[at(r) * n + at(k)]; };
  const auto M = [&](int k, int m) -> double& { return s.gram[at(k) * n + at(m)]; };
  double* const x = s.middle.data();
  for (int k = 0; k < rank; ++k) {
    const int r = s.independent[at(k)];
    x[k] = s.loads[at(r)];
    for (int m = 0; m < rank; ++m) {
      double sum = 0;
      for (int c = 0; c < s.count; ++c)
        if (has_rigid(set, c)) sum += calc_sliding_entry(s, r, c) * L(c, m);
      M(k, m) = sum;
    }
  }
  for (int k = 0; k < rank; ++k) {
    if (!(M(k, k) > kLeastPivot * s.pivots[at(k)])) return s.independent[at(k)];
    for (int i = k + 1; i < rank; ++i) {
      const double part = M(i, k) / M(k, k);
      for (int m = k + 1; m < rank; ++m) M(i, m) -= part * M(k, m);
      x[i] -= part * x[k];
    }
  }
  for (int k = rank - 1; k >= 0; --k) {
    for (int m = k + 1; m < rank; ++m) x[k] -= M(k, m) * x[m];
    x[k] /= M(k, k);
  }
  std::fill_n(s.forces.begin(), s.count, 0.0);
  for (int r = 0; r < s.count; ++r) {
    if (!has_rigid(set, r)) continue;
    for (int k = 0; k < rank; ++k) s.forces[at(r)] += L(r, k) * x[k];
    const RigidRow& row = s.rows[at(r)];
    if (row.tangent != 0 || !slides(row)) continue;
    for (int k = 0; k < 2; ++k) s.forces[at(r + 1 + k)] = -row.friction * s.forces[at(r)] * row.slide[k];
  }
  return kNone;
}

// What the friction of the pair at row `r` has come to: the force on the follower, and what decides whether it sticks
// or slips on.
void keep_friction(int r, Evaluation& ev) {
  const RigidScratch& s = ev.rigid;
  const RigidRow* rows = &s.rows[at(r)];
  const double normal = s.forces[at(r)], first = s.forces[at(r + 1)], second = s.forces[at(r + 2)];
  const std::size_t pair = at(rows[0].pair);
  // the rows are those of the sphere, seen from the other shape
  const double side = dot(rows[1].on_follower.lin, rows[1].along) > 0 ? 1 : -1;
  ev.pair_frictions[pair] = side * (first * rows[1].along + second * rows[2].along);
  constexpr double kLeast = 1e-11;  // m/s²: of accelerations that is rounding
  const double cone = rows[0].friction * normal + kLeast / std::max(rows[1].free, rows[2].free);
  ev.pair_slides[pair] = rows[0].mode == RigidMode::kSticks ? std::sqrt(first * first + second * second) - cone
                                                            : -rows[1].rate - kRigidRest;
}

// Adds the pair at row `r` to the rates of its contact.
void add_pair(const RigidScratch& s, int r, bool has_friction, ContactRates& rates) {
  const RigidRow* rows = &s.rows[at(r)];
  // What a pair that sticks drifts by is no slip: an error of the integration.
  const double slip = rows[0].mode == RigidMode::kSticks ? 0 : rows[0].slip;
  const double work = has_friction ? s.forces[at(r + 1)] * rows[1].rate + s.forces[at(r + 2)] * rows[2].rate : 0;
  rates.add(s.forces[at(r)], slip, -work);
}

// The rates of all contacts with rows; those of a contact follow one another.
void store_rates(const PlanData& plan, Evaluation& ev) {
  const RigidScratch& s = ev.rigid;
  ContactRates rates;
  for (int r = 0, latest = kNone; r <= s.count; ++r) {
    if (r < s.count && s.rows[at(r)].tangent != 0) continue;
    const int contact = r < s.count ? plan.contact_pairs[at(s.rows[at(r)].pair)].contact : kNone;
    if (contact != latest && latest != kNone) rates.store(plan.contacts[at(latest)], ev);
    if (contact != latest) rates = {};
    if (contact != kNone) add_pair(s, r, plan.contacts[at(contact)].friction > 0, rates);
    latest = contact;
  }
}

}  // namespace

void update_rigid_matrix(const PlanData& plan, double gamma_h, Evaluation& ev) noexcept {
  RigidScratch& s = ev.rigid;
  const std::size_t n = s.loads.size();
  const Sweep sweep{.source = Source::kBodyForces, .biased = false, .multipliers = false, .gamma_h = gamma_h};
  clear_forces(plan, ev);
  for (int c = 0; c < s.count; ++c) {
    const RigidRow& row = s.rows[at(c)];
    push_row(ev, row, 1);
    get_kernels(plan).solve(plan, ev, sweep);
    for (int r = 0; r < s.count; ++r) s.matrix[at(r) * n + at(c)] = apply_row(s.rows[at(r)], ev);
    for (const std::int32_t body : {row.base, row.follower})
      if (body != kGround) write(ev.blocks.data(), plan.places[at(body)], &SharedLane::force, kNoForce);
  }
}

void solve_rigid_set(RigidSet set, Evaluation& ev) noexcept {
  RigidScratch& s = ev.rigid;
  const std::size_t n = s.loads.size();
  const int rank = factor(set, kAllRigidRows, ev);
  const auto L = [&](int r, int k) -> double { return s.factor[at(r) * n + at(k)]; };
  const auto for_rows = [&](const auto& run) {
    for (int r = 0; r < s.count; ++r)
      if (has_rigid(set, r)) run(r);
  };
  int rows = 0;
  for_rows([&](int) { ++rows; });
  std::fill_n(s.forces.begin(), s.count, 0.0);
  double* const x = s.middle.data();
  if (rank == rows) {  // L is square
    for (int k = 0; k < rank; ++k) {
      x[k] = s.loads[at(s.independent[at(k)])];
      for (int m = 0; m < k; ++m) x[k] -= L(s.independent[at(k)], m) * x[m];
    }
    for (int k = rank - 1; k >= 0; --k) {
      x[k] /= s.pivots[at(k)];
      for (int m = k + 1; m < rank; ++m) x[k] -= L(s.independent[at(m)], k) * x[m];
    }
    for (int k = 0; k < rank; ++k) s.forces[at(s.independent[at(k)])] = x[k];
    return;
  }
  const LowerTriangle gram{s.gram.data(), static_cast<std::int32_t>(n)};
  for (int k = 0; k < rank; ++k) {
    for (int m = 0; m <= k; ++m) {
      double sum = 0;
      for_rows([&](int r) { sum += L(r, k) * L(r, m); });
      gram(k, m) = sum;
    }
    double sum = 0;
    for_rows([&](int r) { sum += L(r, k) * s.loads[at(r)]; });
    x[k] = sum;
  }
  (void)factor_ldl(gram, rank);  // LᵀL has pivots of at least 1
  solve_ldl(gram, rank, x);
  for (int k = 0; k < rank; ++k) x[k] /= s.pivots[at(k)];
  solve_ldl(gram, rank, x);
  for_rows([&](int r) {
    for (int k = 0; k < rank; ++k) s.forces[at(r)] += L(r, k) * x[k];
  });
}

RigidSet get_independent_rigid_rows(const Evaluation& ev) noexcept {
  RigidSet set = 0;
  for (int k = 0, rank = count_independent(ev); k < rank; ++k) set |= RigidSet{1} << ev.rigid.independent[at(k)];
  return set;
}

int find_contradiction(RigidSet set, double tolerance, Evaluation& ev) noexcept {
  RigidScratch& s = ev.rigid;
  const std::size_t n = s.loads.size();
  const int rank = count_independent(ev);
  const RigidSet independent = get_independent_rigid_rows(ev);
  for (int r = 0; r < s.count; ++r) {
    if (!has_rigid(set, r) || has_rigid(independent, r)) continue;
    if (s.rows[at(r)].tangent != 0) continue;
    const double surplus = calc_surplus(ev, r);
    if (surplus > tolerance) return r;
    if (!(surplus < -tolerance)) continue;
    double* const weight = s.middle.data();  // Lᵀ of the independent rows times it is the row of L
    for (int k = rank - 1; k >= 0; --k) {
      weight[k] = s.factor[at(r) * n + at(k)];
      for (int m = k + 1; m < rank; ++m) weight[k] -= s.factor[at(s.independent[at(m)]) * n + at(k)] * weight[m];
    }
    constexpr double kLeastWeight = 1e-6;
    for (int k = 0; k < rank; ++k)
      if (weight[k] > kLeastWeight && s.rows[at(s.independent[at(k)])].tangent == 0) return s.independent[at(k)];
  }
  return kNone;
}

void set_rigid_impulses(const PlanData& plan, Evaluation& ev) noexcept {
  clear_forces(plan, ev);
  for (int r = 0; r < ev.rigid.count; ++r) push_row(ev, ev.rigid.rows[at(r)], ev.rigid.forces[at(r)]);
}

int solve_rigid_rows(const Instant& now, RigidTarget target, const Sweep& sweep, RigidSet set,
                     Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  RigidScratch& s = ev.rigid;
  const bool forces = target == RigidTarget::kAcceleration;
  if (!collect_rigid_rows(plan, now.state, now.t, ev)) return kRigidFailure;
  if (s.count == 0) return kNone;
  for (int r = 0; r < s.count; ++r) s.loads[at(r)] = calc_target(s.rows[at(r)], target) - apply_row(s.rows[at(r)], ev);
  keep_forces(plan, ev);
  update_rigid_matrix(plan, sweep.gamma_h, ev);
  if (forces && has_slip_rows(ev)) {
    if (const int row = solve_sliding_rows(set, ev); row != kNone) {
      s.failed = plan.contact_pairs[at(s.rows[at(row)].pair)].contact;
      s.wedged = true;
      return kRigidFailure;
    }
  } else {
    solve_rigid_set(set, ev);
  }
  Sweep whole = sweep;
  if (sweep.source == Source::kNothing) {
    whole.source = Source::kBodyForces;
    set_rigid_impulses(plan, ev);
  } else {
    restore_forces(plan, ev);
    for (int r = 0; r < s.count; ++r) push_row(ev, s.rows[at(r)], s.forces[at(r)]);
  }
  get_kernels(plan).solve(plan, ev, whole);
  if (!forces) return kNone;
  double largest = 0;  // m/s²
  for (int r = 0; r < s.count; ++r) {
    const RigidRow& row = s.rows[at(r)];
    if (row.tangent != 0) continue;
    ev.pair_forces[at(row.pair)] = s.forces[at(r)];
    largest = std::max(largest, std::abs(s.forces[at(r)]) * row.free);
    ev.pair_distances[at(row.pair)] = row.gap;
    if (plan.contacts[at(plan.contact_pairs[at(row.pair)].contact)].friction > 0) keep_friction(r, ev);
  }
  store_rates(plan, ev);
  constexpr double kPart = 1e-8, kLeast = 1e-11;  // of accelerations that is rounding; m/s²
  const int leaves = find_contradiction(has_slip_rows(ev) ? get_holding_rows(ev) : set, kPart * largest + kLeast, ev);
  if (leaves != kNone)
    ev.pair_forces[at(s.rows[at(leaves)].pair)] = -std::max(largest, kLeast) / s.rows[at(leaves)].free;
  return kNone;
}

}  // namespace unlatch
