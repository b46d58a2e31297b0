// The step, top to bottom:
//
//   inputs latched → forces → rows of the active modes → factor → solve → (four stages) → project → events → outputs
//
// The four stages of RK4 are three calls of evaluate_stage(): the first stage is the evaluation that the previous
// sub-step ended with, kept by begin_substep(). With the projection and the evaluation of the end a sub-step has five
// factorisations (integrator.cc).
//
// An event splits the step: a search locates the first (event_search.h), the events act there (events.h), and the rest
// of the step follows. Until a try is accepted, Run::state is the beginning of the sub-step; the present motion is in
// the evaluation alone.
#include "unlatch/step.h"

#include <algorithm>
#include <cstring>

#include "kernel/elements/kinds/contact/contact_parts.h"
#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/events/corner_marks.h"
#include "kernel/events/corners.h"
#include "kernel/events/event_search.h"
#include "kernel/events/events.h"
#include "kernel/events/guards.h"
#include "kernel/events/rigid_friction.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/load_state.h"
#include "kernel/integration/rigid_rows.h"
#include "kernel/integration/run.h"
#include "kernel/quantities/quantities.h"

namespace unlatch {
namespace {

// Accepts the latest try: its motion becomes that of the state.
void accept(Run& run) {
  store_substep(run.plan, run.ev(), run.state());
  if (has_rigid_rows(run.plan)) store_rigid_forces(run.plan, run.ev(), run.state());
  rearm(run.plan, run.state(), run.ev());
}

void copy(const State& from, const State& to) {
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
}

// kPresent: sensors and quantities of this very evaluation are there.
enum class Readings { kStale, kPresent };

// Logs the state and the evaluation of this instant, with sensors and quantities, which only the log reads.
void log_motion(Run& run, double now, bool begins, Readings readings) {
  if (run.log == nullptr) return;
  if (readings == Readings::kStale) update_readings(run.get_instant(now), run.ev(), run.data.unread.data());
  MotionKnot& knot = run.log->add();
  fill_knot(run, now, knot);
  knot.begins = begins;
}

CornerCourse get_course(const Run& run) {
  const Evaluation& ev = run.ev();
  return {get_corner_places(run.search()), get_corner_places(ev), ev.branches_at_start, ev.branches};
}

// Logs the end of the sub-step that began at `begin`. A law that jumps there has the value that the stages approached;
// then the evaluation is again that of the end, to the bit, with its readings. True if the motion has a corner there.
bool log_end(Run& run, double begin, double now, Readings readings) {
  if (run.log == nullptr) return false;
  const CornerMarks marks = mark_corners(run.plan, run.state(), begin, now, get_course(run));
  const bool ends_piece = marks.motion.at_end || (!run.plan.varying.empty() && is_at_burnt_knot(run.plan, run.ev()));
  if (marks.motion.at_begin) run.log->mark_corner();
  if (marks.readings.at_begin) run.log->mark_reading_corner();
  if (marks.jumps) {
    hold_branches(run.plan, begin, now, get_course(run), run.ev().branches);
    Instant before = run.get_instant(now);
    before.branches = Branches::kHold;
    (void)evaluate(before, Changed::kCommands, run.ev());  // the factor is that of the end
  }
  log_motion(run, now, false, marks.jumps ? Readings::kStale : readings);
  if (ends_piece) run.log->mark_corner();
  if (marks.readings.at_end) run.log->mark_reading_corner();
  if (!marks.jumps) return ends_piece;
  (void)evaluate(run.get_instant(now), Changed::kCommands, run.ev());
  update_readings(run.get_instant(now), run.ev(), run.data.unread.data());
  return true;
}

// The latest knot of the log, before events act.
enum class Latest {
  kBegin,   // the beginning of the step
  kEnd,     // the end of a sub-step: the motion goes on smoothly unless an event acts
  kCorner,  // likewise, but it does not go on smoothly
};

// Executes events at `now`, and logs what follows. `tolerances`: of the guards.
bool act_at(Run& run, double now, std::span<const double> tolerances, Latest latest) {
  const auto count = [&] { return run.events().fired_count + run.events().change_count; };
  const std::int32_t acted = count();
  const StepStatus status = act(run, now, tolerances);
  if ((status == StepStatus::kOk && count() != acted) || latest == Latest::kCorner)
    log_motion(run, now, true, Readings::kStale);
  else if (run.log != nullptr && latest == Latest::kEnd)
    run.log->remove();
  return status == StepStatus::kOk ||
         run.fail(status == StepStatus::kSingular ? get_pivot_status(run.plan, run.ev(), run.node) : status);
}

// The end of the step; while a contact is closed, the end of the part of the step that begins at `now`.
double calc_next_stop(const Run& run, const ContactParts& cut, double now, double end) {
  const int parts = cut.count;
  if (cut.of_rest) return parts > 1 ? now + (end - now) / parts : end;
  const double slack = run.plan.get_slack(), begin = run.plan.get_time(run.state().header->tick);
  for (int i = 1; i < parts; ++i) {
    const double stop = begin + (end - begin) * (static_cast<double>(i) / parts);
    if (stop > now + slack) return stop;
  }
  return end;
}

ContactParts choose_parts(const Run& run, double now, double end) {
  return run.plan.contacts.empty() ? ContactParts{}
                                   : choose_contact_parts(run.plan, run.state(), now, end - now, run.ev());
}

// The end of the sub-step from `now`: the first corner whose time is known, unless the step has been split at as many
// corners as it may be, which is reported; else `target`.
[[gnu::noinline]] double calc_time_corner(Run& run, double now, double target) {
  const double corner = find_time_corner(run.plan, run.state(), now, target);
  if (corner >= target) return target;
  if (run.search().corners < kMostCornerSplits) return corner;
  ++run.report.open.corners;
  return target;
}

// Advances from `now` to the end of the step or of its present part, or to the first event or corner of a law or table
// before it. Returns the time that is reached; on failure the end of the step.
double advance(Run& run, double now, double step_end, int& splits) {
  const bool may_split = splits < run.plan.options.max_splits;
  const double slack = run.plan.get_slack();
  if (!run.state().rigid_slips.empty() && !begin_slips(run, now)) return step_end;
  const ContactParts parts = choose_parts(run, now, step_end);
  const double end = calc_next_stop(run, parts, now, step_end);
  const double due = calc_next_due(run.plan, run.state(), now);
  const bool reaches_due = may_split && due <= end + slack;
  const double planned = reaches_due && due < end - slack ? due : end;
  const double target = may_split && run.plan.time_corners ? calc_time_corner(run, now, planned) : planned;
  const Reached reached = advance_to_event(run, now, target, parts.contacts, may_split);
  if (reached.time == kFailed) return step_end;
  accept(run);
  if (target < planned && reached.time == target) ++run.search().corners;
  if (reached.at_event || (reaches_due && reached.time == planned)) {
    ++splits;
    const bool corner = log_end(run, now, reached.time, Readings::kStale);
    act_at(run, reached.time, reached.at_event ? run.search().tolerances : run.data.exact,
           corner ? Latest::kCorner : Latest::kEnd);
  } else if (reached.time < step_end) {
    log_end(run, now, reached.time, Readings::kStale);
    log_motion(run, reached.time, true, Readings::kPresent);
  }
  return reached.time;
}

// Logs the end of the step, whose latest sub-step began at `begin`: there may have been events at its end.
void log_last(Run& run, double begin, double end) {
  if (run.log == nullptr) return;
  const MotionKnot& latest = run.log->get_knots().back();
  if (latest.begins && latest.time == end)
    log_motion(run, end, false, Readings::kPresent);
  else
    log_end(run, begin, end, Readings::kPresent);
}

// What may differ between `state` and the kept one.
Changed compare(const FinalEvaluation& kept, const State& state) {
  return kept.valid && has_same_modes(kept.state, state) ? Changed::kMotion : Changed::kState;
}

// The readings of the step's beginning are those that the last one ended with: what the new inputs change is no
// reading.
Readings get_first_readings(const Run& run, Changed changed) {
  const bool are_kept = run.log != nullptr && changed == Changed::kCommands && !run.plan.commanded_loads &&
                        !is_any_reading_commanded(run.plan);
  return are_kept ? Readings::kPresent : Readings::kStale;
}

// The evaluation of the step's beginning with its inputs. If the kept one is of this state, only the commands are new,
// and the plan says whether loads or events depend on them. `repeated`: the commands are those of the kept one, too.
bool begin_step(Run& run, const State& state, double begin, Changed changed, bool repeated) {
  const Instant now = run.get_instant(begin);
  if (changed == Changed::kCommands) {
    if (run.plan.commanded_loads && !run.check(evaluate(now, changed, run.ev()))) return false;
    if (!run.plan.commanded_events || (repeated && keeps_guards(run.plan))) return true;
  } else {
    copy(state, run.state());
    if (!run.check(evaluate(now, changed, run.ev()))) return false;
  }
  update_guards(now, run.ev(), run.search().stack);
  return true;
}

// False if a table was left at the end of the step whose ends are errors.
bool check_tables(Run& run) {
  const std::span<const TableExit> exits = run.ev().table_exits;
  for (std::size_t i = 0; i < exits.size(); ++i) {
    if (exits[i].axis == kNone || exits[i].end != TableAxis::End::kError) continue;
    run.report.table = static_cast<std::int32_t>(i);
    run.report.exit = exits[i];
    return run.fail(StepStatus::kOutsideTable);
  }
  return true;
}

StepReport finish(const Run& run) {
  StepReport report = run.report;
  if (report.status == StepStatus::kSingular) report.joint = run.plan.nodes[at(run.node)].joint;
  if (report.status == StepStatus::kRigidContact) {
    report.contact = run.data.kept.evaluation.rigid.failed;
    report.wedged = run.data.kept.evaluation.rigid.wedged;
    report.degenerate = run.data.kept.evaluation.rigid.degenerate;
  }
  report.events = run.events().fired.first(at(run.events().fired_count));
  report.audits = run.events().audits.first(at(run.events().audit_count));
  return report;
}

}  // namespace

StepReport step(const Plan& owner, const Inputs& inputs, State& state, Workspace& workspace, MotionLog* log) noexcept {
  const PlanData& plan = get_data(owner);
  WorkspaceData& data = get_data(workspace);
  FinalEvaluation& kept = data.kept;
  const Changed changed = kept.is_of(state) ? Changed::kCommands : compare(kept, state);
  const bool repeated = changed == Changed::kCommands && kept.has_commands(inputs.commands);
  kept.valid = false;  // until this step has ended well
  Run run{plan, inputs, data, log};
  if (log != nullptr) log->clear();
  const double begin = plan.get_time(state.header->tick), end = plan.get_time(state.header->tick + 1);
  run.events().fired_count = run.events().audit_count = run.events().change_count = 0;
  run.search().corners = run.search().features = 0;
  std::fill(run.search().rigid_returns.begin(), run.search().rigid_returns.end(), std::int64_t{0});
  std::fill(run.search().rigid_lifts.begin(), run.search().rigid_lifts.end(), -HUGE_VAL);

  // Events that the new inputs cause, and those that the last step postponed, act at once.
  if (!begin_step(run, state, begin, changed, repeated)) return finish(run);
  rearm(plan, run.state(), run.ev());
  log_motion(run, begin, true, get_first_readings(run, changed));
  if (!act_at(run, begin, run.data.exact, Latest::kBegin)) return finish(run);

  int splits = 0;
  double last = begin;  // the beginning of the latest sub-step
  for (double now = begin; now < end && run.report.status == StepStatus::kOk;) {
    last = now;
    now = advance(run, now, end, splits);
  }
  if (run.report.status != StepStatus::kOk) return finish(run);
  update_readings(run.get_instant(end), run.ev(), run.data.unread.data());
  if (!is_finite(run.state(), run.ev().sensors)) run.fail(StepStatus::kNotFinite);
  if (run.plan.law_numbers.strict && run.report.status == StepStatus::kOk) check_tables(run);
  if (run.report.status != StepStatus::kOk) return finish(run);

  run.report.redundant = run.ev().loop_redundant;
  ++run.state().header->tick;
  log_last(run, last, end);
  copy(run.state(), state);
  kept.keep(inputs.commands);
  return finish(run);
}

StepStatus update_outputs(const Plan& owner, const Inputs& inputs, const State& state, Workspace& workspace) noexcept {
  const PlanData& plan = get_data(owner);
  FinalEvaluation& kept = get_data(workspace).kept;
  const Changed changed = compare(kept, state);
  kept.valid = false;
  Evaluation& ev = kept.evaluation;
  const Instant now{plan, inputs, state, plan.get_time(state.header->tick)};
  if (const int node = evaluate(now, changed, ev); node != kNone) return get_pivot_status(plan, ev, node);
  update_guards(now, ev, get_data(workspace).search.stack);
  update_readings(now, ev);
  copy(state, kept.state);
  kept.keep(inputs.commands);
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
    case StepStatus::kOutsideTable:
      return "a table was left";
    case StepStatus::kRigidContact:
      return "rigid contacts cannot be held";
  }
  return "unknown";
}

}  // namespace unlatch
