// Facts about the poles of linear models and the bounds of their errors.
#include "hil/run/linear/poles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "tests/support/linear_algebra.h"
#include "tests/support/random.h"

namespace unlatch::test::poles_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Positions' rates are the speeds.
MatrixXd draw_motion(Random& random, Index f) {
  MatrixXd A = MatrixXd::Zero(2 * f, 2 * f);
  A.topRightCorner(f, f).setIdentity();
  for (Index i = 0; i < f; ++i)
    for (Index k = 0; k < 2 * f; ++k) A(f + i, k) = random.uniform(-1, 1) * (k < f ? 9 : 1);
  return A;
}

TEST(Poles, MoveByNoMoreThanTheirErrorsWhenEntriesOfTheMatrixDo) {
  const std::uint64_t seed = 20261128;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  double nearest = 0;
  for (int system = 0; system < 50; ++system) {
    const MatrixXd A = draw_motion(random, 1 + system % 5);
    const MatrixXd error = MatrixXd::Constant(A.rows(), A.cols(), 1e-8);
    const std::vector<hil::Pole> poles = hil::calc_poles(A, error);
    for (int k = 0; k < 20; ++k) {
      MatrixXd moved = A;
      for (double& entry : moved.reshaped()) entry += random.uniform(-1, 1) > 0 ? 1e-8 : -1e-8;
      const Eigen::VectorXcd found = test::calc_eigenvalues(moved);
      for (const hil::Pole& pole : poles) {
        const double by = (found.array() - pole.value).abs().minCoeff();
        EXPECT_LE(by, pole.error);
        nearest = std::max(nearest, by / pole.error);
      }
    }
  }
  EXPECT_GT(nearest, 0.01);  // and no thousandfold more
}

// A free body beside a damped one: a chain of two poles at 0, and one that is slow, mixed by a change of coordinates.
TEST(Poles, OfAFreeMotionAreAtZeroAndASlowOneBesideItIsNot) {
  const std::uint64_t seed = 20261129;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  for (int k = 0; k < 50; ++k) {
    MatrixXd mix(2, 2);
    do
      for (double& entry : mix.reshaped()) entry = random.uniform(-1, 1);
    while (std::abs(mix(0, 0) * mix(1, 1) - mix(0, 1) * mix(1, 0)) < 0.2);
    MatrixXd A = MatrixXd::Zero(4, 4);
    A.topRightCorner(2, 2).setIdentity();
    A.bottomRightCorner(2, 2) = mix * Eigen::Vector2d(0, -1e-4).asDiagonal() * test::calc_inverse(mix);
    const std::vector<hil::Pole> poles = hil::calc_poles(A, MatrixXd::Constant(4, 4, 1e-12));
    EXPECT_EQ(std::ranges::count_if(poles, [](const hil::Pole& pole) { return pole.is_at_zero(); }), 3);
    EXPECT_NEAR(poles[3].value.real(), -1e-4, 1e-9);
  }
}

}  // namespace
}  // namespace unlatch::test::poles_test
