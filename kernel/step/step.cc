// The step, top to bottom:
//
//   inputs latched → forces → rows of the active modes → factor → solve → (four stages) → project → events → outputs
//
// An event splits the step: a sub-step to its end shows which guards cross zero; tries, each a fresh sub-step from the
// same beginning, locate the first of them; the events act there, and the rest of the step follows.
#include "unlatch/step.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "kernel/dynamics/one_sided.h"
#include "kernel/step/crossing.h"
#include "kernel/step/events.h"
#include "kernel/step/guards.h"
#include "kernel/step/integrator.h"
#include "kernel/step/load_state.h"
#include "kernel/step/sensors.h"

namespace unlatch {
namespace {

// Of the guard's change over the sub-step: events that would cross within this part of it are taken as simultaneous.
constexpr double kSimultaneous = 1e-6;
// Of the sub-step: an event is located when the next try would be nearer than this to the last one.
constexpr double kLocated = 1e-6;
constexpr int kMostTries = 24;
constexpr int kMostLooks = 8;  // tries of a sub-step that look for touches within it

// False if what the factorisation takes in at a node, masses and arms, is not finite.
bool has_finite_block(const PlanData& plan, const Evaluation& ev, int node) {
  const TreeNode& n = plan.nodes[at(node)];
  const Place& place = plan.places[at(n.body)];
  const double* blocks = ev.blocks.data();
  const auto is_finite = [](const auto& numbers) {
    double all[sizeof(numbers) / sizeof(double)], sum = 0;
    std::memcpy(all, &numbers, sizeof(numbers));
    for (const double number : all) sum += number;
    return std::isfinite(sum);
  };
  return is_finite(read(blocks, place, &SharedLane::inertia)) &&
         (n.leaf || is_finite(read(blocks, place, &SubtreeLane::A))) &&
         (n.joint == kNone || (is_finite(read(blocks, place, &SolverLane::arm_child)) &&
                               is_finite(read(blocks, place, &SolverLane::offset))));
}

// The factorisation stopped at a node: the motion has blown up, or its geometry is singular.
StepStatus get_pivot_status(const PlanData& plan, const Evaluation& ev, int node) {
  return has_finite_block(plan, ev, node) ? StepStatus::kSingular : StepStatus::kNotFinite;
}

// One step under way: all that its parts share. `state` is how far it has got; the evaluation is of what it tries from
// there.
struct Run {
  const PlanData& plan;
  const Inputs& inputs;
  Evaluation& ev;
  State& state;
  EventSearch& search;
  MotionLog* log;  // null if nobody wants it
  StepReport report{};
  int node = kNone;  // where a pivot vanished

  bool fail(StepStatus status) {
    report.status = status;
    return false;
  }
  bool check(int failed_node) {
    node = failed_node;
    return failed_node == kNone || fail(get_pivot_status(plan, ev, failed_node));
  }
  Instant get_instant(double t) const { return {plan, inputs, state, t}; }
};

bool crosses(const Run& run, std::size_t e) {
  return (e >= run.state.events.size() || run.state.events[e].phase == EventPhase::kArmed) &&
         run.search.guards_low[e] < 0 && run.search.guards_high[e] >= 0;
}

int count_crossings(const Run& run) {
  const double* high = run.search.guards_high.data();
  int count = 0;
  for (std::size_t e = 0; e < run.ev.guards.size(); ++e)
    if (high[e] >= 0 && crosses(run, e)) ++count;  // few stand there: the rest in two instructions
  return count;
}

// Tries the sub-step from its start to `end`: an evaluation of the latter, guards included.
bool try_substep(Run& run, const SubstepStart& start, double end) {
  ++run.report.substeps;
  const Instant now = run.get_instant(end);
  if (!run.check(integrate(now, start, end, run.ev))) return false;
  if (!run.check(evaluate(now, Changed::kVelocities, run.ev))) return false;
  update_guards(now, run.ev, run.search.stack);
  return true;
}

// The first crossing within the bracket whose ends are in guards_low and guards_high, its third point in guards_middle.
// `first`: the event.
Crossing estimate(const Run& run, const Bracket& bracket, std::size_t& first) {
  const EventSearch& s = run.search;
  Crossing least{bracket.to, false};
  bool found = false;
  for (std::size_t e = 0; e < run.ev.guards.size(); ++e) {
    if (!crosses(run, e)) continue;
    const Crossing own = interpolate(bracket, s.guards_low[e], s.guards_high[e], s.guards_middle[e]);
    if (found && !(own.time < least.time)) continue;
    least = own;
    first = e;
    found = true;
  }
  return least;
}

// The bracket less what the latest try, at `x`, rules out.
void narrow(const Run& run, double x, Bracket& bracket) {
  const EventSearch& s = run.search;
  bool crossed = false;
  for (std::size_t e = 0; e < run.ev.guards.size(); ++e) crossed |= run.ev.guards[e] >= 0 && crosses(run, e);
  const std::span<double> end = crossed ? s.guards_high : s.guards_low;
  std::copy(end.begin(), end.end(), s.guards_middle.begin());
  std::copy(run.ev.guards.begin(), run.ev.guards.end(), end.begin());
  bracket.narrow(x, crossed);
}

// Some event that crosses begins within its tolerance of zero, as the lift of a contact that has just closed.
bool begins_at_zero(const Run& run) {
  const EventSearch& s = run.search;
  bool found = false;
  for (std::size_t e = 0; e < run.ev.guards.size(); ++e)
    found |= crosses(run, e) && -s.guards_low[e] <= s.tolerances[e];
  return found;
}

// The latest try has the guard of an event about as near to zero as it is taken for zero; that of a step in it has not.
bool is_near_zero(const Run& run, std::size_t e) {
  constexpr double kSteep = 10;  // slope at the crossing over that of the whole sub-step
  return std::fabs(run.ev.guards[e]) <= kSteep * run.search.tolerances[e];
}

// The number that a report gives a guard: that of its event; behind the events that of its pair's contact.
std::int32_t get_reported_guard(const PlanData& plan, std::size_t guard) {
  const std::size_t events = plan.events.size();
  if (guard < events) return static_cast<std::int32_t>(guard);
  return static_cast<std::int32_t>(events) + plan.contact_pairs[guard - events].contact;
}

// The tries ran out: the instant of the event `first` is known to an interval that is wider than the tolerance.
void note_unlocated(Run& run, std::size_t first, double interval) {
  OpenSearch& open = run.report.open;
  ++open.unlocated;
  if (open.guard != kNone && interval <= open.interval) return;
  open.interval = interval;
  open.guard = get_reported_guard(run.plan, first);
}

// Locates the first crossing within the sub-step whose ends are in guards_low and guards_high. Leaves the evaluation of
// that instant and returns its time, or a negative number on failure. `first`: the event.
//
// Tries follow the inverse parabola, after the second only where it is through values that rise; else the middle of the
// bracket is tried. A guard that begins at zero and first falls would hold the parabola there: then the middle is tried
// until it falls short. Ends when the next try would be within the tolerance of the last one, where the guard is near
// zero: one that has a step may hold the parabola beside it.
double locate(Run& run, const SubstepStart& start, double end, std::size_t& first) {
  const double least = kSameInstant * run.plan.options.dt, tolerance = std::max(kLocated * (end - start.t), least);
  const bool at_zero = begins_at_zero(run);
  Bracket bracket{0, end - start.t, 0};
  Crossing next = estimate(run, bracket, first);
  bool falls = false;  // from the beginning of the bracket
  bool stuck = false, located = false;
  double reached = end;
  for (int i = 0; i < kMostTries && !located; ++i) {
    double x = next.time;
    const bool beside = at_zero && x - bracket.from < tolerance, steps = beside && next.sure && !falls;
    if (steps)
      x = std::max(x, bracket.from + least);
    else if (beside || falls || stuck || (i > 1 && !next.sure))
      x = 0.5 * (bracket.from + bracket.to);
    reached = std::min(start.t + x, end);  // the length may be rounded up
    if (!try_substep(run, start, reached)) return -1;
    narrow(run, x, bracket);
    if (bracket.from == x) falls = steps;
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

// A pair of shapes that is open at both ends of a sub-step, as a guard's flanks: it rises where they approach.
Flank get_flank(const Run& run, std::size_t pair, double time, std::span<const double> guards,
                std::span<const double> rates) {
  return {time, guards[run.plan.events.size() + pair], run.state.contacts[pair].closed != 0 ? 0 : -rates[pair]};
}

// The looks ran out: `pair` may touch between two flanks that are apart.
void note_unseen(Run& run, std::size_t pair, const Flank& left, const Flank& right) {
  OpenSearch& open = run.report.open;
  ++open.unseen;
  const double depth = calc_bound(left, right);
  if (open.contact != kNone && depth <= open.depth) return;
  open.depth = depth;
  open.contact = run.plan.contact_pairs[pair].contact;
}

// Looks for a touch of `pair` between two flanks that are apart. Returns its time, `right` if there is none, or a
// negative number on failure. The evaluation is of the latest try. `looks`: those that are left.
double find_touch(Run& run, const SubstepStart& start, std::size_t pair, Flank left, Flank right, int& looks) {
  const double end = right.time;
  for (; looks > 0 && may_peak(left, right); --looks) {
    const double x = calc_peak(left, right);
    if (!try_substep(run, start, start.t + x)) return -1;
    const Flank peak = get_flank(run, pair, x, run.ev.guards, run.ev.pair_rates);
    if (peak.value >= 0) return x;
    (peak.rate > 0 ? left : right) = peak;
  }
  if (may_peak(left, right)) note_unseen(run, pair, left, right);
  return end;
}

// Pairs of shapes that touch and part again within the sub-step have guards below zero at both ends. Returns a time up
// to which at least one has touched, its guards in guards_high, or `end`; a negative number on failure. `most`: looks.
double find_touches(Run& run, const SubstepStart& start, double end, int most) {
  EventSearch& s = run.search;
  const double h = end - start.t;
  double reached = h;
  int looks = most;
  for (std::size_t i = 0; i < run.state.contacts.size(); ++i) {
    if (!(s.rates_low[i] < 0 && s.rates_high[i] > 0)) continue;
    const Flank left = get_flank(run, i, 0, s.guards_low, s.rates_low);
    const Flank right = get_flank(run, i, reached, s.guards_high, s.rates_high);
    const double touch = find_touch(run, start, i, left, right, looks);
    if (touch < 0) return -1;
    if (touch == reached) continue;
    reached = touch;
    std::copy(run.ev.guards.begin(), run.ev.guards.end(), s.guards_high.begin());
    std::copy(run.ev.pair_rates.begin(), run.ev.pair_rates.end(), s.rates_high.begin());
  }
  if (reached < h) return start.t + reached;
  return looks == most || try_substep(run, start, end) ? end : -1;
}

// How far below zero the guard of an event may stand that still acts with the first.
void update_tolerances(Run& run) {
  EventSearch& s = run.search;
  for (std::size_t e = 0; e < s.tolerances.size(); ++e)
    s.tolerances[e] = crosses(run, e) ? kSimultaneous * (s.guards_high[e] - s.guards_low[e]) : 0;
}

// The latest try holds.
void accept(Run& run) {
  store_substep(run.plan, run.ev, run.state);
  rearm(run.plan, run.state, run.ev);
}

void copy(const State& from, const State& to) {
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
}

// The state and the evaluation of this instant, sensors included, which nothing else of the step reads.
void log_motion(Run& run, double now, bool begins) {
  if (run.log == nullptr) return;
  update_sensors(run.plan, run.state, run.ev);
  MotionKnot& knot = run.log->add();
  knot.time = now;
  knot.begins = begins;
  copy(run.state, knot.state);
  for (std::size_t b = 0; b < knot.accelerations.size(); ++b)
    knot.accelerations[b] = run.ev.get_acceleration(static_cast<int>(b));
  for (std::size_t i = 0; i < knot.multipliers.size(); ++i) knot.multipliers[i] = run.ev.multipliers[i];
  std::copy(run.ev.sensors.begin(), run.ev.sensors.end(), knot.sensors.begin());
}

// `tolerances`: of the events' guards. `begins`: of the knot before the events.
bool act_at(Run& run, double now, std::span<const double> tolerances, bool begins) {
  log_motion(run, now, begins);
  const auto count = [&] { return run.search.fired_count + run.search.change_count; };
  const std::int32_t acted = count();
  const StepStatus status = act(run.plan, run.inputs, now, tolerances, run.state, run.ev, run.search, run.node);
  if (status == StepStatus::kOk && count() != acted)
    log_motion(run, now, true);
  else if (run.log != nullptr && !begins)
    run.log->remove();  // no event acted: the motion goes on smoothly
  return status == StepStatus::kOk ||
         run.fail(status == StepStatus::kSingular ? get_pivot_status(run.plan, run.ev, run.node) : status);
}

// The end of the step; while a contact is closed, of the part of it that begins at `now`.
double calc_next_stop(const Run& run, double now, double end) {
  const auto is_closed = [](const ContactState& pair) { return pair.closed != 0; };
  const int parts = run.plan.contact_substeps;
  if (parts == 1 || std::none_of(run.state.contacts.begin(), run.state.contacts.end(), is_closed)) return end;
  const double slack = kSameInstant * run.plan.options.dt, begin = run.plan.get_time(run.state.header->tick);
  for (int i = 1; i < parts; ++i) {
    const double stop = begin + (end - begin) * (static_cast<double>(i) / parts);
    if (stop > now + slack) return stop;
  }
  return end;
}

// From `now` to the end of the step or of its present part, or to the first event before it. Returns the time that it
// got to.
double advance(Run& run, double now, double step_end, int& splits) {
  EventSearch& search = run.search;
  const bool may_split = splits < run.plan.options.max_splits;
  const double slack = kSameInstant * run.plan.options.dt;
  const double end = calc_next_stop(run, now, step_end);
  const double due = calc_next_due(run.plan, run.state, now);
  const bool reaches_due = may_split && due <= end + slack;
  double target = reaches_due && due < end - slack ? due : end;
  std::copy(run.ev.guards.begin(), run.ev.guards.end(), search.guards_low.begin());
  std::copy(run.ev.pair_rates.begin(), run.ev.pair_rates.end(), search.rates_low.begin());
  const SubstepStart start = begin_substep(run.plan, now, run.ev);
  if (!try_substep(run, start, target)) return step_end;

  std::copy(run.ev.guards.begin(), run.ev.guards.end(), search.guards_high.begin());
  std::copy(run.ev.pair_rates.begin(), run.ev.pair_rates.end(), search.rates_high.begin());
  target = find_touches(run, start, target, may_split ? kMostLooks : 0);
  if (target < 0) return step_end;
  double reached = target;
  const int crossings = count_crossings(run);
  const bool located = crossings > 0 && may_split;
  if (located) {
    std::size_t first = run.ev.guards.size();
    update_tolerances(run);
    reached = locate(run, start, target, first);
    if (reached < 0) return step_end;
    search.tolerances[first] = std::max(search.tolerances[first], -run.ev.guards[first]);
  } else {
    run.report.postponed += crossings;
  }
  accept(run);
  if (located || reaches_due) {
    ++splits;
    act_at(run, reached, located ? search.tolerances : search.exact, false);
  } else if (reached < step_end) {
    log_motion(run, reached, false);
    log_motion(run, reached, true);
  }
  return reached;
}

// Upper bound of the difference between a state that is handed in and the one that is kept.
Changed compare(const FinalEvaluation& kept, const State& state) {
  return kept.valid && has_same_modes(kept.state, state) ? Changed::kMotion : Changed::kState;
}

// The evaluation of the step's beginning with its inputs. If the kept one is of this state, only the commands are new,
// and the plan knows what they can change.
bool begin_step(Run& run, const State& state, double begin, Changed changed) {
  const Instant now = run.get_instant(begin);
  if (changed == Changed::kCommands) {
    if (run.plan.commanded_loads && !run.check(evaluate(now, changed, run.ev))) return false;
    if (!run.plan.commanded_events) return true;
  } else {
    copy(state, run.state);
    if (!run.check(evaluate(now, changed, run.ev))) return false;
  }
  update_guards(now, run.ev, run.search.stack);
  return true;
}

StepReport finish(const Run& run) {
  StepReport report = run.report;
  if (report.status == StepStatus::kSingular) report.joint = run.plan.nodes[at(run.node)].joint;
  report.events = run.search.fired.first(at(run.search.fired_count));
  report.audits = run.search.audits.first(at(run.search.audit_count));
  return report;
}

}  // namespace

StepReport step(const Plan& owner, const Inputs& inputs, State& state, Workspace& workspace, MotionLog* log) noexcept {
  const PlanData& plan = owner.data();
  WorkspaceData& data = workspace.data();
  FinalEvaluation& kept = data.kept;
  const Changed changed = kept.is_of(state) ? Changed::kCommands : compare(kept, state);
  kept.valid = false;  // until this step has ended well
  Run run{plan, inputs, kept.evaluation, kept.state, data.search, log};
  if (log != nullptr) log->clear();
  const double begin = plan.get_time(state.header->tick), end = plan.get_time(state.header->tick + 1);
  run.search.fired_count = run.search.audit_count = run.search.change_count = 0;

  // Events that the new inputs bring about, and those that the last step postponed, act at once.
  if (!begin_step(run, state, begin, changed)) return finish(run);
  rearm(plan, run.state, run.ev);
  if (!act_at(run, begin, run.search.exact, true)) return finish(run);

  int splits = 0;
  for (double now = begin; now < end && run.report.status == StepStatus::kOk;) now = advance(run, now, end, splits);
  if (run.report.status != StepStatus::kOk) return finish(run);
  update_sensors(plan, run.state, run.ev);
  if (!is_finite(run.state, run.ev.sensors)) run.fail(StepStatus::kNotFinite);
  if (run.report.status != StepStatus::kOk) return finish(run);

  run.report.redundant = run.ev.loop_redundant;
  ++run.state.header->tick;
  log_motion(run, end, false);
  copy(run.state, state);
  kept.valid = true;
  return finish(run);
}

StepStatus update_outputs(const Plan& owner, const Inputs& inputs, const State& state, Workspace& workspace) noexcept {
  const PlanData& plan = owner.data();
  FinalEvaluation& kept = workspace.data().kept;
  const Changed changed = compare(kept, state);
  kept.valid = false;
  Evaluation& ev = kept.evaluation;
  const Instant now{plan, inputs, state, plan.get_time(state.header->tick)};
  if (evaluate(now, changed, ev) != kNone) return StepStatus::kSingular;
  update_guards(now, ev, workspace.data().search.stack);
  update_sensors(plan, state, ev);
  copy(state, kept.state);
  kept.valid = true;
  return StepStatus::kOk;
}

const char* get_status_text(StepStatus status) noexcept {
  switch (status) {
    case StepStatus::kOk:
      return "ok";
    case StepStatus::kNotFinite:
      return "a number of the new state is not finite";
    case StepStatus::kSingular:
      return "singular pivot";
    case StepStatus::kTooManyEvents:
      return "too many events at one instant";
  }
  return "unknown";
}

}  // namespace unlatch
