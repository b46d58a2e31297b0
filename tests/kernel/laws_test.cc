// Laws and tables: values against sums of their own, orders of error, forces against closed forms, what is refused.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "kernel/laws/tables.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/bundle.h"
#include "unlatch/quantities.h"
#include "unlatch/readings.h"

namespace unlatch::test::laws_test {
namespace {

constexpr double kIntegrator = 1e-9;  // relative error of RK4 at 1 ms over the seconds of these tests
constexpr double kRounding = 1e-12;   // of sums of some hundred numbers, relative
using Kind = LawStep::Kind;

LawStep constant(double value) { return {Kind::kConstant, 0, value}; }
LawStep quantity(int number) { return {Kind::kQuantity, number, 0}; }
LawStep step_of(Kind kind, int subject = 0) { return {kind, subject, 0}; }

Law law_of(std::vector<LawStep> steps, const std::string& name = "law") {
  Law law;
  law.name = name;
  law.steps = std::move(steps);
  return law;
}

Quantity along_x(Quantity::Kind kind, const std::string& name) {
  Quantity quantity;
  quantity.name = name;
  quantity.kind = kind;
  quantity.other = kGround;
  quantity.part = 0;
  return quantity;
}

Load load_by(int law, Load::Frame frame = Load::Frame::kWorld) {
  Load load;
  load.name = "push";
  load.frame = frame;
  load.profile.kind = Profile::Kind::kLaw;
  load.profile.law = law;
  return load;
}

// A ball of 2 kg with the position x as quantity 0, pushed along x by law 0.
Model build_pushed(std::vector<LawStep> steps) {
  Model model;
  model.bodies.push_back(box("ball", 2, 1, 1, 1));
  model.quantities.push_back(along_x(Quantity::Kind::kPosition, "x"));
  model.laws.push_back(law_of(std::move(steps)));
  model.loads.push_back(load_by(0));
  return model;
}

Table table_of(std::vector<std::vector<double>> axes, const auto& value) {
  Table table;
  table.name = "table";
  std::size_t count = 1;
  for (const std::vector<double>& knots : axes) {
    table.axes.push_back({.name = "axis", .knots = knots});
    count *= knots.size();
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> at(axes.size());
    std::size_t rest = i;
    for (std::size_t a = axes.size(); a-- > 0; rest /= axes[a].size()) at[a] = axes[a][rest % axes[a].size()];
    table.values.push_back(value(at));
  }
  return table;
}

// Looks a table up by itself.
struct Lookup {
  explicit Lookup(Table table) : model(build_pushed({constant(0)})) {
    model.tables.push_back(std::move(table));
    plan.emplace(compile_or_throw(model, {}));
  }
  double operator()(const std::vector<double>& at) {
    exit = {};
    const PlanLaws& laws = get_data(*plan).laws;
    return calc_table(laws, laws.tables[0], at.data(), exit);
  }
  Model model;
  std::optional<Plan> plan;
  TableExit exit;
};

// `spread`: powers of ten between the narrowest and the widest cell.
std::vector<double> draw_knots(std::mt19937_64& random, std::size_t count, double spread) {
  std::uniform_real_distribution<double> exponent(-spread, 0);
  std::vector<double> knots{-1};
  while (knots.size() < count) knots.push_back(knots.back() + std::pow(10, exponent(random)));
  return knots;
}

// Cubic spline "not a knot" through points, by its second derivatives; a parabola through three, a line through two.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const Eigen::Index n = static_cast<Eigen::Index>(x.size());
  if (n < 4) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      double product = y[i];
      for (std::size_t k = 0; k < x.size(); ++k)
        if (k != i) product *= (at - x[k]) / (x[i] - x[k]);
      sum += product;
    }
    return sum;
  }
  const auto h = [&](Eigen::Index i) { return x[static_cast<std::size_t>(i) + 1] - x[static_cast<std::size_t>(i)]; };
  const auto d = [&](Eigen::Index i) {
    return (y[static_cast<std::size_t>(i) + 1] - y[static_cast<std::size_t>(i)]) / h(i);
  };
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    A(i, i - 1) = h(i - 1), A(i, i) = 2 * (h(i - 1) + h(i)), A(i, i + 1) = h(i);
    b[i] = 6 * (d(i) - d(i - 1));
  }
  A(0, 0) = h(1), A(0, 1) = -h(0) - h(1), A(0, 2) = h(0);
  A(n - 1, n - 3) = h(n - 2), A(n - 1, n - 2) = -h(n - 3) - h(n - 2), A(n - 1, n - 1) = h(n - 3);
  const Eigen::VectorXd m = A.partialPivLu().solve(b);
  Eigen::Index i = 0;
  while (i + 2 < n && x[static_cast<std::size_t>(i) + 1] <= at) ++i;
  const double left = at - x[static_cast<std::size_t>(i)], right = x[static_cast<std::size_t>(i) + 1] - at;
  return (m[i] * right * right * right + m[i + 1] * left * left * left) / (6 * h(i)) +
         (y[static_cast<std::size_t>(i)] / h(i) - m[i] * h(i) / 6) * right +
         (y[static_cast<std::size_t>(i) + 1] / h(i) - m[i + 1] * h(i) / 6) * left;
}

// Interpolation along one axis after the other: shares nothing with the kernel.
double interpolate(const Table& table, const std::vector<double>& at, std::size_t axis, std::size_t first) {
  if (axis == table.axes.size()) return table.values[first];
  const std::vector<double>& knots = table.axes[axis].knots;
  std::size_t stride = 1, i = 0;
  for (std::size_t a = axis + 1; a < table.axes.size(); ++a) stride *= table.axes[a].knots.size();
  const auto value = [&](std::size_t k) { return interpolate(table, at, axis + 1, first + k * stride); };
  const double x = std::clamp(at[axis], knots.front(), knots.back());
  if (table.interpolation == Table::Interpolation::kSmooth) {
    std::vector<double> values;
    for (std::size_t k = 0; k < knots.size(); ++k) values.push_back(value(k));
    return interpolate(knots, values, x);
  }
  while (i + 2 < knots.size() && knots[i + 1] <= x) ++i;
  const double u = (x - knots[i]) / (knots[i + 1] - knots[i]);
  return value(i) * (1 - u) + value(i + 1) * u;
}

TEST(Tables, OfOneToSixAxesAreInterpolatedAlongOneAxisAfterTheOther) {
  for (const Table::Interpolation kind : {Table::Interpolation::kLinear, Table::Interpolation::kSmooth})
    for (std::size_t axes = 1; axes <= kMostTableAxes; ++axes) {
      const auto seed = static_cast<unsigned>(100 + axes);
      SCOPED_TRACE("seed " + std::to_string(seed) + ", smooth " + std::to_string(static_cast<int>(kind)));
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> number(-1, 1);
      std::vector<std::vector<double>> knots;
      for (std::size_t a = 0; a < axes; ++a) knots.push_back(draw_knots(random, 2 + a + (axes < 4 ? 6 : 0), 0.7));
      Table table = table_of(knots, [&](const auto&) { return number(random); });
      table.interpolation = kind;
      Lookup look(table);
      for (int i = 0; i < 300; ++i) {
        std::vector<double> at;
        for (const std::vector<double>& k : knots) {
          const double part = 1.2 * number(random);  // beyond the ends, too
          at.push_back(i % 7 == 0 ? k[static_cast<std::size_t>(random() % k.size())]
                                  : k.front() + (k.back() - k.front()) * 0.5 * (1 + part));
        }
        const double own = interpolate(table, at, 0, 0);
        EXPECT_NEAR(look(at), own, 1e3 * kRounding * (1 + std::abs(own))) << i;
      }
    }
}

TEST(Tables, FindTheirCellHoweverUnevenlyTheKnotsLie) {
  std::mt19937_64 random(7);
  const std::vector<double> knots = draw_knots(random, 4000, 6);
  Lookup look(table_of({knots}, [&](const auto& at) { return at[0]; }));
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    EXPECT_EQ(look({knots[i]}), knots[i]);
    const double below = std::nextafter(knots[i + 1], -1e300), middle = 0.5 * (knots[i] + knots[i + 1]);
    EXPECT_NEAR(look({below}), below, kRounding * std::abs(knots.back()));
    EXPECT_NEAR(look({middle}), middle, kRounding * std::abs(knots.back()));
  }
}

// The number of parts over the length overflows on the first axis, and on the second the parts of a cell do not.
TEST(Tables, FindTheirCellOnTheShortestAndOnTheLongestAxes) {
  std::vector<double> shortest{0};
  while (shortest.size() < 64) shortest.push_back(shortest.back() + 6e-309);
  const std::vector<double> longest{-8e307, -1e307, -1, 0, 1e-300, 1, 9e307};
  for (const std::vector<double>& knots : {shortest, longest})
    for (const Table::Interpolation kind : {Table::Interpolation::kLinear, Table::Interpolation::kSmooth}) {
      if (kind == Table::Interpolation::kSmooth && knots == longest) continue;  // differences of its cells overflow
      double number = 0;
      Table table = table_of({knots}, [&](const auto&) { return ++number; });
      table.interpolation = kind;
      Lookup look(table);
      for (std::size_t i = 0; i < knots.size(); ++i)
        EXPECT_NEAR(look({knots[i]}), static_cast<double>(i) + 1, 1e-9) << knots[i];
      EXPECT_EQ(look.exit.axis, kNone);
      for (const double beyond : {1.7e308, std::numeric_limits<double>::infinity()}) {
        EXPECT_NEAR(look({beyond}), static_cast<double>(knots.size()), 1e-9);
        EXPECT_NEAR(look({-beyond}), 1, 1e-9);
        EXPECT_EQ(look.exit.axis, 0);
      }
    }
}

TEST(Tables, SmoothOnesAreExactForCubicsAndTheirSecondDerivativesAreContinuous) {
  std::mt19937_64 random(8);
  const std::vector<double> x{-1, -0.4, 0.1, 0.4, 1.5, 2}, y{0, 1, 3, 3.5};
  const auto cubic = [](const auto& at) {
    return 1 + 2 * at[0] - 3 * at[0] * at[0] + at[1] * at[1] * at[1] * (0.5 - at[0] * at[0] * at[0]) + at[1];
  };
  Table table = table_of({x, y}, cubic);
  table.interpolation = Table::Interpolation::kSmooth;
  Lookup exact(table);
  std::uniform_real_distribution<double> in_x(-1, 2), in_y(0, 3.5);
  for (int i = 0; i < 100; ++i) {
    const std::vector<double> at{in_x(random), in_y(random)};
    EXPECT_NEAR(exact(at), cubic(at), 1e3 * kRounding);
  }
  Table rough = table_of({x}, [&](const auto&) { return in_x(random); });
  rough.interpolation = Table::Interpolation::kSmooth;
  Lookup look(rough);
  constexpr double kStep = 1e-4, kTolerance = 0.05;  // the third derivative times kStep, beside the second derivative
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    const auto bend = [&](double at) {
      return (look({at + kStep}) - 2 * look({at}) + look({at - kStep})) / (kStep * kStep);
    };
    const double left = bend(x[i] - kStep), right = bend(x[i] + kStep);
    EXPECT_NEAR(left, right, kTolerance * (std::abs(left) + 1)) << x[i];
    EXPECT_NEAR(look({x[i]}), rough.values[i], 10 * kRounding);
  }
}

// Largest error of the sine in a table of uneven knots, about `h` apart.
double calc_table_error(Table::Interpolation kind, int count) {
  std::vector<double> knots;
  for (int i = 0; i <= count; ++i) knots.push_back(3 * (i + 0.2 * (i % 2)) / count);
  Table table = table_of({knots}, [](const auto& at) { return std::sin(at[0]); });
  table.interpolation = kind;
  Lookup look(table);
  double worst = 0;
  for (double x = knots[0]; x < knots.back(); x += 1e-3) worst = std::max(worst, std::abs(look({x}) - std::sin(x)));
  return worst;
}

TEST(Tables, HaveTheOrdersOfErrorThatTheyAreSaidToHave) {
  const double linear =
      calc_table_error(Table::Interpolation::kLinear, 40) / calc_table_error(Table::Interpolation::kLinear, 80);
  const double smooth =
      calc_table_error(Table::Interpolation::kSmooth, 40) / calc_table_error(Table::Interpolation::kSmooth, 80);
  EXPECT_NEAR(linear, 4, 0.4);
  EXPECT_NEAR(smooth, 16, 3);
}

TEST(Tables, ReportTheFirstAxisThatTheyAreLeftOn) {
  Lookup look(table_of({{0, 1}, {0, 1}}, [](const auto& at) { return at[0] + 10 * at[1]; }));
  EXPECT_EQ(look({0.5, 1}), 10.5);
  EXPECT_EQ(look.exit.axis, kNone);
  EXPECT_EQ(look({0.5, 1.25}), 10.5);
  EXPECT_EQ(look.exit.axis, 1);
  EXPECT_EQ(look.exit.value, 1.25);
  EXPECT_EQ(look({-2, 1.25}), 10);
  EXPECT_EQ(look.exit.axis, 0);
  EXPECT_EQ(look.exit.value, -2);
  EXPECT_TRUE(std::isnan(look({0.5, std::nan("")})));
}

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
      Quantity time;
      time.name = "time";
      by_law.quantities.push_back(time);
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
  Quantity time;
  time.name = "time";
  model.quantities.push_back(time);
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
  Quantity time;
  time.name = "time";
  model.quantities.push_back(time);
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
  Quantity time;
  time.name = "time";
  model.quantities.push_back(time);
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
    Quantity time;
    time.name = "time";
    model.quantities.push_back(time);
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
  Quantity time;
  time.name = "time";
  model.quantities.push_back(time);
  Simulation s(model, {.dt = 0.01});
  for (int i = 0; i < 4; ++i) EXPECT_EQ(s.advance().open.corners > 0, i == 1) << i;
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

Model build_scaled(double scale, double edge, TableAxis::End end) {
  Model model = build_pushed({quantity(0), step_of(Kind::kTable, 0), step_of(Kind::kCommand, 0), step_of(Kind::kAdd)});
  model.tables.push_back(table_of({{-1, 0, 0.3, edge}}, [](const auto& at) { return 3 - at[0] * at[0]; }));
  model.tables[0].interpolation = Table::Interpolation::kSmooth;
  model.tables[0].scale = scale;
  model.tables[0].axes[0].above = end;
  model.channels.push_back({"bias", 0.5, -1, 1, 0, "N"});
  model.quantities.push_back({});
  model.quantities[1].kind = Quantity::Kind::kLaw;
  model.quantities[1].name = "force";
  return model;
}

TEST(Laws, HaveTheirBitsSideBySideToo) {
  std::vector<Model> models;
  for (int i = 0; i < 5; ++i) models.push_back(build_scaled(1 + 0.1 * i, 0.9 - 0.1 * (i == 3), TableAxis::End::kError));
  std::vector<std::unique_ptr<Simulation>> alone, beside;
  std::vector<const Model*> all;
  std::vector<const Plan*> plans;
  for (const Model& model : models) {
    alone.push_back(std::make_unique<Simulation>(model));
    beside.push_back(std::make_unique<Simulation>(model));
    all.push_back(&model);
    plans.push_back(&beside.back()->plan);
  }
  std::optional<Bundle> bundle = Bundle::build(all, plans);
  ASSERT_TRUE(bundle);
  std::vector<BundleRun> runs(models.size());
  bool left = false;
  for (int tick = 0; tick < 1100; ++tick) {
    for (std::size_t m = 0; m < runs.size(); ++m) {
      runs[m].plan = &beside[m]->plan;
      runs[m].inputs = {beside[m]->commands};
      runs[m].state = &beside[m]->state;
      runs[m].workspace = &beside[m]->workspace;
      runs[m].goes_on = runs[m].report.status == StepStatus::kOk;
    }
    bundle->step(runs);
    for (std::size_t m = 0; m < runs.size(); ++m) {
      if (!runs[m].goes_on) continue;
      const StepReport report = alone[m]->advance();
      ASSERT_EQ(report.status, runs[m].report.status) << m << " " << tick;
      left = left || report.status == StepStatus::kOutsideTable;
      if (report.status != StepStatus::kOk) continue;
      ASSERT_EQ(alone[m]->state.bodies[0].p.x, beside[m]->state.bodies[0].p.x) << m << " " << tick;
      ASSERT_EQ(alone[m]->workspace.laws[0], beside[m]->workspace.laws[0]);
      ASSERT_EQ(alone[m]->workspace.quantities[1], beside[m]->workspace.quantities[1]);
    }
  }
  EXPECT_TRUE(left);
}

// Members whose steps are split at points of their tables over time take these steps alone.
TEST(Laws, TablesOverTimeHaveTheirBitsSideBySideToo) {
  std::vector<Model> models;
  for (int i = 0; i < 5; ++i) {
    Model& model = models.emplace_back(build_pushed({constant(1)}));
    Profile& profile = model.loads[0].profile = {};
    profile.kind = Profile::Kind::kTable;
    profile.times = {0, 0.0123 + 0.01 * i, 0.0321 + 0.01 * i};
    profile.values = {1, 9, 2};
  }
  std::vector<std::unique_ptr<Simulation>> alone, beside;
  std::vector<const Model*> all;
  std::vector<const Plan*> plans;
  for (const Model& model : models) {
    alone.push_back(std::make_unique<Simulation>(model));
    beside.push_back(std::make_unique<Simulation>(model));
    all.push_back(&model);
    plans.push_back(&beside.back()->plan);
  }
  std::optional<Bundle> bundle = Bundle::build(all, plans);
  ASSERT_TRUE(bundle);
  std::vector<BundleRun> runs(models.size());
  int splits = 0;
  for (int tick = 0; tick < 100; ++tick) {
    for (std::size_t m = 0; m < runs.size(); ++m) {
      runs[m].plan = &beside[m]->plan;
      runs[m].inputs = {beside[m]->commands};
      runs[m].state = &beside[m]->state;
      runs[m].workspace = &beside[m]->workspace;
    }
    bundle->step(runs);
    for (std::size_t m = 0; m < runs.size(); ++m) {
      const StepReport report = alone[m]->advance();
      ASSERT_EQ(report.status, StepStatus::kOk);
      splits += report.substeps > 1 ? 1 : 0;
      ASSERT_EQ(report.substeps, runs[m].report.substeps) << m << " " << tick;
      ASSERT_EQ(alone[m]->state.bodies[0].p.x, beside[m]->state.bodies[0].p.x) << m << " " << tick;
      ASSERT_EQ(alone[m]->state.bodies[0].v.x, beside[m]->state.bodies[0].v.x) << m << " " << tick;
    }
  }
  EXPECT_EQ(splits, 10);
}

TEST(Laws, HaveTheSameBitsInEveryWidth) {
  std::vector<double> places;
  for (const InstructionSet set :
       {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
    if (!is_supported(set)) continue;
    Simulation s(build_scaled(1.3, 5, TableAxis::End::kError), {.instruction_set = set});
    for (int i = 0; i < 700; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    places.push_back(s.state.bodies[0].p.x);
    EXPECT_EQ(places.back(), places.front());
  }
}

TEST(Laws, ChangeTheHashOfTheirModel) {
  const Model model = build_scaled(1.3, 5, TableAxis::End::kError);
  const auto hash = [](const Model& m) { return compile_or_throw(m, {}).get_hash(); };
  const auto expect_other = [&](const auto& change) {
    Model other = model;
    change(other);
    EXPECT_NE(hash(other), hash(model));
  };
  expect_other([](Model& m) { m.tables[0].values[1] += 1e-9; });
  expect_other([](Model& m) { m.tables[0].axes[0].knots[1] += 1e-9; });
  expect_other([](Model& m) { m.tables[0].axes[0].above = TableAxis::End::kClamp; });
  expect_other([](Model& m) { m.tables[0].interpolation = Table::Interpolation::kLinear; });
  expect_other([](Model& m) { m.tables[0].scale = 1; });
  expect_other([](Model& m) { m.tables[0].offset = 1; });
  expect_other([](Model& m) { m.tables[0].scale_channel = 0; });
  expect_other([](Model& m) { m.laws[0].offset_channel = 0; });
  expect_other([](Model& m) { m.laws[0].scale = 2; });
  expect_other([](Model& m) { m.laws[0].steps.back().kind = Kind::kSubtract; });
}

}  // namespace
}  // namespace unlatch::test::laws_test
