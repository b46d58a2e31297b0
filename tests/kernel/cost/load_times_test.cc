// When loads may be on, and how many ramps may end in one step, from plans alone: kernel/cost/load_times.h.
#include "kernel/cost/load_times.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "kernel/cost/work.h"
#include "kernel/events/limits.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/cost/step_cost.h"

namespace unlatch::test {
namespace {

constexpr double kDt = 0.001;

Plan compile(const Model& model) { return compile_or_throw(model, {.dt = kDt}); }

// A body with loads; those at `on` are on at the start.
Model build_loaded_body(const std::vector<bool>& on) {
  Model model;
  model.bodies = {box("body", 1, 1, 1, 1)};
  for (std::size_t i = 0; i < on.size(); ++i) {
    Load load;
    load.name = "load" + std::to_string(i);
    load.on = on[i];
    model.loads.push_back(load);
  }
  return model;
}

Action turn(int load, double value) { return {.kind = Action::Kind::kSwitch, .subject = load, .value = value}; }
Action ramp(int load, double value, double duration) {
  return {.kind = Action::Kind::kRamp, .subject = load, .value = value, .duration = duration};
}

void add_event(Model& model, const Condition& condition, double delay, const std::vector<Action>& then,
               bool repeat = false) {
  model.events.push_back({"event" + std::to_string(model.events.size()), "", condition, delay, then, repeat, false});
}

TEST(LoadTimes, AnEventThatASignalCausesActsNoEarlierThanTheEventThatRaisesIt) {
  Model model = build_loaded_body({true});
  model.signals = {"raised", "silent"};
  add_event(model, when_time(0.5), 0, {{.kind = Action::Kind::kRaise, .subject = 0, .value = 1}});
  add_event(model, when(Condition::Kind::kSignal, 0, 0, 0), 0.25, {});
  add_event(model, when(Condition::Kind::kSignal, 1, 0, 0), 0, {});
  const std::vector<double> times = cost::calc_earliest_times(get_data(compile(model)));
  EXPECT_DOUBLE_EQ(times[0], 0.5 - kDt);
  EXPECT_DOUBLE_EQ(times[1], 0.5 - kDt + 0.25);
  EXPECT_EQ(times[2], HUGE_VAL);
}

TEST(LoadTimes, ALoadThatIsSwitchedAtKnownTimesIsOnBetweenThem) {
  Model model = build_loaded_body({true, false});
  add_event(model, when_time(0.5), 0, {turn(0, 0)});
  add_event(model, when_time(0.25), 0, {turn(1, 1)});
  const std::vector<std::vector<cost::OnSpan>> spans = cost::list_on_spans(get_data(compile(model)));
  ASSERT_EQ(spans[0].size(), 1U);
  EXPECT_EQ(spans[0].front().from, 0);
  EXPECT_GE(spans[0].front().to, 0.5 + kDt);  // the event may be left to the next step
  EXPECT_LT(spans[0].front().to, 0.5 + 4 * kDt);
  ASSERT_EQ(spans[1].size(), 1U);
  EXPECT_LE(spans[1].front().from, 0.25);
  EXPECT_EQ(spans[1].front().to, HUGE_VAL);
}

TEST(LoadTimes, ALoadThatAMeasuredEventSwitchesOffMayStayOn) {
  Model model = build_loaded_body({true});
  add_event(model, when(Condition::Kind::kBodyRate, 0, 0, 1), 0, {turn(0, 0)});
  const std::vector<std::vector<cost::OnSpan>> spans = cost::list_on_spans(get_data(compile(model)));
  ASSERT_EQ(spans[0].size(), 1U);
  EXPECT_EQ(spans[0].front().to, HUGE_VAL);
}

TEST(LoadTimes, EachLoadThatAnEventSwitchesOnTakesOverFromOneThatItSwitchesOff) {
  Model model = build_loaded_body({true, true, false, false, false});
  add_event(model, when(Condition::Kind::kBodyRate, 0, 0, 1), 0,
            {turn(0, 0), turn(2, 1), turn(1, 0), turn(3, 1), turn(4, 1)});
  const Plan plan = compile(model);
  EXPECT_EQ(cost::list_predecessors(get_data(plan)), (std::vector<std::int32_t>{kNone, kNone, 0, 1, kNone}));
  EXPECT_EQ(cost::count_work(plan, 1)[cost::Unit::kOnLoads], 3);
}

TEST(LoadTimes, ALoadThatMayComeOnAgainHasNoSuccessor) {
  Model model = build_loaded_body({true, false});
  add_event(model, when(Condition::Kind::kBodyRate, 0, 0, 1), 0, {turn(0, 0), turn(1, 1)});
  add_event(model, when(Condition::Kind::kBodyRate, 0, 0, 2), 0, {turn(0, 1)});
  const Plan plan = compile(model);
  EXPECT_EQ(cost::list_predecessors(get_data(plan)), (std::vector<std::int32_t>{kNone, kNone}));
  EXPECT_EQ(cost::count_work(plan, 1)[cost::Unit::kOnLoads], 2);
}

TEST(LoadTimes, ALoadThatComesOnAtKnownTimesBeforeEndsWithTheEventThatSwitchesItOff) {
  Model model = build_loaded_body({true, false});
  add_event(model, when_time(0.25), 0, {ramp(0, 0.5, 0.125)});
  add_event(model, when_time(0.5), 0, {turn(0, 0), turn(1, 1)});
  Plan plan = compile(model);
  EXPECT_EQ(cost::list_predecessors(get_data(plan)), (std::vector<std::int32_t>{kNone, 0}));
  EXPECT_EQ(cost::count_work(plan, 1)[cost::Unit::kOnLoads], 1);
  model.events.front().when.threshold = 0.5 - kDt;  // it may be left to the step of the other one
  plan = compile(model);
  EXPECT_EQ(cost::list_predecessors(get_data(plan)), (std::vector<std::int32_t>{kNone, kNone}));
}

std::int64_t count_corners(const Model& model) { return cost::count_timed_corners(get_data(compile(model))); }

TEST(TimedCorners, RampsThatEndFarApartAreNotInOneStep) {
  Model model = build_loaded_body({true, true});
  add_event(model, when_time(0.25), 0, {ramp(0, 0, 0.25)});
  EXPECT_EQ(count_corners(model), 1);
  add_event(model, when_time(0.5), 0, {ramp(1, 0, 0.25)});
  EXPECT_EQ(count_corners(model), 1);
}

TEST(TimedCorners, RampsWhoseEndsMayFallIntoOneStepCountEach) {
  Model model = build_loaded_body({true, true});
  add_event(model, when_time(0.25), 0, {ramp(0, 0, 0.5)});
  add_event(model, when_time(0.5), 0, {ramp(1, 0, 0.25 + 0.5 * kDt)});
  EXPECT_EQ(count_corners(model), 2);
  model.events.back().then = {ramp(1, 0, 0.25 + 2 * kDt)};  // the earlier one may be left to the next step
  EXPECT_EQ(count_corners(model), 2);
}

TEST(TimedCorners, RampsOfOneEventEndTogetherIfTheyLastAsLong) {
  Model model = build_loaded_body({true, true});
  add_event(model, when_time(0.25), 0, {ramp(0, 0, 0.25), ramp(1, 0, 0.25)});
  EXPECT_EQ(count_corners(model), 1);
  model.events.back().then.back().duration = 0.25 + 0.5 * kDt;
  EXPECT_EQ(count_corners(model), 2);
}

TEST(TimedCorners, ARampThatBeginsAtAnyTimeMayEndInAnyStep) {
  Model model = build_loaded_body({true, true});
  add_event(model, when_time(0.25), 0, {ramp(0, 0, 0.25)});
  add_event(model, when(Condition::Kind::kBodyRate, 0, 0, 1), 0, {ramp(1, 0, 0.25)});
  EXPECT_EQ(count_corners(model), 2);
}

TEST(TimedCorners, WhereRampsRecurOrTablesAreReadAStepMayHaveTheMost) {
  Model ramps = build_loaded_body({true});
  add_event(ramps, when(Condition::Kind::kBodyRate, 0, 0, 1), 0, {ramp(0, 0, 0.25)}, true);
  EXPECT_EQ(count_corners(ramps), kMostCornerSplits);
  Model table = build_loaded_body({true});
  table.loads[0].profile.kind = Profile::Kind::kTable;
  table.loads[0].profile.times = {0, 1, 2};
  table.loads[0].profile.values = {0, 1, 0};
  EXPECT_EQ(count_corners(table), kMostCornerSplits);
}

TEST(StepLimits, AStepOfOneSearchHasTwoSubStepsAlsoWhereARampMayEnd) {
  Model model = build_loaded_body({true});
  add_event(model, when_time(0.25), 0, {ramp(0, 0, 0.25)});
  add_event(model, when(Condition::Kind::kBodyRate, 0, 0, 1), 0, {});
  const Plan plan = compile(model);
  EXPECT_EQ(calc_step_limits(plan).sub_steps, 1 + 2 + 1);
  EXPECT_EQ(get_counted_limits(plan, {.integrations = 4, .rounds = 1}).sub_steps, 2);
  EXPECT_EQ(get_counted_limits(plan, {.integrations = 5, .rounds = 1}).sub_steps, 3);
  EXPECT_EQ(get_counted_limits(plan, {.integrations = 2}).sub_steps, 2);
}

}  // namespace
}  // namespace unlatch::test
