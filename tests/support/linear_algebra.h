// Eigen's decompositions for tests, compiled once: each instantiation takes a compiler some ten seconds.
#pragma once

#include <Eigen/Core>

namespace unlatch::test {

// Eigenvalues of any square matrix, in no particular order.
Eigen::VectorXcd calc_eigenvalues(const Eigen::MatrixXd& matrix);

// Eigenvalues, ascending, and orthonormal eigenvectors (columns) of a symmetric matrix; its lower triangle is read.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen calc_symmetric_eigen(const Eigen::MatrixXd& matrix);

// Solution x of matrix · x = right: by Gauss with full pivots; least squares by Householder's QR.
Eigen::VectorXd solve_full_pivots(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

// The least of all solutions x of matrix · x = right, or of those with the least residual.
Eigen::VectorXd solve_least_norm(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

// Singular values, descending.
Eigen::VectorXd calc_singular_values(const Eigen::MatrixXd& matrix);

// Inverse of a regular matrix, by Gauss with row pivots.
Eigen::MatrixXd calc_inverse(const Eigen::MatrixXd& matrix);

}  // namespace unlatch::test
