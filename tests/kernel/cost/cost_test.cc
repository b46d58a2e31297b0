// Limits of a step and its bound, from plans alone. That no step is above its bound: cost_test.py and tools/cost
// verify.
#include <gtest/gtest.h>

#include <string>

#include "kernel/cost/work.h"
#include "kernel/events/limits.h"
#include "tests/support/contact_models.h"
#include "tests/support/random_elements.h"
#include "tests/support/random_model.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/cost/step_cost.h"

namespace unlatch::test {
namespace {

StepLimits calc_limits(const Model& model, int max_splits = 8) {
  return calc_step_limits(compile_or_throw(model, {.max_splits = max_splits}));
}

Event at_time(double t, double delay, bool repeat) {
  return {"at " + std::to_string(t), "", when_time(t), delay, {}, repeat, false};
}

TEST(StepLimits, AStepWithoutEventsIsOneIntegration) {
  const StepLimits limits = calc_limits(build_pendulum(true, 0));
  EXPECT_EQ(limits.parts, 1);
  EXPECT_EQ(limits.sub_steps, 1);
  EXPECT_EQ(limits.tries, 1);
  EXPECT_EQ(limits.rounds, 0);
}

TEST(StepLimits, AnEventWithADelaySplitsTwiceAndActsOnce) {
  Model model = build_pendulum(true, 0);
  model.events = {at_time(0.1, 0, false), at_time(0.2, 0.5, false)};
  const StepLimits limits = calc_limits(model);
  EXPECT_EQ(limits.splits, 3);
  EXPECT_EQ(limits.rounds, 2);
  EXPECT_EQ(limits.waits, 1);
  EXPECT_EQ(limits.sub_steps, 4);
  EXPECT_EQ(limits.tries, 4 + 3 * 24);
}

TEST(StepLimits, ARepeatingEventSplitsAsOftenAsThePlanAllows) {
  Model model = build_pendulum(true, 0);
  model.events = {at_time(0.1, 0, true)};
  EXPECT_EQ(calc_limits(model, 5).splits, 5);
  EXPECT_EQ(calc_limits(model, 5).rounds, 6);  // at the beginning too
}

TEST(StepLimits, AClosedContactCutsAStepIntoItsPartsAndEachIsSearchedForTouches) {
  Model model = build_dropped_ball(1);
  model.contact_substeps = 16;
  EXPECT_EQ(calc_limits(model).parts, 16);
  model.contact_substeps = kAutomaticSubsteps;
  const StepLimits limits = calc_limits(model);
  EXPECT_EQ(limits.parts, kMaxAutomaticSubsteps);
  EXPECT_EQ(limits.sub_steps, kMaxAutomaticSubsteps + 8 + kMostFeatureSplits);
  EXPECT_EQ(limits.searches, 8 * 24 + kMostFeatureSplits * kMostFeatureTries + limits.sub_steps * 9);
}

TEST(StepCost, ItGrowsWithEveryLimit) {
  const Plan plan = compile_or_throw(build_dropped_ball(1), {});
  const CostTarget& target = *list_cost_targets().front();
  const StepLimits one;
  const double least = calc_step_cost(plan, target, one).instructions;
  for (std::int64_t StepLimits::*limit : {&StepLimits::sub_steps, &StepLimits::tries, &StepLimits::rounds}) {
    StepLimits more = one;
    more.*limit += 1;
    EXPECT_GT(calc_step_cost(plan, target, more).instructions, least);
  }
}

TEST(StepCost, ItIsTheSumOfItsPhases) {
  const Plan plan = compile_or_throw(build_random_system(7), {});
  for (const CostTarget* target : list_cost_targets()) {
    const StepCost cost = calc_step_cost(plan, *target, calc_step_limits(plan));
    double sum = 0;
    for (const CostRow& row : cost.rows) sum += row.bodies + row.forces + row.solver + row.rest;
    EXPECT_DOUBLE_EQ(sum, cost.instructions) << target->name;
  }
}

TEST(StepCost, MoreBodiesCostMore) {
  RandomModelOptions options{.shape = RandomModelOptions::Shape::kChain, .common_kinds = true};
  double before = 0;
  for (options.bodies = 2; options.bodies < 40; options.bodies *= 2) {
    const Plan plan = compile_or_throw(build_random_model(3, options), {});
    const double now = calc_step_cost(plan, *find_cost_target("x86-64"), {}).instructions;
    EXPECT_GT(now, before);
    before = now;
  }
}

TEST(StepCost, EveryTargetIsFoundByItsName) {
  for (const CostTarget* target : list_cost_targets()) EXPECT_EQ(find_cost_target(target->name), target);
  EXPECT_EQ(find_cost_target("vax"), nullptr);
}

TEST(Work, NarrowerPacksNeedMorePasses) {
  const Plan plan =
      compile_or_throw(build_random_model(11, {.shape = RandomModelOptions::Shape::kStar, .bodies = 30}), {});
  const auto count_passes = [&](int lanes) {
    using cost::Unit;
    const cost::Work work = cost::count_work(plan, lanes);
    return work[Unit::kJoints1] + work[Unit::kJoints2] + work[Unit::kJoints4];
  };
  EXPECT_GE(count_passes(1), count_passes(2));
  EXPECT_GT(count_passes(1), count_passes(4));
  EXPECT_GE(count_passes(4), count_passes(8));
}

}  // namespace
}  // namespace unlatch::test
