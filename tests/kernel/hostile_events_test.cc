// Hostile events: at t = 0, many at one instant, triggering one another, chattering. They act in their order, with
// bounded work.
#include <gtest/gtest.h>

#include "tests/support/survival.h"

namespace unlatch::test::hostile_events_test {
namespace {

TEST(Hostile, EventsOfEveryKindAtTheBeginningActThere) {
  using Kind = Condition::Kind;
  Model model = build_pendulum(true, 0);
  model.signals = {"a"};
  model.channels.push_back({"c", 1, 0, 1, 0, "1"});
  for (const Condition& condition :
       {when_time(0), when_time(-5), when(Kind::kDisplacement, 0, kX, 0), when(Kind::kAngle, 0, kRotZ, 0),
        when(Kind::kSpeed, 0, kRotZ, 0), when(Kind::kBodyRate, 0, 0, 0), when(Kind::kCommand, 0, 0, 1)}) {
    model.events.push_back({"e" + std::to_string(model.events.size()), "", condition, 0, {act_raise(0)}, false});
  }
  model.events.push_back({"latch", "", when_time(0), 0, {act_set_mode(0, 1)}, false});
  model.events.push_back({"release", "", when(Kind::kSignal, 0, 0, 0), 0, {act_set_mode(0, 2)}, false});
  Simulation s(model);
  const Traps traps;
  const StepReport report = s.advance();
  ASSERT_EQ(report.status, StepStatus::kOk);
  ASSERT_EQ(report.events.size(), model.events.size());
  for (const FiredEvent& fired : report.events) EXPECT_EQ(fired.time, 0);
  EXPECT_EQ(s.state.joints[0].mode, 2);
}

// Events in the middle of a step, each releasing and latching joints of others.
TEST(Hostile, AHundredEventsAtOneInstantActThereInTheirOrder) {
  constexpr int kBodies = 50;
  constexpr double kInstant = 0.00237;
  Model model;
  model.gravity.uniform = {0, -9.81, 0};
  for (int k = 0; k < kBodies; ++k) {
    model.bodies.push_back(box("b" + std::to_string(k), 1, 0.1, 0.1, 0.1));
    model.bodies.back().p_WB = {k + 0.5, 0, 0};
    model.joints.push_back(build_joint(k - 1, k, {k == 0 ? 0.0 : 0.5, 0, 0}, {-0.5, 0, 0},
                                       {{"hinge", kRevoluteRows}, {"free", 0}, {"weld", kWeldRows}}));
  }
  for (int mode : {1, 2})
    for (int k = 0; k < kBodies; ++k)
      model.events.push_back(
          {"e" + std::to_string(model.events.size()), "", when_time(kInstant), 0, {act_set_mode(k, mode)}, false});
  Simulation s(model);
  const Traps traps;
  int fired = 0;
  for (int i = 0; i < 10; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& event : report.events) {
      EXPECT_EQ(event.event, fired++);
      EXPECT_NEAR(event.time, kInstant, 1e-15);
    }
  }
  EXPECT_EQ(fired, 2 * kBodies);
  for (const JointState& joint : s.state.joints) EXPECT_EQ(joint.mode, 2);
}

// Each immediately undoes the other's condition.
TEST(Hostile, EventsThatChaseOneAnotherAreBounded) {
  Model model = build_pendulum(true, 1);
  model.signals = {"ping"};
  Action lower = act_raise(0);
  lower.value = 0;
  Condition off = when(Condition::Kind::kNot, 0, 0, 0);
  off.parts = {when(Condition::Kind::kSignal, 0, 0, 0)};
  model.events.push_back({"raise", "", off, 0, {act_raise(0)}, true});
  model.events.push_back({"lower", "", when(Condition::Kind::kSignal, 0, 0, 0), 0, {lower}, true});
  const Survival survival = survive(model, 500);
  EXPECT_GT(survival.fired, 0);
}

// A joint that locks as soon as it turns, and is released as soon as it is locked: several times a step.
TEST(Hostile, AChatteringLatchIsBounded) {
  using Kind = Condition::Kind;
  Model model = build_pendulum(true, 0);
  model.gravity.uniform = {0, 9.81, 0};
  model.events.push_back({"lock", "", when(Kind::kSpeed, 0, kRotZ, 1e-4), 0, {act_set_mode(0, 1)}, true});
  model.events.push_back({"free", "", when(Kind::kMode, 0, 1, 0), 1e-4, {act_set_mode(0, 0)}, true});
  const Survival survival = survive(model, 1000);
  EXPECT_EQ(survival.status, StepStatus::kOk);
  EXPECT_GT(survival.fired, 1000);
}

// A guard that touches zero without crossing it, and one that is zero all the time.
TEST(Hostile, GuardsThatStandAtZeroAreBounded) {
  Model model = build_pendulum(true, 0);
  model.events.push_back({"always", "", when(Condition::Kind::kSpeed, 0, kRotZ, 0), 0, {}, true});
  model.events.push_back({"edge", "", when(Condition::Kind::kAngle, 0, kRotZ, 0), 0.0005, {}, true});
  Simulation s(model);
  const Traps traps;
  EXPECT_EQ(survive(s, 1000).status, StepStatus::kOk);
}

TEST(Hostile, ALatchHitAtZeroSpeedChangesNothing) {
  Model model = build_pendulum(false, 0);
  model.events.push_back({"latch", "", when_time(0.0105), 0, {act_set_mode(0, 1)}, false});
  Simulation s(model);
  const Traps traps;
  for (int i = 0; i < 20; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    for (const EventAudit& audit : report.audits) EXPECT_EQ(audit.jump.kinetic, 0);
  }
  EXPECT_EQ(s.state.joints[0].mode, 1);
  for (const BodyState& body : s.state.bodies) EXPECT_EQ(body.v.y, 0);
}

}  // namespace
}  // namespace unlatch::test::hostile_events_test
