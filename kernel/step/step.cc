// The step, top to bottom:
//
//   inputs latched → forces → rows of the active modes → factor → solve → (four stages) → project → events → outputs
//
// An event splits the step: a sub-step to its end shows which guards cross zero; two iterations, each a fresh sub-step
// from the same beginning, locate the first of them; the events act there, and the rest of the step follows.
#include "unlatch/step.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "kernel/solver/tree_solver.h"
#include "kernel/step/events.h"
#include "kernel/step/guards.h"
#include "kernel/step/integrator.h"
#include "kernel/step/sensors.h"

namespace unlatch {
namespace {

// Of the guard's change over the sub-step: events that would cross within this part of it are taken as simultaneous.
constexpr double kSimultaneous = 1e-6;

// Why factor() stopped at a node: the motion has blown up, or its geometry is singular.
StepStatus get_pivot_status(const Plan& plan, const Workspace& ws, int node) {
  return has_finite_block(plan, ws, node) ? StepStatus::kSingular : StepStatus::kNotFinite;
}

// How one step goes on: everything that its parts share.
struct Run {
  const Plan& plan;
  const Inputs& inputs;
  Workspace& ws;
  StepReport report{};
  int node = kNone;  // where a pivot vanished

  bool fail(StepStatus status) {
    report.status = status;
    return false;
  }
  bool check(int failed_node) {
    node = failed_node;
    return failed_node == kNone || fail(get_pivot_status(plan, ws, failed_node));
  }
};

bool is_armed(const State& state, std::size_t e) { return state.events[e].phase == EventPhase::kArmed; }

bool crosses(const Workspace& ws, std::size_t e) {
  return is_armed(ws.accepted, e) && ws.guards_low[e] < 0 && ws.guards_high[e] >= 0;
}

int count_crossings(const Workspace& ws) {
  const double* high = ws.guards_high.data();
  int count = 0;
  for (std::size_t e = 0; e < ws.guards.size(); ++e)
    if (high[e] >= 0 && crosses(ws, e)) ++count;  // few stand there: the rest in two instructions
  return count;
}

// Tries the sub-step from `now` to `end`: the latter in the lanes, evaluated, its guards in ws.guards.
bool try_substep(Run& run, double now, double end) {
  ++run.report.substeps;
  if (!run.check(integrate(run.plan, run.inputs, run.ws.accepted, now, end, run.ws))) return false;
  if (!run.check(evaluate_end(run.plan, run.inputs, run.ws.accepted, end, run.ws))) return false;
  update_guards(run.plan, run.inputs, run.ws.accepted, end, run.ws, run.ws.guards);
  return true;
}

// Where the straight line through (0, low) and (h, high) crosses zero.
double interpolate(double low, double high, double h) { return h * (low / (low - high)); }

// Where the inverse parabola through (0, low), (x, middle), (h, high) crosses zero; the chord of the bracketing pair
// instead where the parabola leaves the bracket.
double interpolate(double low, double x, double middle, double h, double high) {
  const double left = middle >= 0 ? 0 : x, right = middle >= 0 ? x : h;
  const double at_left = middle >= 0 ? low : middle, at_right = middle >= 0 ? middle : high;
  const double chord = left + interpolate(at_left, at_right, right - left);
  if (!((low < middle && middle < high))) return chord;
  const double parabola =
      x * (low * high) / ((middle - low) * (middle - high)) + h * (low * middle) / ((high - low) * (high - middle));
  return parabola > left && parabola < right ? parabola : chord;
}

// Locates the first crossing within the sub-step whose ends are in guards_low and guards_high. Leaves the lanes there
// and returns its time, or a negative number on failure. `first`: the event.
double locate(Run& run, double now, double end, std::size_t& first) {
  Workspace& ws = run.ws;
  const double h = end - now;
  double x = h, reached = end;
  for (int iteration = 0; iteration < 2; ++iteration) {
    const double previous = x;
    x = h;
    for (std::size_t e = 0; e < ws.guards.size(); ++e) {
      if (!crosses(ws, e)) continue;
      const double estimate = iteration == 0
                                  ? interpolate(ws.guards_low[e], ws.guards_high[e], h)
                                  : interpolate(ws.guards_low[e], previous, ws.guards_middle[e], h, ws.guards_high[e]);
      if (estimate < x || first == ws.guards.size()) {
        x = estimate;
        first = e;
      }
    }
    reached = std::min(now + x, end);  // h may be rounded up
    if (!try_substep(run, now, reached)) return -1;
    std::copy(ws.guards.begin(), ws.guards.end(), ws.guards_middle.begin());
  }
  return reached;
}

// After locate(): which events have reached their guards, rounding and simultaneity granted.
void update_tolerances(Workspace& ws, std::size_t first) {
  for (std::size_t e = 0; e < ws.guards.size(); ++e)
    ws.tolerances[e] = crosses(ws, e) ? kSimultaneous * (ws.guards_high[e] - ws.guards_low[e]) : 0;
  ws.tolerances[first] = std::max(ws.tolerances[first], -ws.guards[first]);
}

// The latest try holds.
void accept(Run& run) {
  Workspace& ws = run.ws;
  store_motion(run.plan, ws, ws.accepted);
  for (std::size_t i = 0; i < run.plan.coordinates.size(); ++i) {
    const PlanCoordinate& c = run.plan.coordinates[i];
    if (c.row >= kRotX) ws.accepted.joints[static_cast<std::size_t>(c.joint)].angle[c.row - kRotX] = ws.coordinates[i];
  }
  rearm(run.plan, ws.accepted, ws);
}

bool act_at(Run& run, double now) {
  const StepStatus status = act(run.plan, run.inputs, now, run.ws.accepted, run.ws, run.node);
  return status == StepStatus::kOk ||
         run.fail(status == StepStatus::kSingular ? get_pivot_status(run.plan, run.ws, run.node) : status);
}

// From `now` to the end of the step, or to the first event before it. Returns where it got to.
double advance(Run& run, double now, double end, int& splits) {
  Workspace& ws = run.ws;
  const bool may_split = splits < run.plan.options.max_splits;
  const double slack = kSameInstant * run.plan.options.dt;
  const double due = calc_next_due(run.plan, ws.accepted, now);
  const bool reaches_due = may_split && due <= end + slack;
  const double target = reaches_due && due < end - slack ? due : end;
  std::copy(ws.guards.begin(), ws.guards.end(), ws.guards_low.begin());
  std::fill(ws.tolerances.begin(), ws.tolerances.end(), 0.0);
  keep_start(run.plan, ws);
  if (!try_substep(run, now, target)) return end;

  double reached = target;
  std::copy(ws.guards.begin(), ws.guards.end(), ws.guards_high.begin());
  const int crossings = count_crossings(ws);
  if (crossings > 0 && may_split) {
    std::size_t first = ws.guards.size();
    reached = locate(run, now, target, first);
    if (reached < 0) return end;
    update_tolerances(ws, first);
  } else {
    run.report.postponed += crossings;
  }
  accept(run);
  if (may_split && (crossings > 0 || reaches_due)) {
    ++splits;
    act_at(run, reached);
  }
  return reached;
}

// Whether all is finite that a step makes: what is not survives being summed.
bool is_finite(const State& state, std::span<const double> sensors) {
  double sum = 0;
  for (const BodyState& b : state.bodies)
    sum += ((b.p.x + b.p.y) + (b.p.z + b.q.w)) + ((b.q.x + b.q.y) + (b.q.z + b.v.x)) +
           ((b.v.y + b.v.z) + (b.w.x + b.w.y)) + b.w.z;
  for (const JointState& j : state.joints)
    sum += (j.angle[0] + j.angle[1]) + (j.angle[2] + j.offset.x) + (j.offset.y + j.offset.z);
  for (const double number : state.extras) sum += number;
  for (const double number : sensors) sum += number;
  return std::isfinite(sum);
}

void copy(const State& from, const State& to) {
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
}

// The beginning of a step, evaluated with its inputs. What the workspace holds of the step before is that step's end,
// and serves if nobody has touched the state since: only the inputs are new, and the plan knows what they can change.
bool begin_step(Run& run, const State& state, double begin) {
  Workspace& ws = run.ws;
  const std::span<const std::byte> now = state.get_bytes(), then = ws.accepted.get_bytes();
  const bool goes_on = ws.settled && std::memcmp(now.data(), then.data(), now.size()) == 0;
  ws.settled = false;
  if (goes_on) {
    if (run.plan.commanded_loads) evaluate_forces(run.plan, run.inputs, ws.accepted, begin, ws);
    if (!run.plan.commanded_events) return true;
  } else {
    copy(state, ws.accepted);
    if (!run.check(evaluate(run.plan, run.inputs, ws.accepted, begin, ws))) return false;
  }
  update_guards(run.plan, run.inputs, ws.accepted, begin, ws, ws.guards);
  return true;
}

StepReport finish(const Run& run) {
  StepReport report = run.report;
  if (report.status == StepStatus::kSingular) report.joint = run.plan.nodes[static_cast<std::size_t>(run.node)].joint;
  report.events = run.ws.fired.first(static_cast<std::size_t>(run.ws.fired_count));
  report.audits = run.ws.audits.first(static_cast<std::size_t>(run.ws.audit_count));
  return report;
}

}  // namespace

StepReport step(const Plan& plan, const Inputs& inputs, State& state, Workspace& workspace) noexcept {
  Run run{plan, inputs, workspace};
  const double begin = static_cast<double>(state.header->tick) * plan.options.dt;
  const double end = static_cast<double>(state.header->tick + 1) * plan.options.dt;
  workspace.fired_count = workspace.audit_count = 0;
  std::fill(workspace.tolerances.begin(), workspace.tolerances.end(), 0.0);

  // What the new inputs bring about, and what the last step postponed, acts at once.
  if (!begin_step(run, state, begin)) return finish(run);
  rearm(plan, workspace.accepted, workspace);
  if (!act_at(run, begin)) return finish(run);

  int splits = 0;
  for (double now = begin; now < end && run.report.status == StepStatus::kOk;) now = advance(run, now, end, splits);
  if (run.report.status != StepStatus::kOk) return finish(run);
  update_sensors(plan, workspace.accepted, workspace);
  if (!is_finite(workspace.accepted, workspace.sensors)) run.fail(StepStatus::kNotFinite);
  if (run.report.status != StepStatus::kOk) return finish(run);

  run.report.redundant = workspace.loop_redundant;
  ++workspace.accepted.header->tick;
  copy(workspace.accepted, state);
  workspace.settled = true;
  return finish(run);
}

StepStatus update_outputs(const Plan& plan, const Inputs& inputs, const State& state, Workspace& workspace) noexcept {
  const double now = static_cast<double>(state.header->tick) * plan.options.dt;
  if (evaluate(plan, inputs, state, now, workspace) != kNone) return StepStatus::kSingular;
  update_guards(plan, inputs, state, now, workspace, workspace.guards);
  update_sensors(plan, state, workspace);
  copy(state, workspace.accepted);
  workspace.settled = true;
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
