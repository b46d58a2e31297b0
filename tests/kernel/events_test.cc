// Times, order and allowed effects of events.
#include <gtest/gtest.h>

#include <cmath>

#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::events_test {
namespace {

struct Fired {
  double time;
  std::string name;
};

std::vector<Fired> run(Simulation& s, const Model& model, int ticks) {
  std::vector<Fired> log;
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    EXPECT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& fired : report.events)
      log.push_back({fired.time, model.events[static_cast<std::size_t>(fired.event)].name});
  }
  return log;
}

constexpr double kExactTime = 1e-15;    // s: known times split the step exactly
constexpr double kLocatedTime = 1e-10;  // s: a smooth guard, a step of 1 ms

TEST(Events, AKnownTimeSplitsTheStepThere) {
  Model model = build_pendulum(true, 1);
  model.signals = {"a"};
  model.events.push_back({"at", "", when_time(0.00237), 0, {act_raise(0)}, false});
  model.events.push_back({"after", "", when(Condition::Kind::kSignal, 0, 0, 0), 0.0041, {}, false});
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 10);
  ASSERT_EQ(log.size(), 2u);
  EXPECT_NEAR(log[0].time, 0.00237, kExactTime);
  EXPECT_NEAR(log[1].time, 0.00237 + 0.0041, kExactTime);
}

TEST(Events, AGuardIsLocatedWhereItCrosses) {
  Model model = build_pendulum(true, 2);  // no gravity: the angle is 2 t exactly
  model.events.push_back({"angle", "", when(Condition::Kind::kAngle, 0, kRotZ, 0.12345), 0, {}, false});
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 100);
  ASSERT_EQ(log.size(), 1u);
  EXPECT_NEAR(log[0].time, 0.12345 / 2, kLocatedTime);
}

TEST(Events, AnglesCountTheirTurns) {
  Model model = build_pendulum(true, 10);
  model.events.push_back({"third turn", "", when(Condition::Kind::kAngle, 0, kRotZ, 6 * M_PI), 0, {}, false});
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 2000);
  ASSERT_EQ(log.size(), 1u);
  EXPECT_NEAR(log[0].time, 0.6 * M_PI, 1e-8);  // the integrator's error over three turns
}

TEST(Events, SimultaneousOnesActTogetherInTheirOrder) {
  Model model = build_pendulum(true, 2);
  for (const char* name : {"first", "second", "third"})
    model.events.push_back({name, "", when(Condition::Kind::kAngle, 0, kRotZ, 0.1 + 0.2), 0, {}, false});
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 200);
  ASSERT_EQ(log.size(), 3u);
  EXPECT_EQ(log[0].name, "first");
  EXPECT_EQ(log[2].name, "third");
  EXPECT_EQ(log[0].time, log[2].time);
}

TEST(Events, ManyInOneStepActInTheOrderOfTheirTimes) {
  Model model = build_pendulum(true, 2);
  for (int k = 0; k < 6; ++k)  // all within the step from 0.1 to 0.101 s
    model.events.push_back(
        {std::to_string(5 - k), "", when(Condition::Kind::kAngle, 0, kRotZ, 0.2 + 0.0003 * (6 - k)), 0, {}, false});
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 200);
  ASSERT_EQ(log.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(log[k].name, std::to_string(k));
    EXPECT_NEAR(log[k].time, 0.1 + 0.00015 * static_cast<double>(k + 1), kLocatedTime);
  }
}

TEST(Events, MoreThanTheBoundInOneStepAreCountedAndActAtTheNextTick) {
  Model model = build_pendulum(true, 2);
  for (int k = 0; k < 5; ++k)
    model.events.push_back(
        {"e" + std::to_string(k), "", when(Condition::Kind::kAngle, 0, kRotZ, 0.2 + 0.0003 * (k + 1)), 0, {}, false});
  PlanOptions options;
  options.max_splits = 2;
  Simulation s(model, options);
  int postponed = 0, fired = 0;
  double last = 0;
  for (int i = 0; i < 103; ++i) {
    const StepReport report = s.advance();
    postponed += report.postponed;
    for (const FiredEvent& event : report.events) {
      ++fired;
      last = event.time;
    }
  }
  EXPECT_EQ(postponed, 3);
  EXPECT_EQ(fired, 5);
  EXPECT_NEAR(last, 0.101, kExactTime);
}

TEST(Events, ThoseThatHoldAtTheStartActAtTheStart) {
  Model model = build_pendulum(true, 1);
  for (int k = 0; k < 100; ++k) model.events.push_back({"e" + std::to_string(k), "", when_time(0), 0, {}, false});
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 1);
  ASSERT_EQ(log.size(), 100u);
  EXPECT_EQ(log[99].time, 0);
}

TEST(Events, ARepeatingOneActsAtEveryUpwardCrossing) {
  Model model = build_pendulum(true, 0);
  model.gravity.uniform = {0, -9.81, 0};
  Event rising{"rising", "", when(Condition::Kind::kSpeed, 0, kRotZ, 0), 0, {}, true};
  model.events.push_back(rising);
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 6000);
  // The bar swings from rest at the horizontal; its speed turns positive once a period: T = 4 √(2l/3g) K(1/√2).
  const double period = 4 * std::sqrt(2.0 / 3 / 9.81) * 1.8540746773013719;
  ASSERT_GE(log.size(), 4u);
  EXPECT_NEAR(log[2].time - log[1].time, period, 1e-6);
  EXPECT_NEAR(log[3].time - log[2].time, period, 1e-6);
}

TEST(Events, CombinationsHoldWhenAllOrAnyOrNoneOfTheirPartsDo) {
  Model model = build_pendulum(true, 2);
  const Condition angle = when(Condition::Kind::kAngle, 0, kRotZ, 0.1), time = when_time(0.08);
  Condition all{.kind = Condition::Kind::kAll, .parts = {angle, time}},
      any{.kind = Condition::Kind::kAny, .parts = {angle, time}};
  Condition both = all;
  both.parts.push_back({.kind = Condition::Kind::kNot, .parts = {when_time(1)}});
  model.events = {{"all", "", all, 0, {}, false}, {"any", "", any, 0, {}, false}, {"not", "", both, 0, {}, false}};
  Simulation s(model);
  const std::vector<Fired> log = run(s, model, 100);
  ASSERT_EQ(log.size(), 3u);
  EXPECT_EQ(log[0].name, "any");
  EXPECT_NEAR(log[0].time, 0.05, kLocatedTime);
  EXPECT_NEAR(log[1].time, 0.08, kLocatedTime);
  EXPECT_NEAR(log[2].time, 0.08, kLocatedTime);
}

TEST(Events, ALatchConservesMomentumAndLosesWhatItMay) {
  constexpr double kRounding = 1e-13;
  Model model = build_pendulum(false, 3);
  model.events.push_back(
      {"latch", "bar", when(Condition::Kind::kAngle, 0, kRotZ, 0.5), 0, {act_set_mode(0, 1)}, false});
  Simulation s(model);
  bool latched = false;
  for (int i = 0; i < 400; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    for (const EventAudit& audit : report.audits) {
      latched = true;
      EXPECT_LT(norm(audit.jump.momentum), kRounding);
      EXPECT_LT(norm(audit.jump.angular_momentum), kRounding * 10);
      EXPECT_LT(audit.jump.kinetic, 0);
      EXPECT_NEAR(audit.jump.kinetic, audit.allowed.kinetic, kRounding * audit.before.kinetic * 10);
    }
  }
  ASSERT_TRUE(latched);
  update_motion(s);
  update_coordinates(s.data(), s.state, CoordinateSet::kAll, s.evaluation());
  EXPECT_NEAR(s.evaluation().coordinates[find_coordinate(s.data(), 0, kRotZ)], 0.5, 1e-9);  // it stays where it latched
  EXPECT_NEAR(s.evaluation().speeds[find_coordinate(s.data(), 0, kRotZ)], 0, 1e-12);
  EXPECT_LT(calc_drift(s.data(), s.state, s.evaluation()), 1e-12);
}

TEST(Events, ALatchToTheGroundIsEntitledToItsImpulse) {
  constexpr double kRounding = 1e-13;
  Model model = build_pendulum(true, 3);
  model.events.push_back(
      {"latch", "bar", when(Condition::Kind::kAngle, 0, kRotZ, 0.5), 0, {act_set_mode(0, 1)}, false});
  Simulation s(model);
  int audits = 0;
  for (int i = 0; i < 400; ++i)
    for (const EventAudit& audit : s.advance().audits) {
      ++audits;
      EXPECT_GT(norm(audit.jump.momentum), 1);
      EXPECT_LT(norm(audit.jump.momentum - audit.allowed.momentum), kRounding * 10);
      EXPECT_LT(norm(audit.jump.angular_momentum - audit.allowed.angular_momentum), kRounding * 10);
      EXPECT_NEAR(audit.jump.kinetic, audit.allowed.kinetic, kRounding * audit.before.kinetic * 10);
    }
  EXPECT_EQ(audits, 1);
}

}  // namespace
}  // namespace unlatch::test::events_test
