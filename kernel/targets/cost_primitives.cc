// Counts the instructions of the primitives of a step: the functions through which a step is put together, each less
// what it calls of the others. The linker's --wrap (cost.cmake) leads calls of NAME here, to __wrap_NAME; __real_NAME
// is NAME itself. What counting itself adds to a call of nothing is taken off; of other calls it adds a
// little more, so that counts are rather too large.
#include <algorithm>
#include <array>

#include "kernel/cost/primitives.h"
#include "kernel/dispatch/kernels.h"
#include "kernel/dynamics/energy.h"
#include "kernel/elements/instant.h"
#include "kernel/events/event_search.h"
#include "kernel/events/rigid_friction.h"
#include "kernel/events/rigid_pairs.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/rigid_rows.h"
#include "kernel/joints/residuals.h"
#include "kernel/targets/cost.h"
#include "kernel/targets/port.h"
#include "kernel/targets/text_line.h"

namespace unlatch::target {
namespace {

using cost::Primitive;

struct Count {
  std::uint64_t calls, most;
};
std::array<Count, cost::kPrimitives> counts;
const Kernels* kernels;
std::uint64_t last, outside, *current = &outside;  // where the instructions since `last` belong
std::uint64_t integrations, substeps;              // so far
std::uint64_t energies;                            // that the latest call of act() has computed
bool first_step;                                   // this one begins with an evaluation of its state
std::uint64_t added_within, added_outside;         // instructions that counting adds to a call, and to its caller

std::uint64_t subtract(std::uint64_t from, std::uint64_t added) { return from > added ? from - added : 0; }

// `parts`: into which the instructions of the call are divided.
void note(Primitive primitive, std::uint64_t instructions, std::uint64_t parts) {
  Count& count = counts[static_cast<std::size_t>(primitive)];
  count.calls += parts;
  count.most = std::max(count.most, (instructions + parts - 1) / parts);
}

// While it lives, instructions belong to the primitive.
class Within {
 public:
  explicit Within(Primitive primitive) : primitive_(primitive), outer_(current) {
    *outer_ += read_counter() - last;
    current = &own_;
    last = read_counter();
  }
  ~Within() {
    own_ = subtract(get_own(), added_within);
    if (rest_ != Primitive::kCount) note(rest_, subtract(own_, until_), 1);
    note(primitive_, rest_ != Primitive::kCount ? std::min(own_, until_) : own_, parts_);
    *outer_ = subtract(*outer_, added_outside);
    current = outer_;
    last = read_counter();
  }
  Within(const Within&) = delete;
  Within& operator=(const Within&) = delete;
  // The call turned out to be so many parts of this primitive.
  void divide(Primitive primitive, std::uint64_t parts) {
    primitive_ = primitive;
    parts_ = parts;
  }
  // Its own instructions behind the first `until` turned out to be a call of another primitive.
  void split(std::uint64_t until, Primitive rest) {
    until_ = until;
    rest_ = rest;
  }
  // Its instructions so far.
  std::uint64_t get_own() const { return own_ + (read_counter() - last); }

 private:
  Primitive primitive_, rest_ = Primitive::kCount;
  std::uint64_t parts_ = 1, until_ = 0, own_ = 0, *outer_;
};

const Within* acting;  // the call of act()
std::uint64_t acted;   // its instructions up to the end of the latest round in which events acted

// Counts calls of nothing.
[[gnu::noinline]] void calibrate() {
  constexpr std::uint64_t kCalls = 64;
  counts = {};
  added_within = added_outside = 0;
  std::uint64_t around = 0;
  current = &around;
  last = read_counter();
  for (std::uint64_t i = 0; i < kCalls; ++i) const Within nothing(Primitive::kStep);
  around += read_counter() - last;
  added_outside = around / kCalls;
  added_within = counts[static_cast<std::size_t>(Primitive::kStep)].most;
  counts = {};
}

template <Primitive primitive, auto member, class Result, class... Arguments>
constexpr auto wrap(Result (*Kernels::*)(Arguments...)) {
  return +[](Arguments... arguments) -> Result {
    const Within within(primitive);
    return (kernels->*member)(arguments...);
  };
}
template <Primitive primitive, auto member>
constexpr auto wrap() {
  return wrap<primitive, member>(member);
}

using K = Kernels;
using P = Primitive;
// Those whose cost depends on what is asked.
Primitive get_joints(RowTarget target) {
  if (target == RowTarget::kAcceleration) return Primitive::kJoints;
  return target == RowTarget::kPosition ? Primitive::kJointPlaces : Primitive::kJointSpeeds;
}
void update_joints(const PlanData& plan, Evaluation& ev, RowTarget target) {
  const Within within(get_joints(target));
  kernels->update_joints(plan, ev, target);
}
int factor_and_solve(const PlanData& plan, const State& state, Evaluation& ev, const Sweep& sweep,
                     std::int32_t most_rows) {
  const Primitive bare = sweep.source == Source::kNothing ? Primitive::kFactorRest : Primitive::kFactorStage;
  const Within within(sweep.multipliers ? Primitive::kFactor : bare);
  return kernels->factor_and_solve(plan, state, ev, sweep, most_rows);
}
void solve(const PlanData& plan, Evaluation& ev, const Sweep& sweep) {
  const bool rest = sweep.source == Source::kNothing && !sweep.multipliers;
  const Within within(rest ? Primitive::kSolveRest : Primitive::kSolve);
  kernels->solve(plan, ev, sweep);
}

constexpr Kernels kWrapped = {wrap<P::kKinematics, &K::update_kinematics>(),
                              wrap<P::kVelocities, &K::update_angular_velocities>(),
                              wrap<P::kOwnForces, &K::init_forces>(),
                              update_joints,
                              wrap<P::kJointVelocities, &K::update_joint_velocities>(),
                              wrap<P::kAngles, &K::update_angles>(),
                              factor_and_solve,
                              solve,
                              wrap<P::kSplit, &K::split_cluster_rows>(),
                              wrap<P::kBegin, &K::begin_substep>(),
                              wrap<P::kFirstStage, &K::begin_stages>(),
                              wrap<P::kStage, &K::advance_stage>(),
                              wrap<P::kLastStage, &K::finish_stages>(),
                              wrap<P::kImplicitStage, &K::restart>(),
                              wrap<P::kImplicitStage, &K::finish_first_stage>(),
                              wrap<P::kImplicitStage, &K::finish_second_stage>(),
                              wrap<P::kMovePlaces, &K::add_displacements>(),
                              wrap<P::kMoveSpeeds, &K::add_velocities>()};

}  // namespace
}  // namespace unlatch::target

namespace unlatch {

using target::Within;
using P = cost::Primitive;

extern const Kernels* const real_tables[] asm("__real__ZN7unlatch13kKernelTablesE");
extern const Kernels* const wrap_tables[] asm("__wrap__ZN7unlatch13kKernelTablesE");
constinit const Kernels* const wrap_tables[] = {&target::kWrapped, &target::kWrapped, &target::kWrapped,
                                                &target::kWrapped, &target::kWrapped};

#define UNLATCH_DECLARE(result, name, symbol, parameters) \
  result real_##name parameters asm("__real_" symbol);    \
  result wrap_##name parameters asm("__wrap_" symbol);
#define UNLATCH_WRAP(primitive, result, name, symbol, parameters, arguments) \
  UNLATCH_DECLARE(result, name, symbol, parameters)                          \
  result wrap_##name parameters {                                            \
    const Within within(primitive);                                          \
    return real_##name arguments;                                            \
  }

// Symbols that name std::uint64_t.
#if __SIZEOF_POINTER__ == 8
#define UNLATCH_SET "mRNS_10EvaluationE"
#else
#define UNLATCH_SET "yRNS_10EvaluationE"
#endif

UNLATCH_WRAP(
    P::kLoopJoints, void, update_non_tree_joints,
    "_ZN7unlatch22update_non_tree_jointsERKNS_8PlanDataERKNS_5StateENS_9RowTargetENS_8JointSetERNS_10EvaluationE",
    (const PlanData& plan, const State& state, RowTarget target, JointSet joints, Evaluation& ev),
    (plan, state, target, joints, ev))
UNLATCH_WRAP(P::kForces, void, add_forces, "_ZN7unlatch10add_forcesERKNS_7InstantERNS_10EvaluationE",
             (const Instant& now, Evaluation& ev), (now, ev))
UNLATCH_WRAP(P::kLoads, void, update_loads, "_ZN7unlatch12update_loadsERKNS_7InstantERNS_10EvaluationE",
             (const Instant& now, Evaluation& ev), (now, ev))
UNLATCH_WRAP(P::kLaws, std::span<const double>, update_driving_laws,
             "_ZN7unlatch19update_driving_lawsERKNS_7InstantERNS_10EvaluationE", (const Instant& now, Evaluation& ev),
             (now, ev))
UNLATCH_WRAP(P::kOtherLaws, void, update_other_laws, "_ZN7unlatch17update_other_lawsERKNS_7InstantERNS_10EvaluationE",
             (const Instant& now, Evaluation& ev), (now, ev))
UNLATCH_WRAP(P::kCoordinates, std::size_t, measure_coordinates,
             "_ZN7unlatch19measure_coordinatesERKNS_8PlanDataERKNS_5StateENS_13CoordinateSetERNS_10EvaluationE",
             (const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev), (plan, state, set, ev))
UNLATCH_WRAP(P::kUnwind, void, unwind_angles,
             "_ZN7unlatch13unwind_anglesERKNS_8PlanDataERKNS_5StateENS_13CoordinateSetERNS_10EvaluationE",
             (const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev), (plan, state, set, ev))
UNLATCH_WRAP(P::kFriction, void, update_friction, "_ZN7unlatch15update_frictionERKNS_7InstantERNS_10EvaluationE",
             (const Instant& now, Evaluation& ev), (now, ev))
UNLATCH_WRAP(P::kSplit, void, split_dense_rows,
             "_ZN7unlatch16split_dense_rowsERKNS_8PlanDataERKNS_5StateERNS_10EvaluationE",
             (const PlanData& plan, const State& state, Evaluation& ev), (plan, state, ev))
UNLATCH_WRAP(P::kImpulse, int, apply_impulse,
             "_ZN7unlatch13apply_impulseERKNS_8PlanDataENS_6SourceERNS_5StateERNS_10EvaluationE",
             (const PlanData& plan, Source source, State& state, Evaluation& ev), (plan, source, state, ev))
UNLATCH_WRAP(P::kReadings, void, update_readings, "_ZN7unlatch15update_readingsERKNS_7InstantERNS_10EvaluationEPKh",
             (const Instant& now, Evaluation& ev, const std::uint8_t* unread), (now, ev, unread))
UNLATCH_WRAP(P::kParts, ContactParts, choose_contact_parts,
             "_ZN7unlatch20choose_contact_partsERKNS_8PlanDataERKNS_5StateEddRKNS_10EvaluationE",
             (const PlanData& plan, const State& state, double t, double rest, const Evaluation& ev),
             (plan, state, t, rest, ev))
UNLATCH_WRAP(P::kContactRows, void, begin_contact_rows,
             "_ZN7unlatch18begin_contact_rowsERKNS_7InstantERNS_10EvaluationERNS_11ContactRowsE",
             (const Instant& now, Evaluation& ev, ContactRows& rows), (now, ev, rows))
UNLATCH_WRAP(P::kRigidRows, int, solve_rigid_rows,
             "_ZN7unlatch16solve_rigid_rowsERKNS_7InstantENS_11RigidTargetERKNS_5SweepE" UNLATCH_SET,
             (const Instant& now, RigidTarget target, const Sweep& sweep, RigidSet set, Evaluation& ev),
             (now, target, sweep, set, ev))
UNLATCH_WRAP(P::kRigidStrike, int, strike_rigid_pairs, "_ZN7unlatch18strike_rigid_pairsERNS_3RunEdRNS_7BalanceE",
             (Run & run, double now, Balance& allowed), (run, now, allowed))
UNLATCH_WRAP(P::kRigidStop, int, stop_rigid_slips, "_ZN7unlatch16stop_rigid_slipsERNS_3RunEdRNS_7BalanceE",
             (Run & run, double now, Balance& allowed), (run, now, allowed))
UNLATCH_WRAP(P::kRigidSlips, bool, begin_slips, "_ZN7unlatch11begin_slipsERNS_3RunEd", (Run & run, double now),
             (run, now))
UNLATCH_WRAP(P::kStore, void, store_substep, "_ZN7unlatch13store_substepERKNS_8PlanDataERKNS_10EvaluationERNS_5StateE",
             (const PlanData& plan, const Evaluation& ev, State& state), (plan, ev, state))
UNLATCH_WRAP(P::kRearm, void, rearm, "_ZN7unlatch5rearmERKNS_8PlanDataERNS_5StateERNS_10EvaluationE",
             (const PlanData& plan, State& state, Evaluation& ev), (plan, state, ev))
UNLATCH_WRAP(P::kNextDue, double, calc_next_due, "_ZN7unlatch13calc_next_dueERKNS_8PlanDataERKNS_5StateEd",
             (const PlanData& plan, const State& state, double now), (plan, state, now))

// Symbols with a std::span name the largest std::size_t.
#if __SIZEOF_POINTER__ == 8
#define UNLATCH_SPAN "Lm18446744073709551615EE"
#else
#define UNLATCH_SPAN "Lj4294967295EE"
#endif
UNLATCH_WRAP(P::kGuards, void, update_guards,
             "_ZN7unlatch13update_guardsERKNS_7InstantERNS_10EvaluationESt4spanId" UNLATCH_SPAN,
             (const Instant& now, Evaluation& ev, std::span<double> stack), (now, ev, stack))

UNLATCH_DECLARE(int, evaluate, "_ZN7unlatch8evaluateERKNS_7InstantENS_7ChangedERNS_10EvaluationE",
                (const Instant& now, Changed changed, Evaluation& ev))
int wrap_evaluate(const Instant& now, Changed changed, Evaluation& ev) {
  P primitive = P::kEvaluate;
  if (changed == Changed::kCommands) primitive = P::kEvaluateNew;
  if (changed == Changed::kVelocities) primitive = P::kEvaluateEnd;
  if (changed == Changed::kModes) primitive = P::kEvaluateModes;
  if (primitive == P::kEvaluate) target::first_step = true;
  const Within within(primitive);
  return real_evaluate(now, changed, ev);
}

UNLATCH_DECLARE(int, integrate, "_ZN7unlatch9integrateERKNS_7InstantERKNS_12SubstepStartEdRNS_10EvaluationE",
                (const Instant& now, const SubstepStart& start, double end, Evaluation& ev))
int wrap_integrate(const Instant& now, const SubstepStart& start, double end, Evaluation& ev) {
  const Within within(P::kIntegrate);
  ++target::integrations;
  return real_integrate(now, start, end, ev);
}

UNLATCH_DECLARE(Reached, advance_to_event, "_ZN7unlatch16advance_to_eventERNS_3RunEddNS_8ContactsEb",
                (Run & run, double now, double target, Contacts contacts, bool may_split))
Reached wrap_advance_to_event(Run& run, double now, double target, Contacts contacts, bool may_split) {
  ++target::substeps;
  Within within(P::kSearch);
  const std::uint64_t before = target::integrations;
  const Reached reached = real_advance_to_event(run, now, target, contacts, may_split);
  const std::uint64_t count = target::integrations - before;
  if (count > 1) within.divide(P::kTry, count - 1);
  return reached;
}

UNLATCH_DECLARE(StepStatus, act, "_ZN7unlatch3actERNS_3RunEdSt4spanIKd" UNLATCH_SPAN,
                (Run & run, double now, std::span<const double> tolerances))
StepStatus wrap_act(Run& run, double now, std::span<const double> tolerances) {
  Within within(P::kAct);
  target::acting = &within;
  target::energies = 0;
  const StepStatus status = real_act(run, now, tolerances);
  target::acting = nullptr;
  // A round computes energies before its events, and behind them if some acted: in the last one they may only wait.
  const std::uint64_t count = target::energies;
  if (count > 1) within.divide(P::kRound, count / 2);
  if (count == 1) within.divide(P::kWait, 1);
  if (count > 1 && count % 2 == 1) within.split(target::acted, P::kWait);
  return status;
}

UNLATCH_DECLARE(EnergyFlow, calc_energy_flow,
                "_ZN7unlatch16calc_energy_flowERKNS_8PlanDataERKNS_5StateEdRKNS_10EvaluationERKNS_5Vec3TIdEE",
                (const PlanData& plan, const State& state, double t, const Evaluation& ev, const Vec3& observer))
EnergyFlow wrap_calc_energy_flow(const PlanData& plan, const State& state, double t, const Evaluation& ev,
                                 const Vec3& observer) {
  const EnergyFlow flow = real_calc_energy_flow(plan, state, t, ev, observer);
  if (++target::energies % 2 == 0 && target::acting != nullptr) target::acted = target::acting->get_own();
  return flow;
}

}  // namespace unlatch

namespace unlatch::target {

void begin_primitives(const PlanData& plan) {
  calibrate();
  kernels = real_tables[static_cast<int>(plan.instruction_set)];
}
std::uint64_t begin_step() {
  outside = substeps = 0;
  first_step = false;
  current = &outside;
  return last = read_counter();
}
// What no primitive has is the step's own, for each of its sub-steps.
std::uint64_t end_step(std::uint64_t begin) {
  const std::uint64_t now = read_counter();
  outside += now - last;
  note(first_step ? Primitive::kFirstStep : Primitive::kStep, outside, std::max<std::uint64_t>(substeps, 1));
  return now - begin;
}
void print_primitives(const char* plan) {
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i].calls > 0)
      TextLine() << "p " << plan << " " << cost::kPrimitiveNames[i] << " " << counts[i].calls << " "
                 << counts[i].most * kInstructionUnit << "\n";
}

}  // namespace unlatch::target
