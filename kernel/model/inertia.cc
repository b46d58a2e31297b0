#include "unlatch/inertia.h"

#include <Eigen/Eigenvalues>

namespace unlatch {

Eigen::Vector3d calc_principal_moments(const Eigen::Matrix3d& inertia) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
}

PrincipalAxes calc_principal_axes(const Eigen::Matrix3d& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  PrincipalAxes principal{solver.eigenvalues(), solver.eigenvectors()};
  if (principal.axes.determinant() < 0) principal.axes.col(2) = -principal.axes.col(2);
  return principal;
}

}  // namespace unlatch
