#include <algorithm>
#include <array>
#include <cstring>

#include "kernel/cost/load_times.h"
#include "kernel/cost/measured.h"
#include "kernel/cost/step_counts.h"
#include "kernel/elements/kinds/friction.h"
#include "kernel/events/limits.h"
#include "kernel/integration/eighth_order.h"
#include "kernel/integration/integrator.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch {
namespace {

using cost::Primitive;

// Instructions of one call of each primitive.
class CallCosts {
 public:
  // `driven`: with the coordinates that stages read.
  CallCosts(const cost::Measured& measured, const cost::Work& work, const cost::Work& driven) {
    for (const cost::Coefficient& c : measured.coefficients) {
      costs_[static_cast<std::size_t>(c.primitive)] += c.instructions * work[c.unit];
      driven_[static_cast<std::size_t>(c.primitive)] += c.instructions * driven[c.unit];
      if (c.unit == cost::Unit::kOne) fixed_[static_cast<std::size_t>(c.primitive)] += c.instructions;
    }
  }
  double operator[](Primitive primitive) const { return costs_[static_cast<std::size_t>(primitive)]; }
  double in_stage(Primitive primitive) const { return driven_[static_cast<std::size_t>(primitive)]; }
  // What does not depend on the plan.
  double get_fixed(Primitive primitive) const { return fixed_[static_cast<std::size_t>(primitive)]; }

 private:
  std::array<double, cost::kPrimitives> costs_{}, driven_{}, fixed_{};
};

// Parts of a plan that decide what is called at all.
struct Features {
  bool rigid, loops, laws, contacts, angles, stage_angles, commanded_loads, commanded_events, compliant;
  bool time_corners;    // step() looks for them before each sub-step
  double sweeps;        // solutions with friction, beside the first
  double rigid_rows;    // of rigid contacts, at most
  double contact_rows;  // of parts that are implicit in the forces of contacts; 0: there are none
  double eighth_moves;  // instructions by which parts of order eight move all bodies; 0: there are none
};

// Instructions of EighthOrderStages for a body and for an auxiliary state, on any target: forty-four weights that are
// not zero, each for 13 numbers of a body, with five instructions for each, and 4000 to read and write them and the
// rates of eleven stages. On x86-64 they were a third of that.
constexpr double kEighthOfBody = 44 * 13 * 5 + 4000, kEighthOfAuxiliary = 44 * 5 + 300;

// Some integration may be ROS2: kernel/elements/compliance.h.
bool may_be_stiff(const PlanData& plan) {
  const auto is_implicit = [](const PlanFlexible& body) { return body.implicit; };
  return !plan.compliant.empty() || std::any_of(plan.flexible.begin(), plan.flexible.end(), is_implicit);
}

Features get_features(const PlanData& plan, const cost::Work& driven) {
  return {.rigid = plan.rigid,
          .loops = !plan.non_tree_joints.empty(),
          .laws = !plan.laws.empty(),
          .contacts = !plan.contacts.empty(),
          .angles = plan.rotation_count > 0,
          .stage_angles = driven[cost::Unit::kAngleEights] > 0,
          .commanded_loads = plan.commanded_loads,
          .commanded_events = plan.commanded_events,
          .compliant = may_be_stiff(plan),
          .time_corners = plan.time_corners,
          .sweeps = plan.frictions.empty() ? 0.0 : kFrictionSweeps,
          .rigid_rows = driven[cost::Unit::kRigidRows],
          .contact_rows = driven[cost::Unit::kContactRows],
          .eighth_moves = may_be_implicit(plan)
                              ? kEighthOfBody * static_cast<double>(plan.bodies.size()) +
                                    kEighthOfAuxiliary * static_cast<double>(plan.initial_auxiliary.size())
                              : 0};
}

enum class Place { kStage, kEnd };

// Adds calls of primitives to a row.
class RowCost {
 public:
  RowCost(const CallCosts& costs, const Features& features) : costs_(costs), features_(features) {}

  // Frames of joints and what they prescribe; of loops too.
  void add_joints(Primitive of_tree, double calls = 1) {
    row_.bodies += calls * (costs_[of_tree] + (features_.loops ? costs_[Primitive::kLoopJoints] : 0));
  }
  void add_bodies(Primitive primitive, double calls = 1) { row_.bodies += calls * costs_[primitive]; }
  void add_moves(double instructions) { row_.bodies += instructions; }
  void add_loads(double calls) { row_.forces += calls * costs_[Primitive::kLoads]; }
  void add_other_laws() { row_.forces += features_.laws ? costs_[Primitive::kOtherLaws] : 0; }
  // Forces and accelerations at one instant: integrator.cc, solve_dynamics(). Stages find no multipliers, and so split
  // none, but for friction.
  void add_dynamics(double calls, Place of) {
    const bool stage = of == Place::kStage;
    const auto coordinates = [&](Primitive primitive) {
      return stage ? costs_.in_stage(primitive) : costs_[primitive];
    };
    row_.forces += calls * coordinates(Primitive::kCoordinates);
    if (stage ? features_.stage_angles : features_.angles)
      row_.forces += calls * (coordinates(Primitive::kAngles) + coordinates(Primitive::kUnwind));
    const bool reactions = !stage || features_.sweeps > 0;
    add_solution(calls, reactions ? Primitive::kFactor : Primitive::kFactorStage, reactions);
  }
  // Likewise with the factor that is there: evaluate_commands().
  void add_commands() { add_solution(1, Primitive::kSolve, true); }
  // Solutions with the factor that is there, and what rigid contacts add to each solution.
  void add_solver(Primitive primitive, double calls) { row_.solver += calls * costs_[primitive]; }
  void add_rigid_rows(double calls) {
    if (features_.rigid_rows == 0) return;
    row_.solver += calls * (costs_[Primitive::kRigidRows] + (features_.rigid_rows + 1) * costs_[Primitive::kSolve]);
  }
  void add(Primitive primitive, double calls = 1) { row_.rest += calls * costs_[primitive]; }
  // Of what step() does itself, that for a sub-step, and the rest, once for a step: copies and checks of the state and
  // of sensors. Corners at known times and rigid forces are loops for each sub-step.
  void add_own_of_substep() {
    row_.rest += is_own_repeated() ? costs_[Primitive::kStep] : costs_.get_fixed(Primitive::kStep);
  }
  void add_own_of_step() {
    if (!is_own_repeated()) row_.rest += costs_[Primitive::kStep] - costs_.get_fixed(Primitive::kStep);
  }

  CostRow repeat(const char* phase, double calls) const {
    return {phase, calls, calls * row_.bodies, calls * row_.forces, calls * row_.solver, calls * row_.rest};
  }

 private:
  // Of elements and laws; `solver`: of the first solution, those of friction follow.
  void add_solution(double calls, Primitive solver, bool reactions) {
    const double sweeps = features_.sweeps;
    row_.forces += calls * ((1 + sweeps) * (costs_[Primitive::kOwnForces] + costs_[Primitive::kForces]) +
                            sweeps * costs_[Primitive::kFriction]);
    if (features_.laws) row_.forces += calls * costs_[Primitive::kLaws];
    row_.solver += calls * (costs_[solver] + sweeps * costs_[Primitive::kSolve]);
    if (features_.loops && reactions) row_.solver += calls * (1 + sweeps) * costs_[Primitive::kSplit];
    add_rigid_rows(calls * (1 + sweeps));
  }

  bool is_own_repeated() const { return features_.time_corners || features_.contacts; }

  const CallCosts& costs_;
  const Features& features_;
  CostRow row_{};
};

// evaluate(): of a new state, of velocities alone, of modes alone.
void add_evaluation(RowCost& row, Changed changed) {
  if (changed == Changed::kVelocities) {
    row.add(Primitive::kEvaluateEnd);
    row.add_joints(Primitive::kJointVelocities);
  } else {
    row.add(changed == Changed::kState ? Primitive::kEvaluate : Primitive::kEvaluateModes);
    row.add_joints(Primitive::kJoints);
    if (changed == Changed::kState) row.add_bodies(Primitive::kKinematics);
    row.add_loads(1);
  }
  row.add_dynamics(1, Place::kEnd);
  row.add_other_laws();
}
// evaluate() of new commands.
void add_new_commands(RowCost& row) {
  row.add(Primitive::kEvaluateNew);
  row.add_loads(1);
  row.add_commands();
  row.add_other_laws();
}

class Rows {
 public:
  Rows(const CallCosts& costs, const Features& features, const StepLimits& limits)
      : costs_(costs), features_(features), limits_(limits) {}

  std::vector<CostRow> list() const {
    std::vector<CostRow> rows = {calc_begin(), calc_stages(), calc_projections(), calc_ends()};
    if (limits_.tries > limits_.sub_steps) rows.push_back(calc_searches());
    if (limits_.rounds > 0) rows.push_back(calc_rounds());
    if (limits_.jumps > 0) rows.push_back(calc_jumps());
    if (limits_.waits > 0) rows.push_back(calc_waits());
    rows.push_back(calc_sub_steps());
    rows.push_back(calc_readings());
    return rows;
  }

 private:
  RowCost begin() const { return {costs_, features_}; }
  static double to_double(std::int64_t count) { return static_cast<double>(count); }

  CostRow calc_begin() const {
    RowCost row = begin();
    row.add(Primitive::kRearm);
    row.add(Primitive::kAct);
    if (limits_.follows) {
      if (features_.commanded_loads) add_new_commands(row);
      if (features_.commanded_events) row.add(Primitive::kGuards);
      return row.repeat("beginning, with new commands", 1);
    }
    row.add(Primitive::kFirstStep);
    add_evaluation(row, Changed::kState);
    row.add(Primitive::kGuards);
    return row.repeat("evaluation at the beginning", 1);
  }
  // RK4. ROS2 has two stages; ROS34PW2 has one more time of loads, and moves bodies itself. Where parts may be of order
  // eight, all of them count as such.
  CostRow calc_stages() const {
    RowCost row = begin();
    row.add(Primitive::kIntegrate);
    const bool eighth = features_.eighth_moves > 0;
    const int stages = eighth ? EighthOrderStages::kCount - 1 : 3;
    row.add_bodies(Primitive::kKinematics, (features_.rigid ? 0 : 3) + (eighth ? EighthOrderStages::kCount : 0));
    row.add_moves(features_.eighth_moves);
    row.add_loads(eighth ? EighthOrderStages::kTimes : 2);
    row.add_joints(Primitive::kJoints, stages);
    row.add_dynamics(stages, Place::kStage);
    const double explicitly =
        costs_[Primitive::kFirstStage] + 2 * costs_[Primitive::kStage] + costs_[Primitive::kLastStage];
    const double implicitly = 3 * costs_[Primitive::kImplicitStage];
    if (features_.compliant && implicitly > explicitly) {
      row.add_bodies(Primitive::kImplicitStage, 3);
    } else {
      row.add_bodies(Primitive::kFirstStage);
      row.add_bodies(Primitive::kStage, 2);
      row.add_bodies(Primitive::kLastStage);
    }
    return row.repeat("integrations: stages", to_double(limits_.tries));
  }
  CostRow calc_projections() const {
    RowCost row = begin();
    row.add_joints(Primitive::kJointPlaces);
    row.add_joints(Primitive::kJointSpeeds);
    row.add_solver(Primitive::kFactorRest, 1);
    row.add_solver(Primitive::kSolveRest, 1);
    row.add_rigid_rows(2);
    row.add_bodies(Primitive::kMovePlaces);
    row.add_bodies(Primitive::kMoveSpeeds);
    if (!features_.rigid) {
      row.add_bodies(Primitive::kKinematics, 2);
      row.add_bodies(Primitive::kVelocities);
    }
    return row.repeat("integrations: projections", to_double(limits_.tries));
  }
  CostRow calc_ends() const {
    RowCost row = begin();
    add_evaluation(row, Changed::kVelocities);
    row.add(Primitive::kGuards);
    return row.repeat("integrations: end, guards", to_double(limits_.tries));
  }
  CostRow calc_searches() const {
    RowCost row = begin();
    row.add(Primitive::kTry);
    return row.repeat("searches", to_double(limits_.tries - limits_.sub_steps));
  }
  CostRow calc_rounds() const {
    RowCost row = begin();
    add_evaluation(row, Changed::kModes);
    row.add(Primitive::kGuards);
    row.add(Primitive::kRound);
    if (features_.rigid_rows > 0) add_blow(row);
    return row.repeat("events", to_double(limits_.rounds));
  }
  CostRow calc_jumps() const {
    RowCost row = begin();
    row.add(Primitive::kImpulse);
    row.add_joints(Primitive::kJointSpeeds);
    row.add_solver(Primitive::kFactor, 1);
    row.add_bodies(Primitive::kMoveSpeeds);
    row.add_bodies(Primitive::kVelocities);
    return row.repeat("impulses of events", to_double(limits_.jumps));
  }
  // The impulse of rigid contacts, or what is left of slips: strike_rigid_pairs(), stop_rigid_slips().
  void add_blow(RowCost& row) const {
    row.add(costs_[Primitive::kRigidStrike] > costs_[Primitive::kRigidStop] ? Primitive::kRigidStrike
                                                                            : Primitive::kRigidStop);
    row.add(Primitive::kImpulse);
    row.add(Primitive::kRearm);
    row.add_joints(Primitive::kJointSpeeds, 2);
    row.add_solver(Primitive::kFactorRest, 1);
    row.add_solver(Primitive::kSolve, features_.rigid_rows);
    row.add_solver(Primitive::kFactor, 1);
    row.add_bodies(Primitive::kMoveSpeeds);
    row.add_bodies(Primitive::kVelocities);
  }
  CostRow calc_waits() const {
    RowCost row = begin();
    row.add(Primitive::kWait);
    return row.repeat("events that begin to wait", to_double(limits_.waits));
  }
  CostRow calc_sub_steps() const {
    RowCost row = begin();
    row.add_bodies(Primitive::kBegin);
    row.add(Primitive::kSearch);
    row.add(Primitive::kStore);
    row.add(Primitive::kRearm);
    row.add(Primitive::kNextDue);
    row.add(Primitive::kAct);
    row.add_own_of_substep();
    if (features_.contacts) row.add(Primitive::kParts);
    if (features_.contact_rows > 0) {
      row.add(Primitive::kContactRows);
      row.add_solver(Primitive::kSolve, features_.contact_rows);
    }
    if (features_.rigid_rows > 0) {  // begin_slips()
      row.add(Primitive::kRigidSlips);
      row.add(Primitive::kGuards);
      add_new_commands(row);
    }
    return row.repeat("sub-steps", to_double(limits_.sub_steps));
  }
  CostRow calc_readings() const {
    RowCost row = begin();
    row.add(Primitive::kReadings);
    row.add_own_of_step();
    return row.repeat("readings", 1);
  }

  const CallCosts& costs_;
  const Features& features_;
  const StepLimits& limits_;
};

const cost::Measured& get_measured(const CostTarget& target) {
  const std::span<const cost::Measured* const> all = cost::list_measured();
  return **std::find_if(all.begin(), all.end(), [&](const cost::Measured* m) { return &m->target == &target; });
}

// Events that act once in a flight, and those that may act at every instant; an event with a delay has two instants.
struct EventCounts {
  std::int64_t once = 0, repeating = 0, delayed = 0, repeating_delayed = 0, instants = 0;
  std::int64_t jumps = 0, repeating_jumps = 0;  // those after which velocities may jump
};
EventCounts count_events(const PlanData& plan) {
  EventCounts counts;
  for (const PlanEvent& event : plan.events) {
    (event.repeat ? counts.repeating : counts.once) += 1;
    counts.delayed += event.delay > 0 ? 1 : 0;
    counts.repeating_delayed += event.delay > 0 && event.repeat ? 1 : 0;
    if (cost::may_jump(plan, event)) (event.repeat ? counts.repeating_jumps : counts.jumps) += 1;
  }
  counts.instants = counts.once + counts.delayed;
  return counts;
}

// Rounds at one instant that rigid contacts add, with the one that finds that there are too many.
std::int64_t count_round_limit(const PlanData& plan) {
  if (plan.rigid_pairs == 0) return 0;
  return calc_rigid_rounds(plan.rigid_pairs, (count_rigid_rows(plan) - plan.rigid_pairs) / 2) + 1;
}

// Rounds of events of which a StepReport has room for the audits.
std::int64_t count_audits(const PlanData& plan) {
  return static_cast<std::int64_t>((plan.events.size() + plan.contact_pairs.size()) *
                                   (static_cast<std::size_t>(plan.options.max_splits) + 2));
}

}  // namespace

StepLimits calc_step_limits(const Plan& owner) noexcept {
  const PlanData& plan = get_data(owner);
  const EventCounts events = count_events(plan);
  const auto pairs = static_cast<std::int64_t>(plan.contact_pairs.size());
  const bool recurring = pairs > 0 || events.repeating > 0;
  StepLimits limits;
  if (pairs > 0)
    limits.parts = has_automatic_parts(plan.contact_substeps) ? kMaxAutomaticSubsteps : plan.contact_substeps;
  limits.splits =
      recurring ? plan.options.max_splits : std::min<std::int64_t>(plan.options.max_splits, events.instants);
  const bool jumps = std::any_of(plan.laws.corners.begin(), plan.laws.corners.end(),
                                 [](const PlanCorner& corner) { return corner.jumps; });
  const bool burns =
      std::any_of(plan.varying.begin(), plan.varying.end(), [](const PlanVarying& mass) { return mass.by_burnt; });
  const std::int64_t corners = !plan.place_corners && !burns ? 0 : kMostCornerSplits;
  const std::int64_t features = pairs > 0 ? kMostFeatureSplits : 0;
  // A force of a rigid contact that jumps is located first; then the sub-step before it is tried, and the instant
  // again.
  const std::int64_t feature_tries = plan.rigid_pairs > 0 ? kMostTries + 2 : kMostFeatureTries;
  const std::int64_t corner_splits =
      std::min<std::int64_t>(kMostCornerSplits, corners + cost::count_timed_corners(plan));
  limits.sub_steps = limits.parts + limits.splits + corner_splits + features;
  limits.searches = limits.splits * kMostTries + corners * (jumps ? kMostJumpTries : kMostCornerTries) +
                    features * feature_tries + (pairs > 0 ? limits.sub_steps * (kMostLooks + 1) : 0);
  limits.tries = limits.sub_steps + limits.searches;
  // At one instant an event acts or begins to wait once, and a pair changes twice; of rigid contacts as often as
  // act_in_rounds() allows.
  limits.rounds = events.once + (1 + limits.splits) * (events.repeating + 2 * pairs + count_round_limit(plan));
  limits.jumps = std::min(limits.rounds, events.jumps + (1 + limits.splits) * events.repeating_jumps);
  // A round in which nothing but waits begins is the last one of its instant; of rigid contacts so is one that finds
  // nothing left to change.
  const bool always = events.repeating_delayed > 0 || plan.rigid_pairs > 0;
  limits.waits = always ? 1 + limits.splits : std::min(1 + limits.splits, events.delayed);
  return limits;
}

StepLimits get_counted_limits(const Plan& owner, const StepCounts& counts) noexcept {
  const PlanData& plan = get_data(owner);
  const StepLimits most = calc_step_limits(owner);
  const std::int64_t integrations = counts.integrations;
  const bool all_audited = plan.rigid_pairs == 0 || counts.rounds < count_audits(plan);
  StepLimits limits;
  limits.rounds = all_audited ? counts.rounds : most.rounds;
  limits.jumps = all_audited ? std::min(counts.jumps, limits.rounds) : most.jumps;
  // The last rounds of rigid contacts have no audit, one at each instant at most.
  limits.waits = std::min(most.waits, plan.rigid_pairs > 0 ? 1 + integrations : counts.waits);
  // A split that is searched for takes two tries at least, after the one that showed it; one at a known time, or at a
  // corner, takes no more than its sub-step.
  constexpr std::int64_t kLeast = 3;
  const std::int64_t timed = std::min(counts.timed, integrations - 1);
  const auto count_splits = [&](std::int64_t others) { return others + (integrations - 1 - others) / kLeast; };
  if (plan.rigid_pairs == 0) limits.waits = std::min(limits.waits, 1 + count_splits(timed));
  limits.parts = limits.sub_steps = std::min(integrations, most.sub_steps);
  // Without contacts events and corners alone split a step; each split at an event has a round.
  if (plan.contact_pairs.empty()) {
    const std::int64_t corners = std::min(most.sub_steps - 1 - most.splits, integrations - 1 - timed);
    limits.parts = limits.sub_steps =
        std::min({limits.sub_steps, 1 + count_splits(timed + corners), 1 + counts.rounds + limits.waits + corners});
  }
  limits.tries = integrations;
  limits.searches = integrations - limits.sub_steps;
  limits.follows = true;
  return limits;
}

StepCost calc_step_cost(const Plan& owner, const CostTarget& target, const StepLimits& limits) {
  const PlanData& plan = get_data(owner);
  const cost::Measured& measured = get_measured(target);
  const cost::Work work = cost::count_work(owner, target.lanes);
  const cost::Work driven = cost::count_work(owner, target.lanes, cost::Coordinates::kDriven);
  const CallCosts costs(measured, work, driven);
  const Features features = get_features(plan, driven);
  StepCost out;
  out.rows = Rows(costs, features, limits).list();
  for (const CostRow& row : out.rows) out.instructions += row.total();
  for (std::size_t i = 0; i < cost::kUnits; ++i)
    if (work.counts[i] != 0 &&
        std::find(measured.units.begin(), measured.units.end(), static_cast<cost::Unit>(i)) == measured.units.end())
      out.unmeasured.emplace_back(cost::kUnitNames[i]);
  return out;
}

}  // namespace unlatch
