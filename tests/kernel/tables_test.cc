// Tables: values against sums of their own, cells, orders of error, ends.
#include "kernel/laws/tables.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "tests/support/law_models.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/simulation.h"

namespace unlatch::test {
namespace {

using namespace laws;

constexpr double kRounding = 1e-12;  // of sums of some hundred numbers, relative

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
  const Eigen::VectorXd m = test::solve_full_pivots(A, b);
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

// Compares a table of random values with the interpolation above. `least`: knots of an axis.
void compare_with_interpolation(Table::Interpolation kind, std::size_t axes, std::size_t least, int lookups) {
  const auto seed = static_cast<unsigned>(100 + axes);
  SCOPED_TRACE("seed " + std::to_string(seed) + ", smooth " + std::to_string(static_cast<int>(kind)));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<std::vector<double>> knots;
  for (std::size_t a = 0; a < axes; ++a)
    knots.push_back(draw_knots(random, std::max(least, 2 + a + (axes < 4 ? 6 : 0)), 0.7));
  Table table = table_of(knots, [&](const auto&) { return number(random); });
  table.interpolation = kind;
  Lookup look(table);
  for (int i = 0; i < lookups; ++i) {
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

TEST(Tables, OfOneToSixAxesAreInterpolatedAlongOneAxisAfterTheOther) {
  for (const Table::Interpolation kind : {Table::Interpolation::kLinear, Table::Interpolation::kSmooth})
    for (std::size_t axes = 1; axes <= kMostTableAxes; ++axes) compare_with_interpolation(kind, axes, 2, 300);
}

// Axes of four knots and more have cells of four by four by …, which are summed otherwise.
TEST(Tables, SmoothOnesOfFourToSixLongAxesAreInterpolatedLikewise) {
  for (std::size_t axes = 4; axes <= kMostTableAxes; ++axes)
    compare_with_interpolation(Table::Interpolation::kSmooth, axes, 4, 60);
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

}  // namespace
}  // namespace unlatch::test
