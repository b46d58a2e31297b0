#include "hil/run/linear/matrices.h"

#include <Eigen/Eigenvalues>
#include <complex>

namespace unlatch::hil {

Eigen::MatrixXcd multiply(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b) { return a * b; }
Eigen::MatrixXd multiply_real(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * b; }

SchurForm calc_schur(const Eigen::MatrixXcd& A) {
  const Eigen::ComplexSchur<Eigen::MatrixXcd> schur(A);
  return {schur.matrixT(), schur.matrixU()};
}

// As a complex matrix, whose decomposition the Schur form has compiled already; of a real one it is real.
HessenbergForm calc_hessenberg(const Eigen::MatrixXd& A) {
  const Eigen::HessenbergDecomposition<Eigen::MatrixXcd> reduced(A.cast<std::complex<double>>());
  const Eigen::MatrixXcd H = reduced.matrixH(), Q = reduced.matrixQ();
  return {H.real(), Q.real()};
}

Eigen::MatrixXcd solve_upper(const Eigen::MatrixXcd& T, const Eigen::MatrixXcd& right) {
  Eigen::MatrixXcd X = right;
  T.triangularView<Eigen::Upper>().solveInPlace(X);
  return X;
}

Eigen::MatrixXcd solve_upper_adjoint(const Eigen::MatrixXcd& T, const Eigen::MatrixXcd& right) {
  Eigen::MatrixXcd X = right;
  T.triangularView<Eigen::Upper>().adjoint().solveInPlace(X);
  return X;
}

}  // namespace unlatch::hil
