// Steady-state gains beside systems that are put together from motions of poles at 0 and others, in random coordinates.
#include "hil/run/linear/steady_gains.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <iostream>

#include "tests/support/linear_algebra.h"
#include "tests/support/random.h"

namespace unlatch::test::steady_gains_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kRelative = 1e-9;  // coordinates whose condition is below a hundred
constexpr Index kOutputs = 3, kInputs = 2;

MatrixXd draw(Random& random, Index rows, Index columns) {
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.uniform(-1, 1); });
}

// A free body's translation and rotation: pairs of poles at 0, each a position and its speed.
MatrixXd build_free_motion(Index count) {
  MatrixXd N = MatrixXd::Zero(count, count);
  for (Index k = 0; k + 1 < count; k += 2) N(k, k + 1) = 1;
  return N;
}

struct Parts {
  MatrixXd N, T, B1, B2, C1, C2, D;
  [[nodiscard]] LinearModel join(Random& random) const {
    const Index m = N.rows(), n = m + T.rows();
    MatrixXd A = MatrixXd::Zero(n, n), B(n, kInputs), C(kOutputs, n);
    A.topLeftCorner(m, m) = N;
    A.bottomRightCorner(n - m, n - m) = T;
    B << B1, B2;
    C << C1, C2;
    const MatrixXd S = 3 * MatrixXd::Identity(n, n) + draw(random, n, n), inverse = test::calc_inverse(S);
    LinearModel model;
    model.A = S * A * inverse;
    model.B = S * B;
    model.C = C * inverse;
    model.D = D;
    model.A_error = MatrixXd::Constant(n, n, 1e-14);
    model.B_error = MatrixXd::Constant(n, kInputs, 1e-14);
    model.C_error = MatrixXd::Constant(kOutputs, n, 1e-14);
    model.D_error = MatrixXd::Zero(kOutputs, kInputs);
    return model;
  }
};

Parts draw_parts(Random& random, Index at_zero, Index others) {
  Parts parts;
  parts.N = build_free_motion(at_zero);
  parts.T = draw(random, others, others) - 3 * MatrixXd::Identity(others, others);
  parts.B1 = draw(random, at_zero, kInputs);
  parts.B2 = draw(random, others, kInputs);
  parts.C1 = draw(random, kOutputs, at_zero);
  parts.C2 = draw(random, kOutputs, others);
  parts.D = draw(random, kOutputs, kInputs);
  return parts;
}

// The size of the slowest one is a scale alone.
hil::SteadyGains calc(const LinearModel& model, const Parts& parts) {
  constexpr double kSlowest = 2;
  const std::vector<std::complex<double>> at_zero(static_cast<std::size_t>(parts.N.rows()));
  return hil::calc_steady_gains(model, at_zero, kSlowest);
}

TEST(GainsAtZero, AreThoseOfTheOtherMotionsWhereNoFreeOneIsSeenOrExcited) {
  const std::uint64_t seed = 20261127;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  for (int round = 0; round < 200; ++round) {
    const Index at_zero = 2 * (round % 4), others = 2 * (1 + round % 5);
    Parts parts = draw_parts(random, at_zero, others);
    parts.C1.row(0).setZero();                                  // an output that sees no free motion
    parts.B1.col(0).setZero();                                  // an input that excites none
    for (Index k = 0; k < at_zero; k += 2) parts.C1(1, k) = 0;  // an output that sees speeds alone …
    for (Index k = 1; k < at_zero; k += 2) parts.B1(k, 1) = 0;  // … which this input does not change
    const MatrixXd wanted = parts.D - parts.C2 * test::calc_inverse(parts.T) * parts.B2;
    const hil::SteadyGains gains = calc(parts.join(random), parts);
    for (Index i = 0; i < kOutputs; ++i)
      for (Index k = 0; k < kInputs; ++k) {
        if (at_zero > 0 && i == 2 && k == 1) {
          EXPECT_TRUE(std::isinf(gains.values(i, k)) && std::isinf(gains.errors(i, k))) << round;
          continue;
        }
        EXPECT_NEAR(gains.values(i, k), wanted(i, k), kRelative * wanted.norm()) << round << ": " << i << ", " << k;
        EXPECT_GT(gains.errors(i, k), 0);
        EXPECT_LT(gains.errors(i, k), kRelative * wanted.norm());
      }
  }
}

TEST(GainsAtZero, ErrorsBoundWhatChangedMatricesChange) {
  Random random(7);
  constexpr double kChange = 1e-7;
  for (int round = 0; round < 50; ++round) {
    Parts parts = draw_parts(random, 2, 6);
    parts.C1.row(0).setZero();
    parts.B1.setZero();
    LinearModel model = parts.join(random);
    model.C_error.setConstant(kChange);
    const MatrixXd before = calc(model, parts).values, errors = calc(model, parts).errors;
    LinearModel changed = model;
    changed.C += kChange * draw(random, kOutputs, 8);
    changed.A_error.setConstant(1e-14);
    const MatrixXd after = calc(changed, parts).values;
    for (Index k = 0; k < kInputs; ++k) EXPECT_LE(std::abs(after(0, k) - before(0, k)), errors(0, k)) << round;
  }
}

TEST(GainsAtZero, OfABodyWithoutOtherMotionsAreItsDirectOnesOrEndless) {
  Random random(11);
  Parts parts = draw_parts(random, 4, 0);
  parts.C1.row(0).setZero();
  const hil::SteadyGains gains = calc(parts.join(random), parts);
  for (Index k = 0; k < kInputs; ++k) {
    EXPECT_EQ(gains.values(0, k), parts.D(0, k));
    EXPECT_TRUE(std::isinf(gains.values(1, k)));
  }
}

}  // namespace
}  // namespace unlatch::test::steady_gains_test
