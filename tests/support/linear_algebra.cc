#include "tests/support/linear_algebra.h"

#include <Eigen/Dense>

namespace unlatch::test {

Eigen::VectorXcd calc_eigenvalues(const Eigen::MatrixXd& matrix) { return matrix.eigenvalues(); }

SymmetricEigen calc_symmetric_eigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd solve_full_pivots(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.fullPivLu().solve(right);
}

Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.colPivHouseholderQr().solve(right);
}

Eigen::VectorXd solve_least_norm(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(matrix).solve(right);
}

Eigen::VectorXd calc_singular_values(const Eigen::MatrixXd& matrix) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(matrix).singularValues();
}

Eigen::MatrixXd calc_inverse(const Eigen::MatrixXd& matrix) { return matrix.inverse(); }

}  // namespace unlatch::test
