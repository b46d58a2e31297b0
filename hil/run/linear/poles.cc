#include "hil/run/linear/poles.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>

#include "hil/run/linear/matrices.h"

namespace unlatch::hil {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXcd;
using Eigen::VectorXcd;

constexpr double kRounding = 1e-15;  // of the Schur form, beside the size of the matrix
constexpr double kReal = 1e-9;       // beside the size of a pole: an imaginary part that is rounding
constexpr double kSafety = 16;       // times the bound of the first order; see the header

// A frequency of the model's own size.
double choose_rate(const MatrixXd& A) {
  const Index f = A.rows() / 2;
  const double stiff = std::sqrt(A.bottomLeftCorner(f, f).cwiseAbs().maxCoeff());
  const double damped = A.bottomRightCorner(f, f).cwiseAbs().maxCoeff();
  const double rate = std::max(stiff, damped);
  return rate > 0 ? rate : 1;
}

// A divisor of at least this size, with the direction of the number.
Complex keep_from_zero(Complex number, double least) { return std::abs(number) < least ? Complex(least) : number; }

}  // namespace

MatrixXd scale_time(const MatrixXd& A, double rate) {
  const Index f = A.rows() / 2;
  MatrixXd scaled = A / rate;
  scaled.bottomRows(f) /= rate;
  scaled.rightCols(f) *= rate;
  return scaled;
}

std::vector<Pole> calc_poles(const MatrixXd& A, const MatrixXd& A_error) {
  const Index n = A.rows();
  if (n == 0) return {};
  const double rate = choose_rate(A);
  const MatrixXd scaled = scale_time(A, rate);
  const MatrixXd errors = (scale_time(A_error, rate).array() + kRounding * scaled.norm()).matrix();
  const auto [T, U] = calc_schur(scaled.cast<Complex>());
  const double least = std::numeric_limits<double>::epsilon() * scaled.norm();

  std::vector<Pole> poles;
  for (Index k = 0; k < n; ++k) {
    const Complex pole = T(k, k);
    VectorXcd right = VectorXcd::Zero(k + 1);  // of T; its product with the left one is 1
    right[k] = 1;
    for (Index i = k - 1; i >= 0; --i)
      right[i] =
          (T.row(i).segment(i + 1, k - i) * right.segment(i + 1, k - i))(0) / keep_from_zero(pole - T(i, i), least);
    RowVectorXcd left = RowVectorXcd::Zero(n - k);
    left[0] = 1;
    for (Index j = k + 1; j < n; ++j)
      left[j - k] = (left.head(j - k) * T.col(j).segment(k, j - k))(0) / keep_from_zero(pole - T(j, j), least);
    const MatrixXd v = multiply(U.leftCols(k + 1), right).cwiseAbs();
    const MatrixXd w = multiply(left, U.rightCols(n - k).adjoint()).cwiseAbs();
    const double error = kSafety * multiply_real(multiply_real(w, errors), v)(0, 0);
    const bool real = std::abs(pole.imag()) <= std::min(error, kReal * std::abs(pole));
    poles.push_back({(real ? pole.real() : pole) * rate, error * rate});
  }
  std::ranges::sort(poles, [](const Pole& a, const Pole& b) {
    return std::pair(std::abs(a.value), a.value.imag()) < std::pair(std::abs(b.value), b.value.imag());
  });
  return poles;
}

}  // namespace unlatch::hil
