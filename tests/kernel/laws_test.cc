// Laws: forces against closed forms, functions, scales, commands, events, what is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/law_models.h"
#include "tests/support/simulation.h"
#include "unlatch/readings.h"

namespace unlatch::test::laws_test {
namespace {

using namespace laws;

constexpr double kIntegrator = 1e-9;  // relative error of RK4 at 1 ms over the seconds of these tests
constexpr double kRounding = 1e-12;   // of sums of some hundred numbers, relative

TEST(Laws, OfPositionPushInEveryStage) {
  Model model = build_pushed({quantity(0), constant(-8), step_of(Kind::kMultiply)});  // −k x, ω = 2 rad/s
  model.bodies[0].p_WB = {1, 0, 0};
  Simulation s(model);
  for (int i = 0; i < 3000; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_NEAR(s.state.bodies[0].p.x, std::cos(6.0), kIntegrator);
  EXPECT_NEAR(s.state.bodies[0].v.x, -2 * std::sin(6.0), kIntegrator);
  EXPECT_NEAR(s.workspace.laws[0], -8 * std::cos(6.0), 8 * kIntegrator);
}

// Thrusts and torques of a body that turns: as a profile has them, so a law of time has them.
TEST(Laws, FixedInABodyPushAsProfilesDo) {
  for (const Load::Frame frame : {Load::Frame::kBody, Load::Frame::kWorld})
    for (const Load::Kind kind : {Load::Kind::kForce, Load::Kind::kTorque}) {
      Model by_profile = build_pushed({constant(1)});
      Load& load = by_profile.loads[0] = load_by(0, frame);
      load.kind = kind;
      load.direction = {0.3, -2, 1};
      if (kind == Load::Kind::kForce) load.point = {0.2, 0.1, -0.4};
      by_profile.bodies[0].inertia = Eigen::Vector3d(1, 2, 2.5).asDiagonal();
      by_profile.bodies[0].w_WB_B = {0.5, 1, -2};
      Model by_law = by_profile;
      load.profile = {};
      load.profile.kind = Profile::Kind::kHarmonic;
      load.profile.harmonics = {{3, 2, 0.1}};
      by_law.quantities.push_back(time_of());
      by_law.laws[0] = law_of({quantity(1), constant(2), step_of(Kind::kMultiply), constant(0.1), step_of(Kind::kAdd),
                               step_of(Kind::kSin), constant(3), step_of(Kind::kMultiply)});
      Simulation a(by_profile), b(by_law);
      for (int i = 0; i < 2000; ++i) {
        ASSERT_EQ(a.advance().status, StepStatus::kOk);
        ASSERT_EQ(b.advance().status, StepStatus::kOk);
      }
      const BodyState &p = a.state.bodies[0], &q = b.state.bodies[0];
      EXPECT_LT(norm(p.p - q.p), 1e4 * kRounding);
      EXPECT_LT(norm(p.w - q.w), 1e4 * kRounding);
      EXPECT_GT(norm(q.w - Vec3{0.5, 1, -2}), 0.1);
      EXPECT_NEAR(calc_load_size(b.plan, {b.commands}, b.state, b.workspace, 0), 3 * std::sin(4.1), kIntegrator);
    }
}

TEST(Laws, CallFunctionsThatAgreeWithTheLibrary) {
  struct Case {
    Kind kind;
    std::vector<double> arguments;
    double value;
  };
  const Case cases[] = {{Kind::kAdd, {2, 3}, 5},
                        {Kind::kSubtract, {2, 3}, -1},
                        {Kind::kMultiply, {2, 3}, 6},
                        {Kind::kDivide, {2, 3}, 2.0 / 3},
                        {Kind::kNegate, {2}, -2},
                        {Kind::kSqrt, {2}, std::sqrt(2.0)},
                        {Kind::kAbs, {-2}, 2},
                        {Kind::kSin, {0.7}, std::sin(0.7)},
                        {Kind::kCos, {0.7}, std::cos(0.7)},
                        {Kind::kTan, {0.7}, std::tan(0.7)},
                        {Kind::kAsin, {-0.7}, std::asin(-0.7)},
                        {Kind::kAcos, {-0.7}, std::acos(-0.7)},
                        {Kind::kAtan, {-0.7}, std::atan(-0.7)},
                        {Kind::kAtan2, {-0.7, -2}, std::atan2(-0.7, -2)},
                        {Kind::kExp, {0.7}, std::exp(0.7)},
                        {Kind::kLog, {0.7}, std::log(0.7)},
                        {Kind::kMin, {2, 3}, 2},
                        {Kind::kMin, {3, 2}, 2},
                        {Kind::kMax, {2, 3}, 3},
                        {Kind::kMax, {3, 2}, 3},
                        {Kind::kIfLess, {2, 3, 5, 7}, 5},
                        {Kind::kIfLess, {3, 2, 5, 7}, 7},
                        {Kind::kIfLess, {3, 3, 5, 7}, 7}};
  for (const Case& c : cases) {
    std::vector<LawStep> steps;
    for (const double argument : c.arguments) steps.push_back(constant(argument));
    steps.push_back(step_of(c.kind));
    Simulation s(build_pushed(steps));
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_NEAR(s.workspace.laws[0], c.value, kRounding) << static_cast<int>(c.kind);
    EXPECT_EQ(get_law_arity(c.kind), static_cast<int>(c.arguments.size()));
  }
  for (const auto& [power, value] : {std::pair(3, 8.0), std::pair(0, 1.0), std::pair(-2, 0.25)}) {
    Simulation s(build_pushed({constant(2), step_of(Kind::kPower, power)}));
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_EQ(s.workspace.laws[0], value);
  }
}

TEST(Laws, AreScaledAndOffsetByNumbersAndByCommands) {
  Model model = build_pushed({constant(0.25), step_of(Kind::kTable, 0)});
  model.tables.push_back(table_of({{0, 1}}, [](const auto& at) { return at[0]; }));
  for (const char* name : {"a", "b", "c", "d"}) model.channels.push_back({name, 2, -10, 10, 0, "1"});
  model.tables[0].scale = 4, model.tables[0].offset = 0.5;
  model.tables[0].scale_channel = 0, model.tables[0].offset_channel = 1;
  model.laws[0].scale = 10, model.laws[0].offset = 7;
  model.laws[0].scale_channel = 2, model.laws[0].offset_channel = 3;
  Simulation s(model);
  s.commands = {1, 0, 1, 0};
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_EQ(s.workspace.laws[0], 0.25 * 4 * 10 + 0.5 * 10 + 7);
  s.commands = {2, 0.125, 3, -1};
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_EQ(s.workspace.laws[0], (0.25 * 4 * 2 + 0.5 + 0.125) * 30 + 7 - 1);
}

// The command of a tick decides the force of the whole step that begins there.
TEST(Laws, ACommandReachesTheForceAtItsTick) {
  Model model = build_pushed({step_of(Kind::kCommand, 0)});
  model.channels.push_back({"throttle", 0, 0, 10, 0, "N"});
  Simulation s(model);
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_EQ(s.state.bodies[0].v.x, 0);
  s.commands[0] = 6;
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_NEAR(s.state.bodies[0].v.x, 6.0 / 2 * 1e-3, kRounding);
}

TEST(Laws, ReadOtherLawsAndDecideEvents) {
  Model model = build_pushed({quantity(1), constant(2), step_of(Kind::kMultiply)});
  model.laws[0].name = "twice";
  model.laws.push_back(law_of({constant(3)}, "three"));
  model.laws.push_back(law_of({quantity(2), constant(0.5), step_of(Kind::kMultiply)}, "acceleration halved"));
  Quantity of_law;
  of_law.kind = Quantity::Kind::kLaw;
  of_law.name = "three";
  of_law.subject = 1;
  model.quantities.push_back(of_law);                                          // 1
  model.quantities.push_back(along_x(Quantity::Kind::kAcceleration, "felt"));  // 2
  of_law.name = "halved";
  of_law.subject = 2;
  model.quantities.push_back(of_law);  // 3
  model.laws.push_back(law_of({quantity(0), constant(1), step_of(Kind::kSubtract)}, "gone"));
  of_law.name = "gone";
  of_law.subject = 3;
  model.quantities.push_back(of_law);  // 4
  model.events.push_back({"there", "", when(Condition::Kind::kQuantity, 4, 0, 0), 0, {}, false});
  Simulation s(model);
  double fired = 0;
  for (int i = 0; i < 1000; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& event : report.events) fired = event.time;
  }
  EXPECT_NEAR(s.state.bodies[0].v.x, 3, kIntegrator);  // 6 N on 2 kg
  EXPECT_NEAR(s.workspace.laws[2], 1.5, kIntegrator);  // half of 3 m/s², with the solved accelerations
  EXPECT_NEAR(s.workspace.quantities[3], 1.5, kIntegrator);
  EXPECT_NEAR(fired, std::sqrt(2.0 / 3), 1e-8);  // located
}

TEST(Laws, TheTimeSinceAnElementWasSwitchedOnIsAQuantity) {
  Model model = build_pushed({quantity(1)});
  Quantity on;
  on.kind = Quantity::Kind::kOnTime;
  on.name = "on";
  model.quantities.push_back(on);
  model.loads[0].on = false;
  Action light;
  light.kind = Action::Kind::kSwitch;
  light.value = 1;
  model.events.push_back({"light", "", when_time(0.2504), 0, {light}, false});
  Simulation s(model);
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_NEAR(s.state.bodies[0].v.x, 0.5 * 0.7496 * 0.7496 / 2, kIntegrator);
}

TEST(Laws, ATableThatEndsTheRunSaysWhichAxisWasLeftAndWhere) {
  for (const TableAxis::End end : {TableAxis::End::kClamp, TableAxis::End::kNotice, TableAxis::End::kError}) {
    Model model = build_pushed({constant(0), quantity(0), step_of(Kind::kTable, 0)});
    model.tables.push_back(table_of({{0, 1}, {0, 0.1}}, [](const auto&) { return 0; }));
    model.tables[0].axes[1].above = end;
    model.bodies[0].v_WB = {100, 0, 0};
    Simulation s(model);
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_EQ(s.workspace.table_exits[0].axis, kNone);
    const StepReport report = s.advance();
    if (end == TableAxis::End::kError) {
      EXPECT_EQ(report.status, StepStatus::kOutsideTable);
      EXPECT_EQ(report.table, 0);
      EXPECT_EQ(report.exit.axis, 1);
      EXPECT_NEAR(report.exit.value, 0.2, kRounding);
      EXPECT_EQ(s.state.header->tick, 1);
    } else {
      EXPECT_EQ(report.status, StepStatus::kOk);
      EXPECT_EQ(s.workspace.table_exits[0].axis, 1);
      EXPECT_EQ(s.workspace.table_exits[0].end, end);
    }
  }
}

TEST(Laws, MistakesAreRefusedWithTheirPlace) {
  const auto expect = [](const auto& change, const std::string& part) {
    Model model = build_pushed({quantity(0), step_of(Kind::kTable, 0)});
    model.tables.push_back(table_of({{0, 1, 2}}, [](const auto& at) { return at[0]; }));
    ASSERT_TRUE(validate(model).empty());
    change(model);
    std::string all;
    for (const ModelError& error : validate(model)) all += error.where + ": " + error.what + "; " + error.mend + "\n";
    EXPECT_NE(all.find(part), std::string::npos) << part << "\n" << all;
  };
  expect([](Model& m) { m.tables[0].axes[0].knots[1] = 2; },
         "table 'table': its axis 1 ('axis')'s knots do not increase");
  expect([](Model& m) { m.tables[0].axes[0].knots[1] = NAN; }, "a knot that is not finite");
  expect([](Model& m) { m.tables[0].axes[0].knots = {1}; }, "has 1 knot;");
  expect([](Model& m) { m.tables[0].axes[0].knots = {0, 5e-324}; }, "too close");
  expect([](Model& m) { m.tables[0].axes[0].knots = {-1.7e308, 1.7e308}; }, "longer than a number");
  expect([](Model& m) { m.tables[0].values.pop_back(); }, "the number of its values is 2; 3: one per combination");
  expect([](Model& m) { m.tables[0].values[1] = INFINITY; }, "a value that is not finite");
  expect([](Model& m) { m.tables[0].axes.resize(7, m.tables[0].axes[0]); }, "the number of its axes is 7; 1 to 6");
  expect([](Model& m) { m.tables[0].scale = NAN; }, "scale is not finite");
  expect([](Model& m) { m.tables[0].offset_channel = 3; }, "its channel does not exist");
  expect([](Model& m) { m.tables.push_back(m.tables[0]); }, "more than one has this name");
  expect([](Model& m) { m.laws[0].steps[1].subject = 1; }, "a table that it looks up does not exist");
  expect([](Model& m) { m.laws[0].steps[0].subject = 9; }, "a quantity that it reads does not exist");
  expect([](Model& m) { m.laws[0].steps = {step_of(Kind::kCommand)}; }, "a channel that it reads does not exist");
  expect([](Model& m) { m.laws[0].steps = {constant(1), step_of(Kind::kAdd)}; }, "lacks arguments");
  expect([](Model& m) { m.laws[0].steps = {constant(1), constant(1)}; }, "leaves is 2");
  expect([](Model& m) { m.laws[0].steps = {constant(2), step_of(Kind::kPower, 9)}; }, "it has the power 9");
  expect([](Model& m) { m.laws[0].steps.clear(); }, "no expression");
  expect([](Model& m) { m.laws[0].steps.assign(kLawStack + 1, constant(1)); }, "keeps more than 32 values");
  expect([](Model& m) { m.laws[0].steps.assign(kMostLawSteps + 1, constant(1)); },
         "operations of its expression is 513");
  expect([](Model& m) { m.loads[0].profile.law = 1; }, "the law of its profile does not exist");
  expect([](Model& m) { m.quantities[0].kind = Quantity::Kind::kAcceleration; }, "which follows from the forces");
  expect(
      [](Model& m) {
        m.quantities.push_back({});
        m.quantities[1].kind = Quantity::Kind::kLaw;
        m.quantities[1].name = "itself";
        m.laws[0].steps = {quantity(1)};
      },
      "law 'law': it depends on itself");
}

}  // namespace
}  // namespace unlatch::test::laws_test
