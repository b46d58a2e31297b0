#include <algorithm>
#include <array>
#include <cstring>

#include "kernel/cost/measured.h"
#include "kernel/elements/kinds/friction.h"
#include "kernel/events/limits.h"
#include "kernel/integration/contact_stages.h"
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
    }
  }
  double operator[](Primitive primitive) const { return costs_[static_cast<std::size_t>(primitive)]; }
  double in_stage(Primitive primitive) const { return driven_[static_cast<std::size_t>(primitive)]; }

 private:
  std::array<double, cost::kPrimitives> costs_{}, driven_{};
};

// Parts of a plan that decide what is called at all.
struct Features {
  bool rigid, loops, laws, contacts, angles, stage_angles, commanded;
  double sweeps;        // solutions with friction, beside the first
  double contact_rows;  // of parts that are implicit in the forces of contacts; 0: there are none
};

Features get_features(const PlanData& plan, const cost::Work& driven) {
  return {.rigid = plan.rigid,
          .loops = !plan.non_tree_joints.empty(),
          .laws = !plan.laws.empty(),
          .contacts = !plan.contacts.empty(),
          .angles = plan.rotation_count > 0,
          .stage_angles = driven[cost::Unit::kAngleEights] > 0,
          .commanded = plan.commanded_loads || plan.commanded_events,
          .sweeps = plan.frictions.empty() ? 0.0 : kFrictionSweeps,
          .contact_rows = driven[cost::Unit::kContactRows]};
}

enum class Place { kStage, kEnd };

// Adds calls of primitives to a row.
class RowCost {
 public:
  RowCost(const CallCosts& costs, const Features& features) : costs_(costs), features_(features) {}

  // Frames of joints and what they prescribe; of loops too.
  void add_joints(double calls, Primitive of_tree = Primitive::kJoints) {
    row_.bodies += calls * (costs_[of_tree] + (features_.loops ? costs_[Primitive::kLoopJoints] : 0));
  }
  void add_kinematics(double calls) { row_.bodies += calls * costs_[Primitive::kKinematics]; }
  void add_motion(double calls) { row_.bodies += calls * costs_[Primitive::kMotion]; }
  void add_loads(double calls) { row_.forces += calls * costs_[Primitive::kLoads]; }
  void add_laws(double calls) { row_.forces += features_.laws ? calls * costs_[Primitive::kLaws] : 0; }
  // Forces and accelerations at one instant: integrator.cc, solve_dynamics(). Stages find no multipliers, and so split
  // none, but for friction.
  void add_dynamics(double calls, Place of) {
    const bool stage = of == Place::kStage;
    const double sweeps = 1 + features_.sweeps, splits = stage && features_.sweeps == 0 ? 0 : sweeps;
    const auto coordinates = [&](Primitive primitive) {
      return stage ? costs_.in_stage(primitive) : costs_[primitive];
    };
    row_.forces += calls * coordinates(Primitive::kCoordinates);
    if (stage ? features_.stage_angles : features_.angles) row_.forces += calls * 2 * coordinates(Primitive::kAngles);
    add_forces(calls);
    row_.solver += calls * (costs_[Primitive::kFactor] + features_.sweeps * costs_[Primitive::kSolve]);
    if (features_.loops) row_.solver += calls * splits * costs_[Primitive::kSplit];
  }
  // Likewise with the factor that is there: evaluate_commands().
  void add_commands() {
    add_forces(1);
    row_.solver +=
        (1 + features_.sweeps) * (costs_[Primitive::kSolve] + (features_.loops ? costs_[Primitive::kSplit] : 0));
  }
  void add_solver(double factors, double solutions) {
    row_.solver += factors * costs_[Primitive::kFactor] + solutions * costs_[Primitive::kSolve];
  }
  void add(Primitive primitive, double calls = 1) { row_.rest += calls * costs_[primitive]; }

  // Of elements and laws, with each sweep of friction.
  void add_forces(double calls) {
    const double sweeps = 1 + features_.sweeps;
    row_.forces += calls * (sweeps * (costs_[Primitive::kOwnForces] + costs_[Primitive::kForces]) +
                            features_.sweeps * costs_[Primitive::kFriction]);
    add_laws(calls);
  }

  CostRow repeat(const char* phase, double calls) const {
    return {phase, calls, calls * row_.bodies, calls * row_.forces, calls * row_.solver, calls * row_.rest};
  }

 private:
  const CallCosts& costs_;
  const Features& features_;
  CostRow row_{};
};

// evaluate(): of a new state, of velocities alone, of modes alone.
void add_evaluation(RowCost& row, Changed changed) {
  const bool whole = changed != Changed::kVelocities;
  row.add(whole ? Primitive::kEvaluate : Primitive::kEvaluateEnd);
  row.add_joints(1, whole ? Primitive::kJoints : Primitive::kJointVelocities);
  if (changed == Changed::kState) row.add_kinematics(1);
  if (whole) row.add_loads(1);
  row.add_dynamics(1, Place::kEnd);
  row.add_laws(1);
}

class Rows {
 public:
  Rows(const CallCosts& costs, const Features& features, const StepLimits& limits)
      : costs_(costs), features_(features), limits_(limits) {}

  std::vector<CostRow> list() const {
    std::vector<CostRow> rows = {calc_begin(), calc_stages(), calc_projections(), calc_ends()};
    if (limits_.rounds > 0) rows.push_back(calc_rounds());
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
      if (!features_.commanded) return row.repeat("beginning", 1);
      row.add(Primitive::kEvaluateEnd);
      row.add_loads(1);
      row.add_commands();
      row.add_laws(1);
    } else {
      add_evaluation(row, Changed::kState);
    }
    row.add(Primitive::kGuards);
    return row.repeat(limits_.follows ? "new commands at the beginning" : "evaluation at the beginning", 1);
  }
  // RK4; ROS2 has two stages, and less of everything. ROS34PW2 has one more time of loads, and moves bodies itself.
  CostRow calc_stages() const {
    RowCost row = begin();
    row.add(Primitive::kIntegrate);
    const bool implicit = features_.contact_rows > 0;
    row.add_kinematics((features_.rigid ? 0 : 3) + (implicit ? ContactStages::kCount : 0));
    row.add_loads(implicit ? 3 : 2);
    row.add_joints(3);
    row.add_dynamics(3, Place::kStage);
    row.add_motion(4);
    return row.repeat("integrations: stages", to_double(limits_.tries));
  }
  CostRow calc_projections() const {
    RowCost row = begin();
    row.add_joints(2);
    row.add_solver(1, 1);
    row.add_motion(2);
    if (!features_.rigid) row.add_kinematics(3);
    return row.repeat("integrations: projections", to_double(limits_.tries));
  }
  CostRow calc_ends() const {
    RowCost row = begin();
    add_evaluation(row, Changed::kVelocities);
    row.add(Primitive::kGuards);
    row.add(Primitive::kSearch);
    return row.repeat("integrations: end, guards, search", to_double(limits_.tries));
  }
  CostRow calc_rounds() const {
    RowCost row = begin();
    add_evaluation(row, Changed::kModes);
    row.add(Primitive::kGuards);
    row.add(Primitive::kRound);
    row.add(Primitive::kImpulse);
    row.add_joints(1);
    row.add_solver(1, 0);
    row.add_motion(1);
    row.add_kinematics(1);
    return row.repeat("events and impulses", to_double(limits_.rounds));
  }
  CostRow calc_waits() const {
    RowCost row = begin();
    row.add(Primitive::kRound);
    return row.repeat("events that begin to wait", to_double(limits_.waits));
  }
  CostRow calc_sub_steps() const {
    RowCost row = begin();
    row.add_motion(1);  // begin_substep()
    row.add(Primitive::kStore);
    row.add(Primitive::kRearm, 2);
    row.add(Primitive::kAct);
    row.add(Primitive::kStep);
    if (features_.contacts) row.add(Primitive::kParts);
    if (features_.contact_rows > 0) {
      row.add(Primitive::kContactRows);
      row.add_solver(0, features_.contact_rows);
    }
    return row.repeat("sub-steps", to_double(limits_.sub_steps));
  }
  CostRow calc_readings() const {
    RowCost row = begin();
    row.add(Primitive::kReadings);
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
  std::int64_t once = 0, repeating = 0, delayed = 0, delayed_by_time = 0, instants = 0;
};
EventCounts count_events(const PlanData& plan) {
  EventCounts counts;
  for (const PlanEvent& event : plan.events) {
    (event.repeat ? counts.repeating : counts.once) += 1;
    counts.delayed += event.delay > 0 ? 1 : 0;
    counts.delayed_by_time += event.delay > 0 && event.by_time ? 1 : 0;
  }
  counts.instants = counts.once + counts.delayed;
  return counts;
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
  limits.sub_steps = limits.parts + limits.splits + (plan.time_corners ? kMostCornerSplits : corners) + features;
  limits.searches = limits.splits * kMostTries + corners * (jumps ? kMostJumpTries : kMostCornerTries) +
                    features * kMostFeatureTries + (pairs > 0 ? limits.sub_steps * (kMostLooks + 1) : 0);
  limits.tries = limits.sub_steps + limits.searches;
  // At one instant an event acts or begins to wait once, and a pair changes twice.
  limits.rounds = events.once + (1 + limits.splits) * (events.repeating + 2 * pairs);
  limits.waits = events.delayed + (events.repeating > 0 ? limits.splits : 0);
  return limits;
}

StepLimits get_counted_limits(const Plan& plan, std::int64_t integrations, std::int64_t rounds) noexcept {
  const StepLimits most = calc_step_limits(plan);
  StepLimits limits;
  limits.parts = limits.sub_steps = std::min(integrations, most.sub_steps);
  limits.tries = integrations;
  limits.searches = integrations - limits.sub_steps;
  limits.rounds = rounds;
  // These have no audit. Whoever crosses zero is located by two tries at least, after the one that showed it.
  constexpr std::int64_t kLeast = 3;
  limits.waits = std::min(most.waits, integrations / kLeast + count_events(get_data(plan)).delayed_by_time);
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
