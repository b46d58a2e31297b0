// Corners and jumps of laws that forces read: the method's order, closed forms, what is reported.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/law_models.h"
#include "tests/support/simulation.h"

namespace unlatch::test {
namespace {

using namespace laws;

constexpr double kRounding = 1e-12;  // of sums of some hundred numbers, relative

// Error of the place after 1 s of a ball pushed by −40 N · T(x), T close to sin(3 x / m).
double calc_push_error(Table::Interpolation kind, int steps) {
  std::vector<double> knots;
  for (int i = 0; i <= 12; ++i) knots.push_back(-1.5 + 0.25 * i);
  const auto run = [&](int count) {
    Model model = build_pushed({quantity(0), step_of(Kind::kTable, 0), constant(-40), step_of(Kind::kMultiply)});
    model.tables.push_back(table_of({knots}, [](const auto& at) { return std::sin(3 * at[0]); }));
    model.tables[0].interpolation = kind;
    model.bodies[0].p_WB = {1.03, 0, 0};
    Simulation s(model, {.dt = 1.0 / count});
    for (int i = 0; i < count; ++i) EXPECT_EQ(s.advance().status, StepStatus::kOk);
    return s.state.bodies[0].p.x;
  };
  return std::abs(run(steps) - run(8192));
}

TEST(Laws, OfSmoothTablesKeepTheOrderOfRungeAndKutta) {
  for (const int steps : {64, 128, 256}) {
    const double ratio = calc_push_error(Table::Interpolation::kSmooth, steps) /
                         calc_push_error(Table::Interpolation::kSmooth, 2 * steps);
    EXPECT_NEAR(std::log2(ratio), 4, 0.3) << steps;
  }
}

// Without a split at each knot the order is below 3.
TEST(Laws, OfLinearTablesKeepTheOrderBecauseTheirKnotsAreLocated) {
  const double ratio =
      calc_push_error(Table::Interpolation::kLinear, 64) / calc_push_error(Table::Interpolation::kLinear, 512);
  EXPECT_NEAR(std::log2(ratio) / 3, 4, 0.35);
}

// Place after 1 s of a ball under −40 N/m · law(x), in so many steps.
double calc_place(std::vector<LawStep> law, int count) {
  for (const LawStep& step : {constant(-40), step_of(Kind::kMultiply)}) law.push_back(step);
  Model model = build_pushed(law);
  model.bodies[0].p_WB = {0.53, 0, 0};
  Simulation s(model, {.dt = 1.0 / count});
  for (int i = 0; i < count; ++i) EXPECT_EQ(s.advance().status, StepStatus::kOk);
  return s.state.bodies[0].p.x;
}

// A spring that is harder on one side: half a period of each gives the place in closed form.
TEST(Laws, KeepTheOrderWhereABranchChanges) {
  const LawStep x = quantity(0);
  const std::vector<std::vector<LawStep>> laws{
      {x, constant(0.25), x, step_of(Kind::kMultiply), step_of(Kind::kMax)},
      {x, constant(0.625), step_of(Kind::kMultiply), x, step_of(Kind::kAbs), constant(0.375), step_of(Kind::kMultiply),
       step_of(Kind::kAdd)},
      {x, constant(0), constant(0.25), x, step_of(Kind::kMultiply), x, step_of(Kind::kIfLess)}};
  const double fast = std::sqrt(20.0), slow = fast / 2;               // rad/s, x > 0 and x < 0
  const double since = 1 - 0.5 * std::acos(-1.0) / fast;              // s below 0
  const double exact = -0.53 * fast / slow * std::sin(slow * since);  // m
  for (const std::vector<LawStep>& law : laws) {
    const double coarse = std::abs(calc_place(law, 32) - exact), fine = std::abs(calc_place(law, 256) - exact);
    EXPECT_NEAR(std::log2(coarse / fine) / 3, 4, 0.5) << law.size();  // the crossing lies elsewhere in its step
    EXPECT_LT(fine, 1e-8);
  }
}

// A force that is linear between knots inside steps gives cubics, for which the method is exact.
TEST(Laws, OfTimeAreExactBetweenTheirKnotsWhereverTheseLie) {
  const std::vector<double> knots{0, 0.12345, 0.5, 0.56789, 1}, forces{0, 5, -3, 8, -1};
  Model model = build_pushed({quantity(1), step_of(Kind::kTable, 0)});
  model.quantities.push_back(time_of());
  model.tables.push_back(table_of({knots}, [&](const auto& at) {
    return forces[static_cast<std::size_t>(std::ranges::find(knots, at[0]) - knots.begin())];
  }));
  double x = 0, v = 0;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double h = knots[i + 1] - knots[i], a = forces[i] / 2, b = forces[i + 1] / 2;
    x += v * h + h * h * (2 * a + b) / 6;
    v += h * (a + b) / 2;
  }
  Simulation s(model, {.dt = 0.01});
  int substeps = 0;
  for (int i = 0; i < 100; ++i) substeps += s.advance().substeps;
  EXPECT_NEAR(s.state.bodies[0].p.x, x, 1e2 * kRounding);
  EXPECT_NEAR(s.state.bodies[0].v.x, v, 1e2 * kRounding);
  EXPECT_LE(substeps, 100 + 2 * 3);  // of the two knots that lie within steps
}

// A triangle of 6 ms inside of a step: the chord over the whole step shows its top alone.
TEST(Laws, ThatComeBackWithinAStepAreSplitAtAllTheirCorners) {
  constexpr double kTop = 0.5037, kHalf = 0.003, kForce = 20, kMass = 2;
  Model model = build_pushed({constant(0), constant(kForce), constant(1), quantity(1), constant(-kTop),
                              step_of(Kind::kAdd), step_of(Kind::kAbs), constant(-1 / kHalf), step_of(Kind::kMultiply),
                              step_of(Kind::kAdd), step_of(Kind::kMultiply), step_of(Kind::kMax)});
  model.quantities.push_back(time_of());
  Simulation s(model, {.dt = 0.01});
  for (int i = 0; i < 60; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_NEAR(s.state.bodies[0].v.x, kForce * kHalf / kMass, 1e-12);
}

// A parabola that is positive for 6 ms inside of a step: nothing at the ends of the step shows it.
TEST(Laws, OfABumpInTheMiddleOfAStepAreSplitAtItsEnds) {
  constexpr double kTop = 0.5045, kHalf = 0.003, kCurve = 1e6, kMass = 2;
  const std::vector<LawStep> since{quantity(1), constant(-kTop), step_of(Kind::kAdd)};
  std::vector<LawStep> law{constant(0), constant(kCurve * kHalf * kHalf)};
  law.insert(law.end(), since.begin(), since.end());
  law.insert(law.end(), since.begin(), since.end());
  for (const LawStep& step : {step_of(Kind::kMultiply), constant(-kCurve), step_of(Kind::kMultiply),
                              step_of(Kind::kAdd), step_of(Kind::kMax)})
    law.push_back(step);
  Model model = build_pushed(law);
  model.quantities.push_back(time_of());
  Simulation s(model, {.dt = 0.01});
  for (int i = 0; i < 60; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  // A corner is located to 1e-6 of a sub-step h; a stage at its end misses h/6 of what the slope of the force makes
  // then.
  constexpr double kSubstep = 0.005, kSlope = 2 * kCurve * kHalf;
  EXPECT_NEAR(s.state.bodies[0].v.x, 4.0 / 3 * kCurve * kHalf * kHalf * kHalf / kMass,
              kSubstep / 6 * kSlope * 1e-6 * kSubstep / kMass);
}

// A force that sets in at an instant, between two ticks, at one, and next to one: no stage sees its other side.
TEST(Laws, ThatJumpAreExactOnBothSides) {
  constexpr double kForce = 10, kMass = 2, kDt = 0.01;
  for (const double instant : {0.5037, 0.503333, 0.505, 0.5, 0.5 + 1e-9, 0.5 - 1e-9, 0.5 + 3e-8, 0.5 - 3e-8}) {
    Model model = build_pushed({quantity(1), constant(instant), constant(0), constant(kForce), step_of(Kind::kIfLess)});
    model.quantities.push_back(time_of());
    Simulation s(model, {.dt = kDt});
    for (int i = 0; i < 100; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_NEAR(s.state.bodies[0].v.x, kForce / kMass * (1 - instant), 1e-9) << instant;
    EXPECT_NEAR(s.state.bodies[0].p.x, 0.5 * kForce / kMass * (1 - instant) * (1 - instant), 1e-9) << instant;
  }
}

// Bang-bang braking: the force turns round where x passes 0.3 m; the place follows in closed form. Started on the very
// place of the jump, the body takes the side into which it moves.
TEST(Laws, ThatJumpAtAPlaceAreExactOnBothSides) {
  constexpr double kForce = 1, kMass = 2, kPlace = 0.3;
  const auto build = [&](double place) {
    return build_pushed({quantity(0), constant(place), constant(kForce), constant(-kForce), step_of(Kind::kIfLess)});
  };
  {
    Model model = build(kPlace);
    model.bodies[0].p_WB.setZero();
    model.bodies[0].v_WB = {1, 0, 0};
    Simulation s(model, {.dt = 0.01});
    for (int i = 0; i < 50; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    const double a = kForce / kMass, speed = std::sqrt(1 + 2 * a * kPlace), until = (speed - 1) / a, rest = 0.5 - until;
    EXPECT_NEAR(s.state.bodies[0].p.x, kPlace + speed * rest - 0.5 * a * rest * rest, 1e-9);
  }
  for (const double speed : {1.0, -1.0}) {
    Model model = build(0);
    model.bodies[0].p_WB.setZero();
    model.bodies[0].v_WB = {speed, 0, 0};
    Simulation s(model, {.dt = 0.01});
    for (int i = 0; i < 10; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_NEAR(s.state.bodies[0].p.x, speed * (0.1 - 0.5 * kForce / kMass * 0.1 * 0.1), 1e-9) << speed;
  }
}

TEST(Laws, WithMoreCornersInAStepThanItMayBeSplitAtAreReported) {
  std::vector<LawStep> law{constant(0)};
  for (int i = 1; i <= 12; ++i)
    for (const LawStep& step :
         {quantity(1), constant(-0.0101 - 0.0007 * i), step_of(Kind::kAdd), step_of(Kind::kAbs), step_of(Kind::kAdd)})
      law.push_back(step);
  Model model = build_pushed(law);
  model.quantities.push_back(time_of());
  Simulation s(model, {.dt = 0.01});
  for (int i = 0; i < 4; ++i) EXPECT_EQ(s.advance().open.corners > 0, i == 1) << i;
}

// Twelve thrusts that tail off from an instant of their own, all in one step: it is split at eight of them.
TEST(Laws, TablesOverTimeWithMoreCornersInAStepThanItMayBeSplitAtAreReported) {
  constexpr int kThrusts = 12;
  Model model = build_pushed({constant(0)});
  double impulse = 0;
  for (int i = 1; i <= kThrusts; ++i) {
    Load& load = model.loads.emplace_back();
    load.name = "thrust" + std::to_string(i);
    load.frame = Load::Frame::kWorld;
    load.profile.kind = Profile::Kind::kTable;
    const double corner = 0.0101 + 0.0007 * i;
    load.profile.times = {0, corner, 1};
    load.profile.values = {1, 1, 0};
    impulse += corner + (0.04 - corner) * 0.5 * (1 + (1 - 0.04) / (1 - corner));
  }
  Simulation s(model, {.dt = 0.01});
  for (int i = 0; i < 4; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    EXPECT_EQ(report.open.corners > 0, i == 1) << i;
  }
  // Four corners lie within a sub-step, each of which bends a force by 1 N/s.
  EXPECT_NEAR(s.state.bodies[0].v.x, impulse / 2, 4 * 0.5 * 0.003 * 0.003);
}

TEST(Laws, OfATableThatIsFinerThanTheStepSplitNothing) {
  std::vector<double> knots;
  for (int i = 0; i <= 1000; ++i) knots.push_back(0.001 * i);
  Model model = build_pushed({quantity(0), step_of(Kind::kTable, 0)});
  model.tables.push_back(table_of({knots}, [](const auto& at) { return std::sin(at[0]); }));
  model.bodies[0].v_WB = {1, 0, 0};
  Simulation s(model, {.dt = 0.01});
  for (int i = 0; i < 90; ++i) EXPECT_EQ(s.advance().substeps, 1) << i;
}

}  // namespace
}  // namespace unlatch::test
