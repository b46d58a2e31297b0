#include "tests/support/lumped_flexible.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>

#include "tests/support/linear_algebra.h"

namespace unlatch::test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RealVector3 = Eigen::Matrix<Real, 3, 1>;
using RealMatrix3 = Eigen::Matrix<Real, 3, 3>;

constexpr double kBar = 2e5;  // N/m, each bar
constexpr double kReach = 1.8;  // m: points nearer than that are tied; sides are 1 m, diagonals √2, space diagonals √3
constexpr double kDamping = 0.01;  // relative to critical, every mode

RealMatrix3 calc_cross(const RealVector3& a) {
  RealMatrix3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// Stiffness of bars that resist stretching: for any number of bars, rigid motions have no energy.
MatrixXd calc_stiffness(const std::vector<Vector3d>& points) {
  const auto size = static_cast<Index>(3 * points.size());
  MatrixXd K = MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const Vector3d bar = points[j] - points[i];
      if (bar.norm() > kReach) continue;
      const Matrix3d k = kBar * bar.normalized() * bar.normalized().transpose();
      const Index a = static_cast<Index>(3 * i), b = static_cast<Index>(3 * j);
      K.block<3, 3>(a, a) += k;
      K.block<3, 3>(b, b) += k;
      K.block<3, 3>(a, b) -= k;
      K.block<3, 3>(b, a) -= k;
    }
  return K;
}

}  // namespace

ModalBody build_lattice_mast(int bays, int modes, Support support) {
  ModalBody body;
  Vector3d centre = Vector3d::Zero();
  double total = 0;
  for (int k = 0; k <= bays; ++k)
    for (int corner = 0; corner < 4; ++corner) {
      const double mass = 1 + 0.3 * k + 0.17 * corner;
      body.masses.push_back(mass);
      body.positions.emplace_back(k, corner / 2 - 0.5, corner % 2 - 0.5);
      centre += mass * body.positions.back();
      total += mass;
    }
  for (Vector3d& r : body.positions) r -= centre / total;

  const MatrixXd K = calc_stiffness(body.positions);
  const Index clamped = support == Support::kClamped ? 12 : 0, rigid = support == Support::kClamped ? 0 : 6;
  const Index size = K.rows() - clamped;
  VectorXd mass(K.rows());
  for (Index i = 0; i < K.rows(); ++i) mass[i] = body.masses[static_cast<std::size_t>(i / 3)];
  const VectorXd root = mass.tail(size).cwiseSqrt().cwiseInverse();
  const SymmetricEigen eigen =
      calc_symmetric_eigen(root.asDiagonal() * K.bottomRightCorner(size, size) * root.asDiagonal());
  if (size - rigid < modes) throw std::invalid_argument("a mast of that many bays has fewer modes");
  if (modes == 0) {  // Eigen accepts no empty blocks
    body.shapes.assign(body.masses.size(), Eigen::Matrix<double, 3, Eigen::Dynamic>(3, 0));
    return body;
  }
  body.frequencies = eigen.values.segment(rigid, modes).cwiseSqrt();
  body.damping = 2 * kDamping * body.frequencies;
  MatrixXd shapes = MatrixXd::Zero(K.rows(), modes);
  shapes.bottomRows(size) = root.asDiagonal() * eigen.vectors.middleCols(rigid, modes);
  for (Index i = 0; i < K.rows(); i += 3) body.shapes.emplace_back(shapes.middleRows<3>(i));
  return body;
}

PointJacobian calc_point_jacobian(const ModalBody& body, const FlexibleState& state, std::size_t point) {
  const Eigen::Matrix<Real, 3, Eigen::Dynamic> shape = body.shapes[point].cast<Real>();
  const RealMatrix3 R = state.q_WB.cast<Real>().normalized().toRotationMatrix();
  const RealVector3 w = state.w_WB_B.cast<Real>();
  RealVector3 s = body.positions[point].cast<Real>(), s_rate = RealVector3::Zero();
  if (body.get_modes() > 0) {  // Eigen accepts no empty products
    s += shape * state.eta.cast<Real>();
    s_rate = shape * state.eta_rate.cast<Real>();
  }
  PointJacobian out;
  out.J.resize(3, 6 + body.get_modes());
  out.J.leftCols(6) << RealMatrix3::Identity(), -R * calc_cross(s);
  if (body.get_modes() > 0) out.J.rightCols(body.get_modes()) = R * shape;
  out.bias = R * (w.cross(w.cross(s)) + 2 * w.cross(s_rate));
  return out;
}

FlexibleSystem calc_flexible_system(const ModalBody& body, const FlexibleState& state,
                                    const std::vector<Vector3d>& forces) {
  const Index size = 6 + body.get_modes();
  FlexibleSystem out{RealMatrix::Zero(size, size), RealVector::Zero(size)};
  for (std::size_t i = 0; i < body.masses.size(); ++i) {
    const PointJacobian point = calc_point_jacobian(body, state, i);
    const auto mass = static_cast<Real>(body.masses[i]);
    out.mass += mass * point.J.transpose() * point.J;
    out.force -= mass * point.J.transpose() * point.bias;
    if (!forces.empty()) out.force += point.J.transpose() * forces[i].cast<Real>();
  }
  for (Index k = 0; k < body.get_modes(); ++k) {
    const auto frequency = static_cast<Real>(body.frequencies[k]);
    out.force[6 + k] -= frequency * frequency * static_cast<Real>(state.eta[k]) +
                        static_cast<Real>(body.damping[k]) * static_cast<Real>(state.eta_rate[k]);
  }
  return out;
}

FlexibleAcceleration calc_flexible_acceleration(const ModalBody& body, const FlexibleState& state,
                                                const std::vector<Vector3d>& forces) {
  const FlexibleSystem system = calc_flexible_system(body, state, forces);
  const VectorXd a = system.mass.llt().solve(system.force).cast<double>();
  return {a.head<3>(), a.segment<3>(3), a.tail(body.get_modes())};
}

}  // namespace unlatch::test
