#include "kernel/events/rigid_pairs.h"

#include <algorithm>
#include <cmath>

#include "kernel/dispatch/kernels.h"
#include "kernel/dynamics/balance.h"
#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/events/cone_impulses.h"
#include "kernel/events/rigid_friction.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/rigid_rows.h"
#include "kernel/solver/loops/loop_rows.h"

namespace unlatch {
namespace {

// Of EventSearch::rigid.
constexpr std::int64_t kTouched = 1;  // in this round
constexpr std::int64_t kSettles = 2;  // it touched, and does not bounce
constexpr std::int64_t kPulled = 4;   // it was opened at this instant because its force would pull
constexpr std::int64_t kStops = 8;    // its slip ended in this round, and what is left of it is stopped
constexpr std::int64_t kRocks = 16;  // it touched at the end of a flight that was too short to be one, see comes_back()
constexpr std::int64_t kTurn = 32;   // times the number of its slip's turns at this instant
constexpr std::int64_t kMostTurns = 32;
// All pairs: they were brought to rest, and have modes that were found together, at this instant.
constexpr std::int64_t kRests = std::int64_t{1} << 40, kDecided = std::int64_t{1} << 41;

// m: a pair that bounced touches again this much nearer, one that was opened at rest; a located touch is no deeper.
constexpr double kBounced = 1e-12, kRested = 1e-10, kDeepest = 1e-8;
// A pair that comes back soon so often in a step rocks.
constexpr std::int64_t kMostReturns = 2;
// Rounds for each pair in which one after the other changes.
constexpr std::size_t kRoundsOfPivots = 4;
// Part of forces, impulses and accelerations that is rounding; of rates, by which redundant rows contradict each other.
constexpr double kNothing = 1e-9, kNoImpulse = 1e-12, kNoRate = 1e-8;

const PlanContact& get_contact(const PlanData& plan, std::size_t pair) {
  return plan.contacts[at(plan.contact_pairs[pair].contact)];
}

bool calc_row(const Run& run, std::size_t pair, RigidRow& row) {
  const PlanData& plan = run.plan;
  const PlanContact& contact = get_contact(plan, pair);
  return calc_rigid_row(plan, static_cast<std::int32_t>(pair),
                        get_body_frame(run.ev(), plan.shapes[at(contact.base)].body),
                        get_body_frame(run.ev(), plan.shapes[at(contact.follower)].body), row);
}

// Second derivative of a pair's gap by the present accelerations, m/s².
double calc_gap_acceleration(const Run& run, const RigidRow& row) {
  const auto get = [&](int body) {
    return body == kGround ? Spatial{{0, 0, 0}, {0, 0, 0}} : run.ev().get_acceleration(body);
  };
  return row.bias + apply_rigid_row(row, get(row.base), get(row.follower));
}

double calc_largest_force(const Run& run) {
  double largest = 0;
  for (std::size_t i = 0; i < run.state().contacts.size(); ++i)
    if (is_held(run.state().contacts[i]) && get_contact(run.plan, i).rigid)
      largest = std::max(largest, std::abs(run.ev().pair_forces[i]));
  return largest;
}

bool would_overlap(const Run& run, std::size_t pair, double largest_force) {
  if ((run.search().rigid[pair] & kPulled) == 0 || run.state().contacts[pair].closed != kPairOpen) return false;
  RigidRow row;
  return calc_row(run, pair, row) && calc_gap_acceleration(run, row) < -kNothing * row.free * largest_force;
}

// A pair with friction that closes has yet to be found sticking or slipping.
void forget_friction(Run& run, std::size_t pair) {
  if (run.state().rigid_slips.empty()) return;
  run.state().rigid_slips[pair] = {0, 0, 0};
  run.ev().pair_frictions[pair] = {0, 0, 0};
}

// Opens a pair, which touches again `nearer` than it is, also by the distance that open pairs have.
void open(Run& run, double now, std::size_t pair, double nearer) {
  run.search().rigid_lifts[pair] = now;
  const double gap = std::min(0.0, run.ev().pair_distances[pair]), seen = calc_open_distance(run.plan, pair, run.ev());
  run.state().contacts[pair] = {kPairOpen, (seen < gap - kBounced ? seen : gap) - nearer};
  run.ev().pair_forces[pair] = 0;
  forget_friction(run, pair);
}

void close(Run& run, std::size_t pair) {
  run.state().contacts[pair] = {kPairClosed, 0};
  forget_friction(run, pair);
}

// True if a pair that left in this step comes back after less than its contact's `settle`, and by the acceleration −g
// of its gap: not faster than that makes it, as it would be if it had met something between.
bool comes_back(const Run& run, double now, std::size_t pair, const RigidRow& row, double g) {
  const double flight = now - run.search().rigid_lifts[pair];
  return flight < get_contact(run.plan, pair).settle && -row.rate <= flight * g;
}

// Closes a pair. Its next flight would last 2 e |w⁻| / g at the acceleration −g of the gap. False if its contact was
// switched on at this instant, where it overlaps.
bool begin_touch(Run& run, double now, std::size_t pair) {
  std::int64_t& flags = run.search().rigid[pair];
  flags = kTouched;
  close(run, pair);
  const PlanContact& contact = get_contact(run.plan, pair);
  run.ev().rigid.failed = run.plan.contact_pairs[pair].contact;
  RigidRow row;
  run.ev().rigid.degenerate = !calc_row(run, pair, row);
  if (run.ev().rigid.degenerate) return false;
  if (row.gap < -kDeepest && run.state().elements[at(contact.element)].switched_on == now) return false;
  run.ev().rigid.failed = kNone;
  if (!(row.rate < 0)) return true;
  const double speed = contact.restitution * -row.rate, g = -calc_gap_acceleration(run, row);
  const bool rocks = comes_back(run, now, pair, row, g) && ++run.search().rigid_returns[pair] >= kMostReturns;
  if (!rocks && !(2 * speed < contact.settle * g)) return true;
  flags |= rocks ? kSettles | kRocks : kSettles;
  if (!rocks && speed == 0) return true;  // it does not bounce anyway
  ++run.report.settled;
  run.report.settling = run.plan.contact_pairs[pair].contact;
  return true;
}

// Slips that begin take the directions of their accelerations, all at once; 0 if they have them.
int turn_slips(Run& run) {
  int count = 0;
  for (std::size_t i = 0; i < run.state().rigid_slips.size(); ++i) {
    Vec3 direction;
    if (run.search().rigid[i] >= kMostTurns * kTurn || !would_turn(run, i, direction)) continue;
    turn_slip(run, i, direction);
    run.search().rigid[i] += kTurn;
    ++count;
  }
  return count;
}

void mark_all(Run& run, std::int64_t flags) {
  for (std::int64_t& own : run.search().rigid) own |= flags;
}

bool is_marked(const Run& run, std::int64_t flag) {
  return !run.search().rigid.empty() && (run.search().rigid[0] & flag) != 0;
}

// False, with the contact, if a force pulls or is out of its cone: no modes were found that hold.
bool check_forces(Run& run) {
  constexpr double kRest = 1e-6;  // of the largest
  const double least = kRest * calc_largest_force(run);
  for (std::size_t i = 0; i < run.state().contacts.size(); ++i) {
    if (!get_contact(run.plan, i).rigid || !is_held(run.state().contacts[i])) continue;
    const bool breaks = run.state().contacts[i].closed == kPairSticks && run.ev().pair_slides[i] > least;
    if (run.ev().pair_forces[i] >= -least && !breaks) continue;
    run.ev().rigid.failed = run.plan.contact_pairs[i].contact;
    return false;
  }
  return true;
}

// The changes of one pair after the other have not ended: all pairs at once, in two rounds. 0 if there is nothing left.
int decide_together(Run& run, double now) {
  if (is_marked(run, kDecided)) return check_forces(run) ? 0 : kFailedTouch;
  if (!is_marked(run, kRests)) {
    for (std::size_t i = 0; i < run.state().contacts.size(); ++i)
      if ((run.search().rigid[i] & kPulled) != 0 && run.state().contacts[i].closed == kPairOpen) close(run, i);
    rest_slow_pairs(run);
    mark_all(run, kRests | kStops);
    return 1;
  }
  mark_all(run, kDecided);
  if (!find_friction_modes(run)) return kFailedTouch;
  for (std::size_t i = 0; i < run.state().contacts.size(); ++i)
    if (get_contact(run.plan, i).rigid && run.state().contacts[i].closed == kPairLeaves) open(run, now, i, kRested);
  return 1;
}

// Opens or closes the first pair that has the wrong sign, or lets it slip or stick; 0 if none has.
int pivot(Run& run, double now, std::span<const double> guards, std::span<const double> below) {
  const double largest = calc_largest_force(run);
  for (std::size_t i = 0; i < run.state().contacts.size(); ++i) {
    if (!get_contact(run.plan, i).rigid) continue;
    const bool held = is_held(run.state().contacts[i]);
    if (held && is_undecided(run, i)) {
      change_friction(run, i);
    } else if (held && guards[i] >= -below[i] &&
               (!(run.ev().pair_forces[i] > below[i]) || !is_friction_changing(run, i))) {
      if (run.ev().pair_forces[i] < 0) run.search().rigid[i] |= kPulled;
      open(run, now, i, kRested);
    } else if ((held && guards[i] >= -below[i]) || would_stick(run, i, largest)) {
      if (change_friction(run, i)) run.search().rigid[i] |= kStops;
    } else if (would_overlap(run, i, largest)) {
      close(run, i);
    } else {
      continue;
    }
    run.ev().rigid.failed = run.plan.contact_pairs[i].contact;
    return 1;
  }
  return turn_slips(run);
}

// The impulses of the rows: see rigid_pairs.h. False if the pivots do not end.
bool find_impulses(Evaluation& ev) {
  RigidScratch& s = ev.rigid;
  const std::size_t n = s.loads.size();
  const auto calc_surplus = [&](int r) {  // w⁺ − w
    double sum = -s.loads[at(r)];
    for (int c = 0; c < s.count; ++c) sum += s.matrix[at(r) * n + at(c)] * s.forces[at(c)];
    return sum;
  };
  double fastest = 0;
  RigidSet set = 0;
  for (int r = 0; r < s.count; ++r) {
    fastest = std::max(fastest, std::abs(s.loads[at(r)]));
    if (s.loads[at(r)] > 0) set |= RigidSet{1} << r;
  }
  for (int tries = 0; tries <= 16 * s.count; ++tries) {
    solve_rigid_set(set, ev);
    double largest = 0;
    for (int r = 0; r < s.count; ++r) largest = std::max(largest, std::abs(s.forces[at(r)]));
    const auto has_wrong_sign = [&](int r) {
      return has_rigid(set, r) ? s.forces[at(r)] < -kNoImpulse * largest : calc_surplus(r) < -kNoRate * fastest;
    };
    if (const int leaves = find_contradiction(set, kNoRate * fastest, ev); leaves != kNone) {
      set ^= RigidSet{1} << leaves;
      continue;
    }
    int wrong = kNone;
    for (int r = 0; r < s.count && wrong == kNone; ++r)
      if (has_wrong_sign(r)) wrong = r;
    if (wrong != kNone) {
      set ^= RigidSet{1} << wrong;
      continue;
    }
    // Redundant rows that are satisfied as well take their share, if none has to pull for it.
    RigidSet tight = set;
    for (int r = 0; r < s.count; ++r)
      if (!has_rigid(set, r) && calc_surplus(r) <= kNoRate * fastest) tight |= RigidSet{1} << r;
    if (tight == set) return true;
    solve_rigid_set(tight, ev);
    for (int r = 0; r < s.count; ++r)
      if (s.forces[at(r)] < -kNoImpulse * largest) {
        solve_rigid_set(set, ev);
        return true;
      }
    return true;
  }
  return false;
}

// Rate of row r after the impulses.
double calc_rate_after(const RigidScratch& s, int r) {
  const double* const row = &s.matrix[at(r) * s.loads.size()];
  double after = s.rows[at(r)].rate;
  for (int c = 0; c < s.count; ++c) after += row[c] * s.forces[at(c)];
  return after;
}

// What the ground takes, and what the impulses of the rows do; adds these to the contacts' totals.
void account(Run& run, Balance& allowed) {
  Evaluation& ev = run.ev();
  const RigidScratch& s = ev.rigid;
  for (int r = 0; r < s.count; ++r) {
    const RigidRow& row = s.rows[at(r)];
    const double p = s.forces[at(r)], work = 0.5 * p * (row.rate + calc_rate_after(s, r));
    allowed.kinetic += work;
    if (row.base == kGround || row.follower == kGround) {
      const int body = row.base == kGround ? row.follower : row.base;
      const Spatial wrench = p * (row.base == kGround ? row.on_follower : row.on_base);
      allowed.momentum += wrench.lin;
      allowed.angular_momentum += cross(get_body_frame(ev, body).p, wrench.lin) + wrench.ang;
    }
    add_impulse(get_contact(run.plan, at(row.pair)), row.tangent == 0 ? p : 0, -work, ev);
  }
}

// The modes of all pairs after a blow: those that leave, those that slip.
void set_modes(Run& run) {
  Evaluation& ev = run.ev();
  const RigidScratch& s = ev.rigid;
  double fastest = 0;
  if (has_rigid_friction(run.plan))
    for (int r = 0; r < s.count; ++r) fastest = std::max(fastest, std::abs(s.loads[at(r)]));
  const double rest = std::max(kRigidRest, 10 * kImpulseResidual * fastest);
  for (int r = 0; r < s.count; ++r) {
    const RigidRow& row = s.rows[at(r)];
    if (row.tangent != 0) continue;
    const double yield = s.yield * get_pair_mobility(s, r);
    const auto calc_after = [&](int k) { return calc_rate_after(s, k) + yield * s.forces[at(k)]; };
    if (row.friction > 0) set_friction(run, r, calc_after(r + 1), calc_after(r + 2), rest);
    if (calc_after(r) > rest) {
      run.state().contacts[at(row.pair)].closed = kPairLeaves;
      ev.pair_forces[at(row.pair)] = 0;
    }
  }
}

// Rows of all closed pairs, and Λ by a factor of the velocities. Returns kNone, or as strike_rigid_pairs().
int prepare_impulse(Run& run, double now) {
  const PlanData& plan = run.plan;
  Evaluation& ev = run.ev();
  if (!collect_rigid_rows(plan, run.state(), now, ev)) return kRigidFailure;
  update_joints(plan, run.state(), RowTarget::kVelocity, ev);
  const Sweep nothing{.source = Source::kNothing, .biased = false, .multipliers = false};
  const int node = get_kernels(plan).factor_and_solve(plan, run.state(), ev, nothing, kAllRows);
  if (node != kNone) return node;
  update_rigid_matrix(plan, 0, ev);
  return kNone;
}

// The impulses with which no gap has a rate, and no pair that sticks a slip.
void stop_rows(Evaluation& ev) {
  RigidScratch& s = ev.rigid;
  RigidSet set = 0;
  for (int r = 0; r < s.count; ++r) {
    const RigidRow& row = s.rows[at(r)];
    s.loads[at(r)] = -row.rate;
    if (row.tangent == 0 || s.rows[at(r - row.tangent)].mode == RigidMode::kSticks) set |= RigidSet{1} << r;
  }
  solve_rigid_set(set, ev);
}

// True if what touches in this round rocks from one pair to another, in flights that are too short to be any.
bool is_rocking(const Run& run) {
  bool any = false;
  for (const std::int64_t flags : run.search().rigid) {
    if ((flags & kRocks) != 0) any = true;
    if ((flags & (kTouched | kSettles)) == kTouched) return false;
  }
  return any;
}

// The bodies get the impulses of the rows. Returns as strike_rigid_pairs().
int apply_rigid_impulse(Run& run, Balance& allowed) {
  const PlanData& plan = run.plan;
  Evaluation& ev = run.ev();
  account(run, allowed);
  set_rigid_impulses(plan, ev);
  if (const int failed = apply_impulse(plan, Source::kBodyForces, run.state(), ev); failed != kNone) return failed;
  const Balance joints = calc_allowed_change(plan, run.state(), ev);
  allowed.momentum += joints.momentum;
  allowed.angular_momentum += joints.angular_momentum;
  allowed.kinetic += joints.kinetic;
  update_velocities(plan, ev);
  return kNone;
}

}  // namespace

void begin_rigid_pairs(Run& run) noexcept {
  std::fill(run.search().rigid.begin(), run.search().rigid.end(), std::int64_t{0});
  run.ev().rigid.failed = kNone;
  run.ev().rigid.wedged = run.ev().rigid.degenerate = false;
}

bool wants_rigid_pair(const Run& run) noexcept {
  if (run.plan.rigid_pairs == 0 || is_marked(run, kDecided)) return false;
  if (is_marked(run, kRests)) return true;
  const double largest = calc_largest_force(run);
  for (std::size_t i = 0; i < run.state().contacts.size(); ++i)
    if (would_overlap(run, i, largest) || would_stick(run, i, largest)) return true;
  Vec3 direction;
  for (std::size_t i = 0; i < run.state().rigid_slips.size(); ++i)
    if (run.search().rigid[i] < kMostTurns * kTurn && would_turn(run, i, direction)) return true;
  return false;
}

int change_rigid_pairs(Run& run, double now, std::size_t round, std::span<const double> tolerances) noexcept {
  const PlanData& plan = run.plan;
  if (plan.rigid_pairs == 0) return 0;
  const std::span<const double> guards = get_pair_guards(plan, std::span<const double>(run.ev().guards)),
                                below = get_pair_guards(plan, tolerances);
  int count = 0;
  for (std::size_t i = 0; i < run.state().contacts.size(); ++i) {
    if (!get_contact(plan, i).rigid) continue;
    run.search().rigid[i] &= ~(kTouched | kSettles | kStops | kRocks);
    const std::int64_t closed = run.state().contacts[i].closed;
    const bool on = calc_scale(run.state().elements[at(get_contact(plan, i).element)], now) != 0;
    if (closed == kPairOpen && guards[i] >= -below[i]) {
      if (!begin_touch(run, now, i)) return kFailedTouch;
    } else if (closed == kPairLeaves || (closed != kPairOpen && !on)) {
      open(run, now, i, closed == kPairLeaves ? kBounced : kRested);
    } else {
      continue;
    }
    ++count;
  }
  if (count > 0) return count;
  const bool together = has_rigid_friction(plan) && round > kRoundsOfPivots * at(plan.rigid_pairs);
  return together ? decide_together(run, now) : pivot(run, now, guards, below);
}

bool has_rigid_impulse(const Run& run, bool jumped) noexcept {
  for (std::size_t i = 0; i < run.search().rigid.size(); ++i) {
    if ((run.search().rigid[i] & kTouched) != 0) return true;
    if (jumped && get_contact(run.plan, i).rigid && is_held(run.state().contacts[i])) return true;
  }
  return false;
}

int strike_rigid_pairs(Run& run, double now, Balance& allowed) noexcept {
  const PlanData& plan = run.plan;
  RigidScratch& s = run.ev().rigid;
  if (const int failed = prepare_impulse(run, now); failed != kNone) return failed;
  s.yield = 0;
  if (is_rocking(run)) {
    stop_rows(run.ev());
    set_modes(run);
    return apply_rigid_impulse(run, allowed);
  }
  for (int r = 0; r < s.count; ++r) {
    const RigidRow& row = s.rows[at(r)];
    const bool bounces =
        row.tangent == 0 && (run.search().rigid[at(row.pair)] & (kTouched | kSettles)) == kTouched && row.rate < 0;
    const double restitution = bounces ? get_contact(plan, at(row.pair)).restitution : 0;
    s.loads[at(r)] = -(1 + restitution) * row.rate;
    s.pivots[at(r)] = restitution;
  }
  if (has_rigid_friction(plan)) {
    if (!find_friction_impulses(plan, s.pivots, run.ev())) return kRigidFailure;
    if (s.yield > run.report.yielded) {
      run.report.yielded = s.yield;
      run.report.yielding = plan.contact_pairs[at(s.rows[0].pair)].contact;
    }
  } else if (!find_impulses(run.ev())) {
    s.failed = plan.contact_pairs[at(s.rows[0].pair)].contact;
    return kRigidFailure;
  }
  set_modes(run);
  return apply_rigid_impulse(run, allowed);
}

int stop_rigid_slips(Run& run, double now, Balance& allowed) noexcept {
  const auto stops = [](std::int64_t flags) { return (flags & kStops) != 0; };
  if (std::none_of(run.search().rigid.begin(), run.search().rigid.end(), stops)) return kNone;
  if (const int failed = prepare_impulse(run, now); failed != kNone) return failed;
  stop_rows(run.ev());
  return apply_rigid_impulse(run, allowed);
}

}  // namespace unlatch
