#include "unlatch/frequencies.h"

#include <cmath>

#include "kernel/dispatch/kernels.h"
#include "kernel/elements/kinds/kinds.h"
#include "kernel/elements/push.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/load_state.h"
#include "kernel/joints/kinematics.h"
#include "kernel/solver/loops/loop_rows.h"

namespace unlatch {
namespace {

// Wrenches of an element with unit effort.
struct UnitEffort {
  int base, follower;
  OppositeWrenches wrenches;
};

// Of an element that has no direction now: along x.
UnitEffort calc_unit(const Effort& effort) {
  const Vec3 e = norm(effort.direction) > 0 ? effort.direction : Vec3{1, 0, 0};
  return {effort.base, effort.follower,
          effort.turns ? calc_wrenches(e) : calc_wrenches(effort.r_base, effort.r_follower, e)};
}

// Acceleration along the element that its unit effort brings about: 1 / effective mass.
double calc_mobility(const PlanData& plan, const UnitEffort& effort, Evaluation& ev) {
  double* blocks = ev.blocks.data();
  for (const Place& place : plan.places) write(blocks, place, &SharedLane::force, {{0, 0, 0}, {0, 0, 0}});
  if (effort.base != kGround) write(blocks, ev.places[at(effort.base)], &SharedLane::force, effort.wrenches.on_base);
  write(blocks, ev.places[at(effort.follower)], &SharedLane::force, effort.wrenches.on_follower);
  get_kernels(plan).solve(plan, ev, {.source = Source::kBodyForces, .biased = false, .multipliers = false});
  double sum = dot(effort.wrenches.on_follower, ev.get_acceleration(effort.follower));
  if (effort.base != kGround) sum += dot(effort.wrenches.on_base, ev.get_acceleration(effort.base));
  return sum > 0 ? sum : 0;
}

// An evaluation of `state` that mobilities can be computed with; null if a pivot vanishes.
Evaluation* factor(const PlanData& plan, const State& state, Workspace& workspace) {
  FinalEvaluation& kept = get_data(workspace).kept;
  kept.valid = false;
  Evaluation& ev = kept.evaluation;
  load_state(plan, state, ev);
  update_kinematics(plan, ev);
  update_joints(plan, state, RowTarget::kVelocity, ev);
  const Sweep nothing{.source = Source::kNothing, .biased = false, .multipliers = false};
  if (get_kernels(plan).factor_and_solve(plan, state, ev, nothing, kAllRows) != kNone) return nullptr;
  return &ev;
}

}  // namespace

namespace {

// Calls use(kind, element of the plan, mobility along it) for the elements of the kinds for which `chosen` is true.
template <class Choose, class Use>
void for_each_mobility(const Plan& owner, const State& state, Workspace& workspace, const Choose& chosen,
                       const Use& use) {
  const PlanData& plan = get_data(owner);
  Evaluation* const ev = factor(plan, state, workspace);
  if (ev == nullptr) return;
  const Inputs none;
  const Instant now{plan, none, state, plan.get_time(state.header->tick)};
  for_each_kind([&]<class Kind>(Kind kind) {
    if constexpr (HasEffort<Kind>) {
      if (!chosen(kind)) return;
      const auto& list = Kind::of_plan(plan);
      for (std::size_t i = 0; i < list.size(); ++i)
        use(kind, list[i], calc_mobility(plan, calc_unit(Kind::calc(StageMotion{now, *ev}, list[i], i, 1)), *ev));
    }
  });
}

}  // namespace

std::vector<ElementFrequency> calc_frequencies(const Plan& owner, const State& state, Workspace& workspace) {
  std::vector<ElementFrequency> out;
  const auto is_spring = []<class Kind>(Kind) { return HasSpring<Kind>; };
  for_each_mobility(owner, state, workspace, is_spring, [&]<class Kind>(Kind, const auto& own, double mobility) {
    if constexpr (HasSpring<Kind>) {
      const LinearSpring spring = Kind::get_spring(get_data(owner), own);
      out.push_back({own.element, std::sqrt(spring.stiffness * mobility), spring.damping * mobility, spring.implicit});
    }
  });
  return out;
}

std::vector<ElementMobility> calc_mobilities(const Plan& owner, const State& state, Workspace& workspace) {
  std::vector<ElementMobility> out;
  const auto has_friction = []<class Kind>(Kind) { return Kind::kHasFriction; };
  for_each_mobility(owner, state, workspace, has_friction, [&](auto, const auto& own, double mobility) {
    out.push_back({own.element, mobility});
  });
  return out;
}

}  // namespace unlatch
