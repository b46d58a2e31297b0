#include "kernel/events/event_search.h"

#include <algorithm>
#include <cmath>

#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/events/corners.h"
#include "kernel/events/crossing.h"
#include "kernel/events/guards.h"
#include "kernel/events/limits.h"
#include "kernel/integration/integrator.h"

namespace unlatch {
namespace {

// Part of a guard's change over the sub-step: events whose guards are within it of zero count as simultaneous.
constexpr double kSimultaneous = 1e-6;
// Part of the sub-step: an event is located once the next try would be nearer than this to the latest one.
constexpr double kLocated = 1e-6;
// Part of the sub-step: a change of a feature is located once the next try would be nearer than this to the latest one,
// and does not count within the second of either end. What a corner of the forces costs is of the square of that.
constexpr double kFeatureLocated = 1e-3, kFeatureNear = 1e-2;
constexpr double kBeyond = 16;  // growth of what a try beyond the estimate adds

// Tries the sub-step from its start to `end`. Leaves the evaluation of `end`, guards included.
bool try_substep(Run& run, const SubstepStart& start, double end) {
  ++run.report.substeps;
  const Instant now = run.get_instant(end);
  if (!run.check(integrate(now, start, end, run.ev()))) return false;
  if (!run.check(evaluate(now, Changed::kVelocities, run.ev()))) return false;
  update_guards(now, run.ev(), run.search().stack);
  return true;
}

void keep_low(Run& run) {
  std::copy(run.ev().guards.begin(), run.ev().guards.end(), run.search().guards_low.begin());
  std::copy(run.ev().pair_rates.begin(), run.ev().pair_rates.end(), run.search().rates_low.begin());
  std::copy_n(run.ev().law_places.begin(), run.search().places_low.size(), run.search().places_low.begin());
  if (!run.plan.sought_corners) return;
  std::copy(run.ev().altitudes.begin(), run.ev().altitudes.end(), run.search().altitudes_low.begin());
  std::copy(run.ev().travels.begin(), run.ev().travels.end(), run.search().travels_low.begin());
  std::copy(run.ev().pair_features.begin(), run.ev().pair_features.end(), run.search().features_low.begin());
}

void keep_high(Run& run) {
  std::copy(run.ev().guards.begin(), run.ev().guards.end(), run.search().guards_high.begin());
  std::copy(run.ev().pair_rates.begin(), run.ev().pair_rates.end(), run.search().rates_high.begin());
}

// --- Crossings -------------------------------------------------------------------------------------------------------

bool crosses(const Run& run, std::size_t e) {
  return (e >= run.state().events.size() || run.state().events[e].phase == EventPhase::kArmed) &&
         run.search().guards_low[e] < 0 && run.search().guards_high[e] >= 0;
}

int count_crossings(const Run& run) {
  const double* high = run.search().guards_high.data();
  int count = 0;
  for (std::size_t e = 0; e < run.ev().guards.size(); ++e)
    if (high[e] >= 0 && crosses(run, e)) ++count;  // few guards are ≥ 0: the others take two instructions
  return count;
}

// The first crossing within the bracket. Values of the guards at its ends are in guards_low and guards_high, at the
// third point in guards_middle. `first`: the guard that crosses.
Crossing estimate(const Run& run, const Bracket& bracket, std::size_t& first) {
  const EventSearch& s = run.search();
  Crossing earliest{bracket.to, false};
  bool found = false;
  for (std::size_t e = 0; e < run.ev().guards.size(); ++e) {
    if (!crosses(run, e)) continue;
    const Crossing own = interpolate(bracket, s.guards_low[e], s.guards_high[e], s.guards_middle[e]);
    if (found && !(own.time < earliest.time)) continue;
    earliest = own;
    first = e;
    found = true;
  }
  return earliest;
}

// Replaces one end of the bracket by the latest try, at `x`.
void narrow(const Run& run, double x, Bracket& bracket) {
  const EventSearch& s = run.search();
  bool crossed = false;
  for (std::size_t e = 0; e < run.ev().guards.size(); ++e) crossed |= run.ev().guards[e] >= 0 && crosses(run, e);
  const std::span<double> end = crossed ? s.guards_high : s.guards_low;
  std::copy(end.begin(), end.end(), s.guards_middle.begin());
  std::copy(run.ev().guards.begin(), run.ev().guards.end(), end.begin());
  bracket.narrow(x, crossed);
}

// True if some guard that crosses starts within its tolerance of zero, like the lift of a contact that has just closed.
bool begins_at_zero(const Run& run) {
  const EventSearch& s = run.search();
  bool found = false;
  for (std::size_t e = 0; e < run.ev().guards.size(); ++e)
    found |= crosses(run, e) && -s.guards_low[e] <= s.tolerances[e];
  return found;
}

// True if guard `e` is near zero at the latest try, compared with its tolerance. A guard that jumps is not.
bool is_near_zero(const Run& run, std::size_t e) {
  constexpr double kSteep = 10;  // slope at the crossing over that of the whole sub-step
  return std::fabs(run.ev().guards[e]) <= kSteep * run.search().tolerances[e];
}

// Number of a guard in reports: that of its event, or, after all events, that of the contact of its pair.
std::int32_t get_reported_guard(const PlanData& plan, std::size_t guard) {
  const std::size_t events = plan.events.size();
  if (guard < events) return static_cast<std::int32_t>(guard);
  return static_cast<std::int32_t>(events) + plan.contact_pairs[guard - events].contact;
}

// Reports that the tries were used up while the instant of event `first` was known to no less than `interval`.
void note_unlocated(Run& run, std::size_t first, double interval) {
  OpenSearch& open = run.report.open;
  ++open.unlocated;
  if (open.guard != kNone && interval <= open.interval) return;
  open.interval = interval;
  open.guard = get_reported_guard(run.plan, first);
}

// Locates the first crossing within the sub-step; values at its ends are in guards_low and guards_high. Leaves the
// evaluation of that instant and returns its time, or kFailed. `first`: the guard that crosses.
//
// A try is at the zero of the inverse parabola; from the third on only if the parabola's three values rise, else at the
// middle of the bracket. Two cases would keep the parabola at one place. A guard that starts at zero and falls at
// first: the middle is tried until a try lies before the crossing. A guard that jumps: the search ends only where the
// guard is near zero, when the next try would be within the tolerance of the latest one.
double locate(Run& run, const SubstepStart& start, double end, std::size_t& first) {
  const double shortest = run.plan.get_slack(), tolerance = std::max(kLocated * (end - start.t), shortest);
  const bool at_zero = begins_at_zero(run);
  Bracket bracket{0, end - start.t, 0};
  Crossing next = estimate(run, bracket, first);
  bool falls = false;    // a try just after the beginning of the bracket did not cross: the guard falls there
  bool stuck = false;    // the estimate stays at the latest try, but the guard is not near zero there
  bool located = false;  // the latest try is at the crossing
  double reached = end;
  for (int i = 0; i < kMostTries && !located; ++i) {
    double x = next.time;
    const bool held = at_zero && x - bracket.from < tolerance;  // the estimate stays at the beginning of the bracket
    const bool nudged = held && next.sure && !falls;            // this try is just after it
    if (nudged)
      x = std::max(x, bracket.from + shortest);
    else if (held || falls || stuck || (i > 1 && !next.sure))
      x = 0.5 * (bracket.from + bracket.to);
    reached = std::min(start.t + x, end);  // the length may be rounded up
    if (!try_substep(run, start, reached)) return kFailed;
    narrow(run, x, bracket);
    if (bracket.from == x) falls = nudged;
    std::size_t other = first;
    next = estimate(run, bracket, other);
    const bool close = (next.sure || !at_zero) && std::fabs(next.time - x) <= tolerance;
    stuck = close && !is_near_zero(run, other);
    located = i > 0 && ((close && !stuck) || bracket.to - bracket.from <= tolerance);
    if (!located) first = other;
  }
  if (!located) note_unlocated(run, first, bracket.to - bracket.from);
  return reached;
}

// --- Touches within a sub-step ---------------------------------------------------------------------------------------

// Guard and rate of a pair of shapes at `time`. The guard of an open pair rises while the shapes approach each other.
Flank get_flank(const Run& run, std::size_t pair, double time, std::span<const double> guards,
                std::span<const double> rates) {
  return {time, get_pair_guards(run.plan, guards)[pair], run.state().contacts[pair].closed != 0 ? 0 : -rates[pair]};
}

// Reports that the tries were used up while `pair` might still touch between two flanks.
void note_unseen(Run& run, std::size_t pair, const Flank& left, const Flank& right) {
  OpenSearch& open = run.report.open;
  ++open.unseen;
  const double depth = calc_bound(left, right);
  if (open.contact != kNone && depth <= open.depth) return;
  open.depth = depth;
  open.contact = run.plan.contact_pairs[pair].contact;
}

// Searches for a touch of `pair`, which is apart at both flanks. Returns its time from the start of the sub-step, that
// of `right` if there is none, or kFailed. The evaluation is of the latest try. `looks`: the number of tries that are
// left.
//
// The first try is at the greatest value of the cubic; later ones are beside a corner, or so near that it does not
// matter.
[[gnu::noinline]] double find_touch(Run& run, const SubstepStart& start, std::size_t pair, Flank left, Flank right,
                                    int& looks) {
  const double end = right.time;
  bool first = true;
  for (; looks > 0 && may_peak(left, right); --looks) {
    const double x = first ? calc_peak(left, right) : calc_bent_peak(left, right);
    if (!try_substep(run, start, start.t + x)) return kFailed;
    const Flank peak = get_flank(run, pair, x, run.ev().guards, run.ev().pair_rates);
    if (peak.value >= 0) return x;
    (peak.rate > 0 ? left : right) = peak;
    first = false;
  }
  if (may_peak(left, right)) note_unseen(run, pair, left, right);
  return end;
}

// Searches for pairs of shapes that touch and part again within the sub-step. Returns a time before which at least one
// pair has touched, with the guards of that time in guards_high; or `end`; or kFailed. `most`: tries.
double find_touches(Run& run, const SubstepStart& start, double end, int most) {
  EventSearch& s = run.search();
  const double h = end - start.t;
  double reached = h;
  int looks = most;
  for (std::size_t i = 0; i < run.state().contacts.size(); ++i) {
    if (!(s.rates_low[i] < 0 && s.rates_high[i] > 0)) continue;
    const Flank left = get_flank(run, i, 0, s.guards_low, s.rates_low);
    const Flank right = get_flank(run, i, reached, s.guards_high, s.rates_high);
    const double touch = find_touch(run, start, i, left, right, looks);
    if (touch == kFailed) return kFailed;
    if (touch == reached) continue;
    reached = touch;
    keep_high(run);
  }
  if (reached < h) return start.t + reached;
  return looks == most || try_substep(run, start, end) ? end : kFailed;
}

// --- Corners of laws, of travels and of the air ----------------------------------------------------------------------

// False, and reported, if the step has been split at as many corners as it may be.
bool may_split_at_corner(Run& run) {
  const bool may = run.search().corners < kMostCornerSplits;
  ++(may ? run.search().corners : run.report.open.corners);
  return may;
}

// The time of the first corner that the chords up to `end` show, of which the evaluation is; `end` if there is none, or
// kFailed. The evaluation is of that time, guards_high too. `ended`: the corner at which the sub-step ends already.
[[gnu::noinline]] double find_corner_time(Run& run, const SubstepStart& start, double end, PassedCorner& ended) {
  const CornerPlaces at_begin = get_corner_places(run.search()), now = get_corner_places(run.ev());
  const PassedCorner corner = find_corner(run.plan, start.t, end, at_begin, now, ended);
  if (corner.place == kNone || !may_split_at_corner(run)) return end;
  ended = corner;
  const double side = now.get(corner) > at_begin.get(corner) ? 1 : -1;
  const auto calc_guard = [&](const CornerPlaces& places) { return side * (places.get(corner) - corner.knot); };
  Bracket bracket{0, end - start.t, 0};
  const double tolerance = std::max(kLocated * bracket.to, run.plan.get_slack());
  double low = calc_guard(at_begin), high = calc_guard(now), middle = 0, reached = end;
  // Behind a jump the law decides anew: the sub-step ends behind the crossing.
  const double least = corner.jumps ? run.plan.get_slack() : 0;
  double beyond = 0;
  Crossing next = interpolate(bracket, low, high, middle);
  for (int i = 0; i < (corner.jumps ? kMostJumpTries : kMostCornerTries); ++i) {
    const double x = std::max(next.time, least) + beyond;
    reached = std::min(start.t + x, end);
    if (!try_substep(run, start, reached)) return kFailed;
    const double guard = calc_guard(now);
    double& replaced = guard >= 0 ? high : low;
    middle = replaced;
    replaced = guard;
    bracket.narrow(x, guard >= 0);
    next = interpolate(bracket, low, high, middle);
    if (std::fabs(next.time - x) > tolerance) continue;
    if (!corner.jumps || guard > 0) break;
    beyond = beyond == 0 ? least : kBeyond * beyond;
  }
  keep_high(run);
  return reached;
}

// The time of the first corner up to `end`, likewise. The chords of a whole sub-step do not show a corner from which a
// law comes back within it, so the part up to a corner that was found is searched again until it has none, and ends in
// the middle if a law has gone and come back there.
[[gnu::noinline]] double find_first_corner_time(Run& run, const SubstepStart& start, double end) {
  PassedCorner ended;
  for (int i = 0; i < kMostCornerSplits; ++i) {
    const double reached = find_corner_time(run, start, end, ended);
    if (reached == kFailed) return reached;
    if (reached < end) {
      end = reached;
    } else {
      const PassedPlaces places{get_corner_places(run.search()), get_middle_places(run.ev()),
                                get_corner_places(run.ev())};
      if (!passes_and_returns(run.plan, start.t, end, places) || !may_split_at_corner(run)) return end;
      end = 0.5 * (start.t + end);
      if (!try_substep(run, start, end)) return kFailed;
      keep_high(run);
    }
  }
  return end;
}

// --- Knots of what is burnt ------------------------------------------------------------------------------------------

// The time of the first knot up to `end`, of which the evaluation is; `end` if there is none, or kFailed. The
// evaluation is of that time, guards_high too.
[[gnu::noinline]] double find_burnt_knot_time(Run& run, const SubstepStart& start, double end) {
  const std::span<const double> begun = run.state().auxiliary, now = run.ev().auxiliary.now;
  const PassedKnot knot = find_burnt_knot(run.plan, start.t, end, begun, now);
  if (knot.mass == kNone || !may_split_at_corner(run)) return end;
  Bracket bracket{0, end - start.t, 0};
  double low = begun[at(knot.mass)] - knot.burnt, high = now[at(knot.mass)] - knot.burnt, middle = 0, reached = end;
  Crossing next = interpolate(bracket, low, high, middle);
  for (int i = 0; i < kMostCornerTries; ++i) {
    const double x = next.time;
    reached = std::min(start.t + x, end);
    if (!try_substep(run, start, reached)) return kFailed;
    const double guard = now[at(knot.mass)] - knot.burnt;
    double& replaced = guard >= 0 ? high : low;
    middle = replaced;
    replaced = guard;
    bracket.narrow(x, guard >= 0);
    next = interpolate(bracket, low, high, middle);
    if (std::fabs(next.time - x) <= run.plan.get_slack()) break;
  }
  keep_high(run);
  return reached;
}

// --- Features of closed pairs ----------------------------------------------------------------------------------------

// A margin that changes its sign in a sub-step.
struct FeatureChange {
  double time;  // after its start by the chord, s
  std::size_t pair, margin;
};

// The first change within `h` seconds; of time h if there is none.
FeatureChange find_feature_change(const Run& run, double h) {
  FeatureChange first{h, 0, 0};
  for (std::size_t i = 0; i < run.ev().pair_features.size(); ++i) {
    if (run.state().contacts[i].closed == 0) continue;
    const PairFeature &low = run.search().features_low[i], &high = run.ev().pair_features[i];
    for (std::size_t k = 0; k < kPairMargins; ++k) {
      if (!(low[k] < 0 && high[k] >= 0) && !(low[k] >= 0 && high[k] < 0)) continue;
      const double time = h * (low[k] / (low[k] - high[k]));
      if (time > kFeatureNear * h && time < (1 - kFeatureNear) * h && time < first.time) first = {time, i, k};
    }
  }
  return first;
}

// The time of the first change of a feature up to `end`, of which the evaluation is, so that forces are smooth before
// it; `end` if there is none, or kFailed. The evaluation is of that time, guards_high too.
double find_feature_time(Run& run, const SubstepStart& start, double end) {
  Bracket bracket{0, end - start.t, 0};
  const FeatureChange change = find_feature_change(run, bracket.to);
  if (change.time == bracket.to || run.search().features == kMostFeatureSplits) return end;
  ++run.search().features;
  const auto get_margin = [&change](std::span<const PairFeature> of) { return of[change.pair][change.margin]; };
  const double side = get_margin(run.search().features_low) < 0 ? 1 : -1;
  const double tolerance = std::max(kFeatureLocated * bracket.to, run.plan.get_slack());
  double low = side * get_margin(run.search().features_low), high = side * get_margin(run.ev().pair_features);
  double middle = 0, reached = end;
  Crossing next{change.time, false};
  for (int i = 0; i < kMostFeatureTries; ++i) {
    reached = std::min(start.t + next.time, end);
    if (!try_substep(run, start, reached)) return kFailed;
    const double guard = side * get_margin(run.ev().pair_features), x = next.time;
    if (!std::isfinite(guard)) break;  // more than the radii overlap there
    double& replaced = guard >= 0 ? high : low;
    middle = replaced;
    replaced = guard;
    bracket.narrow(x, guard >= 0);
    next = interpolate(bracket, low, high, middle);
    if (std::fabs(next.time - x) <= tolerance) break;
  }
  keep_high(run);
  return reached;
}

// Tolerances of guards: an event whose guard is this little below zero acts together with the first.
void update_tolerances(Run& run) {
  EventSearch& s = run.search();
  for (std::size_t e = 0; e < s.tolerances.size(); ++e)
    s.tolerances[e] = crosses(run, e) ? kSimultaneous * (s.guards_high[e] - s.guards_low[e]) : 0;
}

// The end of a sub-step whose stages are all before `reached`, the instant at which guard `first` jumps because the
// force of a closed rigid pair does: a corner of a shape passes, and the latest stage is on the one side or the other
// by rounding, with a sixth of the jump over the whole sub-step. What is left after such an end is as much shorter,
// until it does not matter. `reached` if no such force jumps.
double calc_end_before_jump(Run& run, const SubstepStart& start, double reached, std::size_t first) {
  constexpr double kPart = 1.0 / 256, kShortest = 1e-9;  // of the sub-step; s
  const PlanData& plan = run.plan;
  if (first < plan.events.size() || reached - start.t < kShortest || is_near_zero(run, first)) return reached;
  const std::size_t pair = first - plan.events.size();
  const bool held = is_held(run.state().contacts[pair]);
  if (!held || !plan.contacts[at(plan.contact_pairs[pair].contact)].rigid) return reached;
  if (run.search().features == kMostFeatureSplits) return reached;
  ++run.search().features;
  return reached - kPart * (reached - start.t);
}

// Stops at the first of the crossings up to `end`. Out of line, so that a sub-step without events needs few registers.
[[gnu::noinline]] Reached stop_at_first(Run& run, const SubstepStart& start, double end) {
  EventSearch& s = run.search();
  std::size_t first = run.ev().guards.size();
  update_tolerances(run);
  const double reached = locate(run, start, end, first);
  if (reached == kFailed) return {kFailed, false};
  if (const double before = calc_end_before_jump(run, start, reached, first); before < reached) {
    if (!try_substep(run, start, before)) return {kFailed, false};
    if (run.ev().guards[first] < 0) return {before, false};
    if (!try_substep(run, start, reached)) return {kFailed, false};
  }
  s.tolerances[first] = std::max(s.tolerances[first], -run.ev().guards[first]);
  return {reached, true};
}

}  // namespace

Reached advance_to_event(Run& run, double now, double target, Contacts contacts, bool may_split) noexcept {
  keep_low(run);
  const SubstepStart start = begin_substep(run.get_instant(now), contacts, run.ev());
  if (!try_substep(run, start, target)) return {kFailed, false};
  keep_high(run);
  double end = find_touches(run, start, target, may_split ? kMostLooks : 0);
  if (run.plan.sought_corners && may_split && end == target) {  // the evaluation is of that time
    if (run.plan.place_corners) end = find_first_corner_time(run, start, end);
    if (!run.plan.varying.empty() && end != kFailed) end = find_burnt_knot_time(run, start, end);
    if (!run.plan.contacts.empty() && end != kFailed) end = find_feature_time(run, start, end);
  }
  if (end == kFailed) return {kFailed, false};
  const int crossings = count_crossings(run);
  if (crossings > 0 && may_split) return stop_at_first(run, start, end);
  run.report.postponed += crossings;
  return {end, false};
}

}  // namespace unlatch
