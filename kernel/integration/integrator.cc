#include "kernel/integration/integrator.h"

#include <algorithm>

#include "kernel/dispatch/kernels.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/forces.h"
#include "kernel/dynamics/varying.h"
#include "kernel/elements/compliance.h"
#include "kernel/elements/kinds/friction.h"
#include "kernel/elements/kinds/load.h"
#include "kernel/integration/eighth_order.h"
#include "kernel/integration/load_state.h"
#include "kernel/integration/rigid_rows.h"
#include "kernel/joints/coordinates.h"
#include "kernel/joints/residuals.h"
#include "kernel/laws/laws.h"
#include "kernel/solver/loops/loop_rows.h"
#include "kernel/solver/loops/redundant_rows.h"

namespace unlatch {
namespace {

constexpr Sweep kCorrection{.source = Source::kNothing, .multipliers = false};

// Kinematics of the other bodies: the kernels that move bodies compute them for rigid bodies of constant mass alone.
void complete_kinematics(const PlanData& plan, double t, KnotSide side, Evaluation& ev) {
  if (plan.rigid) return;
  update_masses(plan, t, side, ev);
  update_kinematics(plan, ev);
}

// Slip and targets for accelerations of joints whose frames are those of the present poses and modes.
void update_joint_velocities(const PlanData& plan, const State& state, Evaluation& ev) {
  get_kernels(plan).update_joint_velocities(plan, ev);
  if (!plan.rigid) update_marker_biases(plan, RowTarget::kAcceleration, ev);
  if (!plan.non_tree_joints.empty()) update_non_tree_joints(plan, state, RowTarget::kAcceleration, JointSet::kAll, ev);
}

// Frames of joints, and the right-hand sides of their rows.
void update_joints(const PlanData& plan, const State& state, RowTarget target, JointSet joints, Evaluation& ev) {
  get_kernels(plan).update_joints(plan, ev, target);
  if (!plan.rigid) update_marker_biases(plan, target, ev);
  if (!plan.non_tree_joints.empty()) update_non_tree_joints(plan, state, target, joints, ev);
}
// Those that the stages and projections of a sub-step read.
JointSet get_read_joints(const PlanData& plan) {
  return plan.driven_coordinates > 0 ? JointSet::kAll : JointSet::kHolding;
}

// Gives redundant rows their part of the latest solution's multipliers.
void split_redundant_rows(const PlanData& plan, const State& state, Evaluation& ev) {
  if (ev.loop_redundant == 0) return;
  if (plan.closures.empty())
    split_dense_rows(plan, state, ev);
  else
    get_kernels(plan).split_cluster_rows(plan, state, ev);
}

// Out of line: most systems have no laws.
[[gnu::noinline]] void update_loads_by_laws(const Instant& now, Evaluation& ev) {
  update_law_loads(now, update_driving_laws(now, ev), ev.load_sizes);
}

// Rigid contacts on top of the latest solution. Systems without any pass by.
int add_rigid_rows(const Instant& now, RigidTarget target, const Sweep& sweep, RigidSet rows, Evaluation& ev) {
  return has_rigid_rows(now.plan) ? solve_rigid_rows(now, target, sweep, rows, ev) : kNone;
}

// As solve_forces(), with forces that laws size, that depend on reactions or that can only push. Where a joint has
// friction, the solution is repeated with the friction of the latest reactions.
template <class Solve>
int solve_in_rounds(const Instant& now, Sweep sweep, RigidSet rigid, Evaluation& ev, const Solve& solve) {
  const PlanData& plan = now.plan;
  if (!plan.laws.empty()) update_loads_by_laws(now, ev);
  const bool friction = !plan.frictions.empty() && has_friction(now);
  if (!plan.frictions.empty()) clear_friction(ev);
  update_forces(now, ev);
  sweep.multipliers = sweep.multipliers || friction;
  if (const int node = solve(sweep); node != kNone) return node;
  if (const int node = add_rigid_rows(now, RigidTarget::kAcceleration, sweep, rigid, ev); node != kNone) return node;
  if (sweep.multipliers) split_redundant_rows(plan, now.state, ev);
  for (int i = 0; friction && i < kFrictionSweeps; ++i) {
    update_friction(now, ev);
    update_forces(now, ev);
    get_kernels(plan).solve(plan, ev, sweep);
    if (const int node = add_rigid_rows(now, RigidTarget::kAcceleration, sweep, rigid, ev); node != kNone) return node;
    split_redundant_rows(plan, now.state, ev);
  }
  return kNone;
}

template <class Solve>
int solve_once(const Instant& now, const Sweep& sweep, Evaluation& ev, const Solve& solve) {
  update_forces(now, ev);
  if (const int node = solve(sweep); node != kNone) return node;
  if (sweep.multipliers) split_redundant_rows(now.plan, now.state, ev);
  return kNone;
}

// Forces at the present kinematics, joint frames, coordinates and loads, and the accelerations that `solve(sweep)`
// finds for them.
template <class Solve>
int solve_forces(const Instant& now, const Sweep& sweep, RigidSet rigid, Evaluation& ev, const Solve& solve) {
  const int node =
      now.plan.solved_once ? solve_once(now, sweep, ev, solve) : solve_in_rounds(now, sweep, rigid, ev, solve);
  if (node == kNone && !now.plan.rigid) update_modal_rates(now.plan, ev);
  return node;
}

// Accelerations at the present kinematics, joint frames and loads.
int solve_dynamics(const Instant& now, const Sweep& sweep, std::int32_t independent_rows, RigidSet rigid,
                   Evaluation& ev) {
  update_coordinates(now.plan, now.state, sweep.multipliers ? CoordinateSet::kAll : CoordinateSet::kDriven, ev);
  return solve_forces(now, sweep, rigid, ev, [&](const Sweep& own) {
    return get_kernels(now.plan).factor_and_solve(now.plan, now.state, ev, own, independent_rows);
  });
}

// Stages at one instant share the sizes of loads.
enum class Loads { kUpdate, kKeep };

// A stage of the sub-step from `start`; `now` holds the branches that laws had there.
int evaluate_stage(const Instant& now, Loads loads, const SubstepStart& start, Evaluation& ev) {
  complete_kinematics(now.plan, now.t, now.t > start.t ? KnotSide::kBefore : KnotSide::kAfter, ev);
  if (loads == Loads::kUpdate) update_loads(now, ev);
  update_joints(now.plan, now.state, RowTarget::kAcceleration, get_read_joints(now.plan), ev);
  return solve_dynamics(now, {.multipliers = false, .gamma_h = now.implicit.gamma_h}, start.independent_rows,
                        start.rigid_rows, ev);
}

// The end of a sub-step, on its rows: one position and one velocity projection, with one factorisation.
int project(const Instant& end, const SubstepStart& start, Evaluation& ev) {
  const PlanData& plan = end.plan;
  const Kernels& kernels = get_kernels(plan);
  complete_kinematics(plan, end.t, KnotSide::kAfter, ev);  // the next sub-step begins with this evaluation
  update_joints(plan, end.state, RowTarget::kPosition, get_read_joints(plan), ev);
  const int node = kernels.factor_and_solve(plan, end.state, ev, kCorrection, start.independent_rows);
  if (node != kNone) return node;
  if (const int failed = add_rigid_rows(end, RigidTarget::kPosition, kCorrection, start.rigid_rows, ev);
      failed != kNone)
    return failed;
  kernels.add_displacements(plan, ev);
  if (!plan.rigid) add_modal_displacements(plan, ev);

  // The velocities are projected with the new frames, but with the factor of the old ones. These differ by the
  // displacement, so that a part of the velocity residual is left that is as small as the drift of one sub-step.
  if (!plan.rigid) update_kinematics(plan, ev);
  update_joints(plan, end.state, RowTarget::kVelocity, get_read_joints(plan), ev);
  kernels.solve(plan, ev, kCorrection);
  if (const int failed = add_rigid_rows(end, RigidTarget::kVelocity, kCorrection, start.rigid_rows, ev);
      failed != kNone)
    return failed;
  kernels.add_velocities(plan, ev);
  if (plan.rigid) return kNone;
  add_modal_velocities(plan, ev);
  update_velocities(plan, ev);
  return kNone;
}

void keep_middle_places(Evaluation& ev) {
  std::copy_n(ev.law_places.begin(), ev.middle_places.size(), ev.middle_places.begin());
  std::copy(ev.altitudes.begin(), ev.altitudes.end(), ev.middle_altitudes.begin());
  std::copy(ev.travels.begin(), ev.travels.end(), ev.middle_travels.begin());
}

int integrate_explicitly(const Instant& middle, const Instant& end, const SubstepStart& start, Evaluation& ev) {
  const PlanData& plan = end.plan;
  const Kernels& kernels = get_kernels(plan);
  const double h = end.t - start.t;
  constexpr double kOuter = 1.0 / 6.0, kInner = 1.0 / 3.0;
  kernels.begin_stages(plan, ev, kOuter, 0.5 * h);
  if (const int node = evaluate_stage(middle, Loads::kUpdate, start, ev); node != kNone) return node;
  kernels.advance_stage(plan, ev, kInner, 0.5 * h);
  if (const int node = evaluate_stage(middle, Loads::kKeep, start, ev); node != kNone) return node;
  if (plan.place_corners) keep_middle_places(ev);
  kernels.advance_stage(plan, ev, kInner, h);
  if (const int node = evaluate_stage(end, Loads::kUpdate, start, ev); node != kNone) return node;
  kernels.finish_stages(plan, ev, kOuter, h);
  return project(end, start, ev);
}

// ROS2, see kernel/elements/compliance.h.
int integrate_implicitly(const Instant& now, const SubstepStart& start, double end, Evaluation& ev) {
  const PlanData& plan = now.plan;
  const Kernels& kernels = get_kernels(plan);
  const double h = end - start.t;
  const Implicit first = begin_compliance(plan, now.state, start.t, h, ev);
  kernels.restart(plan, ev);
  const Instant first_stage{plan, now.inputs, now.state, start.t, first, Branches::kHold};
  if (const int node = evaluate_stage(first_stage, Loads::kUpdate, start, ev); node != kNone) return node;
  if (plan.place_corners) keep_middle_places(ev);  // it has no stage in the middle: those of the beginning
  lead_modal_rates(plan, first, ev);
  kernels.finish_first_stage(plan, ev, h, first.gamma_h);
  const Implicit second = begin_second_stage(plan, first, ev);
  const Instant second_stage{plan, now.inputs, now.state, end, second, Branches::kHold};
  if (const int node = evaluate_stage(second_stage, Loads::kUpdate, start, ev); node != kNone) return node;
  lead_modal_rates(plan, second, ev);
  kernels.finish_second_stage(plan, ev, h, second.gamma_h);
  return project({plan, now.inputs, now.state, end}, start, ev);
}

// ROS34PW2, see kernel/integration/contact_stages.h.
int integrate_contacts(const Instant& now, const SubstepStart& start, double end, Evaluation& ev) {
  const PlanData& plan = now.plan;
  const double h = end - start.t;
  ContactStages stages(plan, start.contacts, h, ev);
  stages.begin();
  for (int i = 1; i < ContactStages::kCount; ++i) {
    const bool last = i + 1 == ContactStages::kCount;
    const double t = last ? end : start.t + h * ContactStages::get_time(i);
    const Instant stage{plan, now.inputs, now.state, t, {}, Branches::kHold};
    if (const int node = evaluate_stage(stage, Loads::kUpdate, start, ev); node != kNone) return node;
    if (!last && plan.place_corners) keep_middle_places(ev);  // at last those of 0.73 h
    stages.finish(i);
  }
  return project({plan, now.inputs, now.state, end}, start, ev);
}

// See kernel/integration/eighth_order.h.
int integrate_eighth_order(const Instant& now, const SubstepStart& start, double end, Evaluation& ev) {
  const PlanData& plan = now.plan;
  const double h = end - start.t;
  EighthOrderStages stages(plan, h, ev);
  stages.begin();
  for (int i = 1; i < EighthOrderStages::kCount; ++i) {
    const bool last = i + 1 == EighthOrderStages::kCount;
    const double t = last ? end : start.t + h * EighthOrderStages::get_time(i);
    const Instant stage{plan, now.inputs, now.state, t, {}, Branches::kHold};
    const Loads loads = EighthOrderStages::has_time_of_last(i) ? Loads::kKeep : Loads::kUpdate;
    if (const int node = evaluate_stage(stage, loads, start, ev); node != kNone) return node;
    if (i == EighthOrderStages::kMiddle && plan.place_corners) keep_middle_places(ev);
    stages.finish(i);
  }
  return project({plan, now.inputs, now.state, end}, start, ev);
}

// Only forces have changed: the factor is used again.
int evaluate_commands(const Instant& now, Evaluation& ev) {
  update_loads(now, ev);
  const int node = solve_forces(now, {}, kAllRigidRows, ev, [&](const Sweep& own) {
    get_kernels(now.plan).solve(now.plan, ev, own);
    return kNone;
  });
  if (!now.plan.laws.empty()) update_other_laws(now, ev);
  return node;
}

}  // namespace

void update_kinematics(const PlanData& plan, Evaluation& ev) noexcept {
  update_markers(plan, ev);
  get_kernels(plan).update_kinematics(plan, ev);
  update_varying_kinematics(plan, ev);
  update_flexible_kinematics(plan, ev);
}

void update_velocities(const PlanData& plan, Evaluation& ev) noexcept {
  update_markers(plan, ev);
  get_kernels(plan).update_angular_velocities(plan, ev);
}

void update_coordinates(const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev) noexcept {
  if (set == CoordinateSet::kDriven && plan.driven_coordinates == 0) return;
  const std::size_t rotations = measure_coordinates(plan, state, set, ev);
  if (rotations == 0) return;
  get_kernels(plan).update_angles(ev.rotation_sines.data(), ev.rotation_cosines.data(), rotations);
  unwind_angles(plan, state, set, ev);
}

void update_forces(const Instant& now, Evaluation& ev) noexcept {
  get_kernels(now.plan).init_forces(now.plan, ev);
  add_forces(now, ev);
}

void update_joints(const PlanData& plan, const State& state, RowTarget target, Evaluation& ev) noexcept {
  update_joints(plan, state, target, JointSet::kAll, ev);
}

int evaluate(const Instant& now, Changed changed, Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  switch (changed) {
    case Changed::kCommands:
      return evaluate_commands(now, ev);
    case Changed::kVelocities:
      update_joint_velocities(plan, now.state, ev);
      break;
    case Changed::kState:
      load_modes(plan, now.state, ev);
      [[fallthrough]];
    case Changed::kMotion:
      load_motion(plan, now.state, ev);
      update_masses(plan, now.t, KnotSide::kAfter, ev);
      update_kinematics(plan, ev);
      [[fallthrough]];
    case Changed::kModes:
      update_loads(now, ev);
      update_joints(plan, now.state, RowTarget::kAcceleration, ev);
  }
  const int node = solve_dynamics(now, {}, kAllRows, kAllRigidRows, ev);
  if (!plan.laws.empty() && node == kNone) update_other_laws(now, ev);
  return node;
}

SubstepStart begin_substep(const Instant& now, Contacts contacts, Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  get_kernels(plan).begin_substep(plan, ev);
  keep_cluster_rows(ev);
  std::copy_n(ev.branches.begin(), ev.branches.size(), ev.branches_at_start.begin());
  SubstepStart start;  // most of its rows are never used
  start.t = now.t;
  start.method = contacts;
  start.independent_rows = ev.loop_count - ev.loop_redundant;
  start.rigid_rows = has_rigid_rows(plan) ? get_independent_rigid_rows(ev) : RigidSet{0};
  if (contacts == Contacts::kImplicit) begin_contact_rows(now, ev, start.contacts);
  return start;
}

int integrate(const Instant& now, const SubstepStart& start, double end, Evaluation& ev) noexcept {
  const double h = end - start.t;
  std::copy_n(ev.branches_at_start.begin(), ev.branches.size(), ev.branches.begin());
  if (is_stiff(now.plan, now.state, start.t + 0.5 * h)) return integrate_implicitly(now, start, end, ev);
  if (start.contacts.count > 0) return integrate_contacts(now, start, end, ev);
  if (start.method == Contacts::kEighthOrder) return integrate_eighth_order(now, start, end, ev);
  const Instant middle{now.plan, now.inputs, now.state, start.t + 0.5 * h, {}, Branches::kHold};
  const Instant last{now.plan, now.inputs, now.state, end, {}, Branches::kHold};
  return integrate_explicitly(middle, last, start, ev);
}

int apply_impulse(const PlanData& plan, Source source, State& state, Evaluation& ev) noexcept {
  const Kernels& kernels = get_kernels(plan);
  update_joints(plan, state, RowTarget::kVelocity, ev);
  const int node = kernels.factor_and_solve(plan, state, ev, {.source = source}, kAllRows);
  if (node != kNone) return node;
  kernels.add_velocities(plan, ev);
  if (!plan.rigid) add_modal_velocities(plan, ev);
  update_markers(plan, ev);
  store_motion(plan, ev, state);
  return kNone;
}

}  // namespace unlatch
