#include "hil/run/linear/steady_gains.h"

#include <Eigen/Jacobi>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "hil/run/linear/matrices.h"
#include "hil/run/linear/poles.h"

namespace unlatch::hil {
namespace {

constexpr double kSchurRounding = 1e-14;  // relative, of the Schur form of some ten to hundred states

// A = U T Uᴴ with the eigenvalues that are nearest to those of `first` at the beginning of the diagonal of T.
struct OrderedSchur {
  Eigen::MatrixXcd T, U;
  OrderedSchur(const Eigen::MatrixXd& A, const std::vector<std::complex<double>>& first);

 private:
  void swap(Eigen::Index k);
};

OrderedSchur::OrderedSchur(const Eigen::MatrixXd& A, const std::vector<std::complex<double>>& first) {
  SchurForm schur = calc_schur(A.cast<std::complex<double>>());
  T = std::move(schur.T);
  U = std::move(schur.U);
  for (Eigen::Index place = 0; place < std::ssize(first); ++place) {
    const std::complex<double> wanted = first[static_cast<std::size_t>(place)];
    Eigen::Index nearest = place;
    for (Eigen::Index k = place + 1; k < T.rows(); ++k)
      if (std::abs(T(k, k) - wanted) < std::abs(T(nearest, nearest) - wanted)) nearest = k;
    for (Eigen::Index k = nearest; k > place; --k) swap(k - 1);
  }
}

// Exchanges the eigenvalues k and k + 1: the first column of the rotation is the eigenvector of the second one.
void OrderedSchur::swap(Eigen::Index k) {
  Eigen::JacobiRotation<std::complex<double>> turn;
  turn.makeGivens(T(k, k + 1), T(k + 1, k + 1) - T(k, k));
  T.applyOnTheLeft(k, k + 1, turn.adjoint());
  T.applyOnTheRight(k, k + 1, turn);
  U.applyOnTheRight(k, k + 1, turn);
  T(k + 1, k) = 0;
}

// X of T₁₁ X − X T₂₂ = −T₁₂, the blocks of an upper triangular T whose first `first` rows are those of T₁₁.
Eigen::MatrixXcd solve_sylvester(const Eigen::MatrixXcd& T, Eigen::Index first) {
  const Eigen::Index others = T.rows() - first;
  Eigen::MatrixXcd X(first, others);
  for (Eigen::Index k = 0; k < others; ++k) {
    const auto T22 = T.bottomRightCorner(others, others);
    const Eigen::MatrixXcd right = multiply(X.leftCols(k), T22.col(k).head(k)) - T.topRightCorner(first, others).col(k);
    Eigen::MatrixXcd shifted = T.topLeftCorner(first, first);
    shifted.diagonal().array() -= T22(k, k);
    X.col(k) = solve_upper(shifted, right);
  }
  return X;
}

// The model with time in units of 1/rate, so that entries of positions and of speeds are of one size.
struct Scaled {
  Eigen::MatrixXd A, A_error, B, B_error, C, C_error;
  Scaled(const LinearModel& model, double rate)
      : A(scale_time(model.A, rate)),
        A_error(scale_time(model.A_error, rate)),
        B(model.B / rate),
        B_error(model.B_error / rate),
        C(model.C),
        C_error(model.C_error) {
    const Eigen::Index f = A.rows() / 2;
    for (Eigen::MatrixXd* const rows : {&B, &B_error}) rows->bottomRows(f) /= rate;
    for (Eigen::MatrixXd* const columns : {&C, &C_error}) columns->rightCols(f) *= rate;
  }
};

double divide(double part, double whole) { return whole > 0 ? part / whole : 0; }

}  // namespace

SteadyGains calc_steady_gains(const LinearModel& model, const std::vector<std::complex<double>>& poles_at_zero,
                              double slowest) {
  SteadyGains gains{model.D, model.D_error.cwiseAbs()};
  const Eigen::Index n = model.A.rows(), at_zero = std::ssize(poles_at_zero), others = n - at_zero;
  if (n == 0 || gains.values.size() == 0) return gains;
  const double rate = others > 0 ? slowest : 1;
  const Scaled scaled(model, rate);
  std::vector<std::complex<double>> first;
  for (const std::complex<double>& pole : poles_at_zero) first.push_back(pole / rate);
  const OrderedSchur schur(scaled.A, first);
  const Eigen::MatrixXcd X = solve_sylvester(schur.T, at_zero);
  const Eigen::MatrixXcd V1 = schur.U.leftCols(at_zero), W2 = schur.U.rightCols(others).adjoint();
  const Eigen::MatrixXcd V2 = multiply(V1, X) + schur.U.rightCols(others), W1 = V1.adjoint() - multiply(X, W2);

  // Which entries the motions of the poles at 0 carry away.
  const Eigen::MatrixXcd B = scaled.B.cast<std::complex<double>>(), C = scaled.C.cast<std::complex<double>>();
  const Eigen::MatrixXcd outputs_1 = multiply(C, V1);
  Eigen::MatrixXcd inputs_1 = multiply(W1, B);
  // Its diagonal is rounding, but the square root of that of A: without it, N would not be nilpotent to A's.
  const Eigen::MatrixXcd N = schur.T.topLeftCorner(at_zero, at_zero);
  const double turned = static_cast<double>(n) * (kSchurRounding + scaled.A_error.norm()) * std::max(1.0, W1.norm());
  std::vector<std::pair<Eigen::Index, Eigen::Index>> endless;
  double power = 1;
  for (Eigen::Index k = 0; k < at_zero; ++k, inputs_1 = multiply(N, inputs_1), power *= N.norm()) {
    const Eigen::MatrixXcd moved = multiply(outputs_1, inputs_1);
    for (Eigen::Index row = 0; row < moved.rows(); ++row)
      for (Eigen::Index column = 0; column < moved.cols(); ++column) {
        const double output = scaled.C.row(row).norm(), input = scaled.B.col(column).norm();
        const double error =
            turned + divide(scaled.C_error.row(row).norm(), output) + divide(scaled.B_error.col(column).norm(), input);
        if (std::abs(moved(row, column)) > error * output * input * W1.norm() * power)
          endless.emplace_back(row, column);
      }
  }

  if (others > 0) {
    // −A⁻¹ B and −C A⁻¹ of the others, twice, and the parts of both that are of the poles at 0.
    const Eigen::MatrixXcd T = schur.T.bottomRightCorner(others, others);
    const Eigen::MatrixXcd inputs_2 = multiply(W2, B), outputs_2 = multiply(C, V2);
    const Eigen::MatrixXcd once = solve_upper(T, inputs_2), twice = solve_upper(T, once);
    const Eigen::MatrixXcd dual = solve_upper_adjoint(T, outputs_2.adjoint()),
                           dual_twice = solve_upper_adjoint(T, dual);  // adjoint, a column for each output
    const Eigen::MatrixXd states = multiply(V2, once).cwiseAbs(), duals = multiply(dual.adjoint(), W2).cwiseAbs();
    const Eigen::MatrixXd inputs_twice = multiply(V2, twice).cwiseAbs(),
                          outputs_twice = multiply(dual_twice.adjoint(), W2).cwiseAbs(),
                          kept = multiply(V1, multiply(W1, B)).cwiseAbs(), seen = multiply(outputs_1, W1).cwiseAbs();
    gains.values -= multiply(outputs_2, once).real();
    gains.errors += kSchurRounding * multiply_real(scaled.C.rowwise().norm(), once.colwise().norm());
    gains.errors += multiply_real(scaled.C_error, states);
    gains.errors += multiply_real(duals, multiply_real(scaled.A_error, states) + scaled.B_error);
    gains.errors += multiply_real(multiply_real(seen, scaled.A_error), inputs_twice);
    gains.errors += multiply_real(multiply_real(outputs_twice, scaled.A_error), kept);
  }
  for (const auto& [row, column] : endless)
    gains.values(row, column) = gains.errors(row, column) = std::numeric_limits<double>::infinity();
  return gains;
}

}  // namespace unlatch::hil
