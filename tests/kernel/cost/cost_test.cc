// Limits of a step and its bound, from plans alone. That no step is above its bound: cost_test.py and tools/cost
// verify.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "kernel/cost/step_counts.h"
#include "kernel/cost/work.h"
#include "kernel/events/limits.h"
#include "tests/support/contact_models.h"
#include "tests/support/random_elements.h"
#include "tests/support/random_model.h"
#include "tests/support/rigid_models.h"
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

TEST(StepLimits, RigidContactsAddTheRoundsThatTheirChangesMayTake) {
  const auto count_rounds = [](bool rigid, double friction) {
    Model model = build_dropped_ball(1);
    if (rigid) model = build_bouncing_ball(1, 0.5);
    model.contacts[0].friction = friction;
    return calc_limits(model).rounds;
  };
  const std::int64_t instants = 1 + 8;  // the beginning, and splits
  EXPECT_EQ(count_rounds(true, 0) - count_rounds(false, 0), instants * (kRigidRounds + 1));
  EXPECT_EQ(count_rounds(true, 0.5) - count_rounds(false, 0), instants * (kRoughRounds + 1));
}

TEST(StepCost, PlansWithRigidContactsHaveABoundThatGrowsWithTheirRows) {
  Model smooth = build_rigid_feet(), rough = smooth, more = smooth;
  rough.contacts[0].friction = 0.5;
  more.surfaces[1].shapes.push_back(build_sphere(0.125, {0, 0, -0.125}));
  for (const CostTarget* target : list_cost_targets()) {
    const auto calc = [&](const Model& model) {
      const Plan plan = compile_or_throw(model, {});
      const StepCost cost = calc_step_cost(plan, *target, get_counted_limits(plan, {.integrations = 3, .rounds = 2}));
      EXPECT_TRUE(cost.unmeasured.empty()) << target->name << ": " << cost.unmeasured.front();
      return cost.instructions;
    };
    EXPECT_GT(calc(rough), calc(smooth)) << target->name;
    EXPECT_GT(calc(more), calc(smooth)) << target->name;
  }
}

TEST(StepLimits, AStepWithMoreRoundsThanAuditsCountsWithTheMostThatItMayHave) {
  const Plan plan = compile_or_throw(build_bouncing_ball(1, 0.5), {});
  const StepLimits most = calc_step_limits(plan);
  EXPECT_EQ(get_counted_limits(plan, {.integrations = 3, .rounds = 2}).rounds, 2);
  EXPECT_EQ(get_counted_limits(plan, {.integrations = 3, .rounds = 1000}).rounds, most.rounds);
}

TEST(StepLimits, WhereEventsAloneSplitAStepEachSplitHasItsRound) {
  Model model = build_pendulum(true, 0);
  model.events = {at_time(0.1, 0, false), at_time(0.2, 0, false)};
  const StepLimits limits = get_counted_limits(compile_or_throw(model, {}), {.integrations = 9, .rounds = 1});
  EXPECT_EQ(limits.sub_steps, 2);
  EXPECT_EQ(limits.tries, 9);
  EXPECT_EQ(limits.searches, 7);
}

// A joint that an event sets from its first mode, with rows, to its second one, with fewer; `back`: another event sets
// it back at a time, in whatever mode it is.
Model build_release(bool back) {
  Model model;
  model.bodies = {box("a", 1, 1, 1, 1), box("b", 1, 1, 1, 1)};
  Joint joint;
  joint.name = "joint";
  joint.base = 0;
  joint.follower = 1;
  joint.modes = {{"held", kPointRows}, {"free", 0}};
  model.joints = {joint};
  Event release = at_time(0.1, 0, false);
  release.then = {{.kind = Action::Kind::kSetMode, .subject = 0, .mode = 1}};
  Condition both;
  both.kind = Condition::Kind::kAll;
  both.parts = {when_time(0.1), when(Condition::Kind::kMode, 0, 0, 0)};
  release.when = both;
  model.events = {release};
  if (!back) return model;
  Event hold = at_time(0.2, 0, false);
  hold.then = {{.kind = Action::Kind::kSetMode, .subject = 0, .mode = 0}};
  model.events.push_back(hold);
  return model;
}

TEST(StepLimits, VelocitiesJumpOnlyWhereAnActionMayAddRows) {
  EXPECT_EQ(calc_limits(build_release(false)).jumps, 0);
  EXPECT_EQ(calc_limits(build_release(true)).jumps, 1);
}

TEST(StepLimits, AnEventThatActsInOneModeAddsTheRowsThatThisModeLacks) {
  Model model = build_release(true);
  Event& hold = model.events.back();
  Condition both;
  both.kind = Condition::Kind::kAll;
  both.parts = {when_time(0.2), when(Condition::Kind::kMode, 0, 0, 0)};
  hold.when = both;  // only while it is held; but the release may act before it in the same round
  EXPECT_EQ(calc_limits(model).jumps, 1);
  model.events.erase(model.events.begin());
  EXPECT_EQ(calc_limits(model).jumps, 0);
  model.events.front().delay = 0.1;  // by then it may have any mode
  EXPECT_EQ(calc_limits(model).jumps, 1);
}

TEST(StepLimits, EventsThatBeginToWaitTogetherTakeOneRound) {
  Model model = build_pendulum(true, 0);
  model.events = {at_time(0.1, 0.5, false), at_time(0.1, 0.5, false), at_time(0.2, 0.5, false)};
  model.events[1].name = "also";
  const Plan plan = compile_or_throw(model, {});
  const EventState armed{EventPhase::kArmed, 0}, first{EventPhase::kPending, 0.6}, second{EventPhase::kPending, 0.7};
  const EventState spent{EventPhase::kSpent, 0};
  const auto count = [&](const std::vector<EventState>& before, const std::vector<EventState>& after,
                         const std::vector<FiredEvent>& fired) {
    return cost::count_waits(get_data(plan), before, after, fired);
  };
  EXPECT_EQ(count({armed, armed, armed}, {first, first, armed}, {}), 1);
  EXPECT_EQ(count({armed, armed, armed}, {first, first, second}, {}), 2);
  EXPECT_EQ(count({first, first, armed}, {first, first, second}, {}), 1);
  EXPECT_EQ(count({first, first, armed}, {spent, spent, armed}, {{0, 0.6}, {1, 0.6}}), 0);
  EXPECT_EQ(count({armed, armed, armed}, {armed, armed, spent}, {{2, 0.7}}), 1);
}

TEST(StepCost, ItGrowsWithEveryLimit) {
  const Plan plan = compile_or_throw(build_dropped_ball(1), {});
  const CostTarget& target = *list_cost_targets().front();
  const StepLimits one;
  const double least = calc_step_cost(plan, target, one).instructions;
  for (std::int64_t StepLimits::*limit :
       {&StepLimits::sub_steps, &StepLimits::tries, &StepLimits::rounds, &StepLimits::waits, &StepLimits::jumps}) {
    StepLimits more = one;
    more.*limit += 1;
    EXPECT_GT(calc_step_cost(plan, target, more).instructions, least);
  }
}

// What one more sub-step costs.
double calc_substep_cost(const Plan& plan, const CostTarget& target) {
  const StepLimits one, two{.sub_steps = 2};
  return calc_step_cost(plan, target, two).instructions - calc_step_cost(plan, target, one).instructions;
}

TEST(StepCost, TheStateIsCopiedOncePerStepHoweverManySubStepsItHas) {
  Model model = build_pendulum(true, 0), more = model;
  for (int i = 0; i < 64; ++i) more.signals.push_back("signal" + std::to_string(i));  // nothing but words of the state
  const Plan plan = compile_or_throw(model, {}), larger = compile_or_throw(more, {});
  const CostTarget& target = *find_cost_target("x86-64");
  EXPECT_GT(calc_step_cost(larger, target, {}).instructions, calc_step_cost(plan, target, {}).instructions);
  EXPECT_DOUBLE_EQ(calc_substep_cost(larger, target), calc_substep_cost(plan, target));
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

// Two loads that share an exponential; `apart`: an event switches one of them off.
double count_exponentials(bool apart) {
  Model model;
  model.bodies = {box("body", 1, 1, 1, 1)};
  Profile profile;
  profile.kind = Profile::Kind::kExponential;
  profile.initial = 1;
  profile.tau = 1;
  for (const char* name : {"a", "b"}) {
    Load load;
    load.name = name;
    load.profile = profile;
    model.loads.push_back(load);
  }
  if (apart) {
    Event event = at_time(0.1, 0, false);
    event.then = {{.kind = Action::Kind::kSwitch, .subject = 1, .value = 0.5}};
    model.events = {event};
  }
  return cost::count_work(compile_or_throw(model, {}), 1)[cost::Unit::kExponentials];
}

TEST(Work, LoadsThatAreSwitchedAlikeReadOneValueOfTheirProfile) {
  EXPECT_EQ(count_exponentials(false), 1);
  EXPECT_EQ(count_exponentials(true), 2);
}

TEST(Work, ForcesAreClearedOncePerEightOfLoadedBodiesHoweverNarrowThePacks) {
  Model model = build_random_model(11, {.shape = RandomModelOptions::Shape::kStar, .bodies = 6});
  const auto count = [&](cost::Unit unit, int lanes) {
    return cost::count_work(compile_or_throw(model, {}), lanes)[unit];
  };
  EXPECT_EQ(count(cost::Unit::kLoadedEights, 1), 0);
  Load load;
  load.name = "load";
  model.loads.push_back(load);
  EXPECT_EQ(count(cost::Unit::kLoadedEights, 1), 1);
  EXPECT_EQ(count(cost::Unit::kLoadedEights, 4), 1);
  EXPECT_GT(count(cost::Unit::kLoaded, 1), count(cost::Unit::kLoaded, 4));
}

TEST(Work, EveryUnitHasANameOfItsOwn) {
  std::set<std::string> names;
  for (const char* name : cost::kUnitNames) EXPECT_TRUE(names.insert(name).second) << name;
  EXPECT_EQ(names.size(), cost::kUnits);
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
