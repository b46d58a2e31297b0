// Products and decompositions of dense matrices, compiled once for all files of this folder: each form of product or
// matrix that an expression of Eigen's has anew takes a compiler seconds.
#pragma once

#include <Eigen/Core>

namespace unlatch::hil {

Eigen::MatrixXcd multiply(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);
Eigen::MatrixXd multiply_real(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// A = U T Uᴴ: U unitary, T upper triangular.
struct SchurForm {
  Eigen::MatrixXcd T, U;
};
SchurForm calc_schur(const Eigen::MatrixXcd& A);

// A = Q H Qᵀ: Q orthogonal, H without entries below its first subdiagonal.
struct HessenbergForm {
  Eigen::MatrixXd H, Q;
};
HessenbergForm calc_hessenberg(const Eigen::MatrixXd& A);

// X of T X = right, and of Tᴴ X = right: T upper triangular.
Eigen::MatrixXcd solve_upper(const Eigen::MatrixXcd& T, const Eigen::MatrixXcd& right);
Eigen::MatrixXcd solve_upper_adjoint(const Eigen::MatrixXcd& T, const Eigen::MatrixXcd& right);

}  // namespace unlatch::hil
