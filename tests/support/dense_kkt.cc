#include "tests/support/dense_kkt.h"

#include <Eigen/Dense>
#include <cstddef>

namespace unlatch::test {
namespace {

using Vector3 = Eigen::Matrix<Real, 3, 1>;
using Matrix3 = Eigen::Matrix<Real, 3, 3>;
using Index = Eigen::Index;

// Data of a body, or of the ground, for the rows: all in inertial axes.
struct Frame {
  Vector3 p = Vector3::Zero(), v = Vector3::Zero(), w = Vector3::Zero();
  Matrix3 C = Matrix3::Identity();
  Index column = -1;  // column of v_dot in the system; −1 for the ground
};

Frame calc_frame(const SystemState& state, int body) {
  Frame frame;
  if (body == kGround) return frame;
  const DenseBodyState& b = state.bodies[static_cast<std::size_t>(body)];
  frame.C = b.q_WB.cast<Real>().toRotationMatrix();
  frame.p = b.p_WB.cast<Real>();
  frame.v = b.v_WB.cast<Real>();
  frame.w = frame.C * b.w_WB_B.cast<Real>();
  frame.column = 6 * body;
  return frame;
}

Matrix3 calc_rotation_axes(const Joint& joint) { return joint.rotation_axes.value_or(joint.axes).cast<Real>(); }

// Rotation frame in follower axes: given, or such that it coincides with the base's at the initial attitudes.
Matrix3 calc_follower_axes(const Model& model, const Joint& joint) {
  if (joint.follower_axes) return joint.follower_axes->cast<Real>();
  const auto attitude = [&model](int body) -> Matrix3 {
    if (body == kGround) return Matrix3::Identity();
    return model.bodies[static_cast<std::size_t>(body)].q_WB.cast<Real>().toRotationMatrix();
  };
  return attitude(joint.follower).transpose() * attitude(joint.base) * calc_rotation_axes(joint);
}

// One row of G, written as the coefficients of both bodies' v_dot (inertial) and w_dot (inertial, turned to body axes).
void write_row(const Frame& base, const Frame& follower, const Vector3& linear, const Vector3& angular_base,
               const Vector3& angular_follower, Index row, RealMatrix& G) {
  if (base.column >= 0) {
    G.block<1, 3>(row, base.column) -= linear.transpose();
    G.block<1, 3>(row, base.column + 3) -= (base.C.transpose() * angular_base).transpose();
  }
  if (follower.column >= 0) {
    G.block<1, 3>(row, follower.column) += linear.transpose();
    G.block<1, 3>(row, follower.column + 3) += (follower.C.transpose() * angular_follower).transpose();
  }
}

// With rho = C s the arms of the two points, d = r_j − r_i, and n' = w_i × n:
//   g'  = n·(v_j + w_j × rho_j − v_i − w_i × rho_i) + (w_i × n)·d
//       = n·(v_j − v_i) + (rho_j × n)·w_j − ((rho_i + d) × n)·w_i,                     since (w_i × n)·d = −(d × n)·w_i
//   g'' = the same in v', w'  −  c,
//   −c  = n·(w_j × (w_j × rho_j) − w_i × (w_i × rho_i)) + 2 (w_i × n)·d' + (w_i × (w_i × n))·d.
void write_point_plane(const Joint& joint, int axis, const Frame& base, const Frame& follower, Index row,
                       DenseKkt& kkt) {
  const Vector3 n = base.C * joint.axes.col(axis).cast<Real>();
  const Vector3 rho_i = base.C * joint.point_base.cast<Real>();
  const Vector3 rho_j = follower.C * joint.point_follower.cast<Real>();
  const Vector3 d = follower.p + rho_j - base.p - rho_i;
  const Vector3 d_dot = follower.v + follower.w.cross(rho_j) - base.v - base.w.cross(rho_i);
  const Vector3 n_dot = base.w.cross(n);

  write_row(base, follower, n, (rho_i + d).cross(n), rho_j.cross(n), row, kkt.rows);
  kkt.bias(row) = -(n.dot(follower.w.cross(follower.w.cross(rho_j)) - base.w.cross(base.w.cross(rho_i))) +
                    2 * n_dot.dot(d_dot) + base.w.cross(n_dot).dot(d));
}

// n·(w_j − w_i) = 0 differentiated: n·(w_j' − w_i') = −n'·(w_j − w_i).
void write_rotation(const Vector3& n, const Vector3& n_dot, const Frame& base, const Frame& follower, Index row,
                    DenseKkt& kkt) {
  write_row(base, follower, Vector3::Zero(), n, n, row, kkt.rows);
  kkt.bias(row) = -n_dot.dot(follower.w - base.w);
}

void write_fixed_rotation(const Joint& joint, int axis, const Frame& base, const Frame& follower, Index row,
                          DenseKkt& kkt) {
  const Vector3 n = base.C * calc_rotation_axes(joint).col(axis);
  write_rotation(n, base.w.cross(n), base, follower, row, kkt);
}

// n = u / |u| with u = x × y: u' = (w_i × x) × y + x × (w_j × y), n' = (u' − n (n·u')) / |u|.
void write_universal_rotation(const Model& model, const Joint& joint, const Frame& base, const Frame& follower,
                              Index row, DenseKkt& kkt) {
  const Vector3 x = base.C * calc_rotation_axes(joint).col(0);
  const Vector3 y = follower.C * calc_follower_axes(model, joint).col(1);
  const Vector3 u = x.cross(y);
  const Vector3 u_dot = base.w.cross(x).cross(y) + x.cross(follower.w.cross(y));
  const Vector3 n = u / u.norm();
  write_rotation(n, (u_dot - n * n.dot(u_dot)) / u.norm(), base, follower, row, kkt);
}

void write_joint_row(const Model& model, const Joint& joint, RowSet set, int row, const SystemState& state, Index at,
                     DenseKkt& kkt) {
  const Frame base = calc_frame(state, joint.base), follower = calc_frame(state, joint.follower);
  const bool universal = joint.universal && (set & kRotationRows) == row_bit(kRotZ);
  if (row < kRotX) {
    write_point_plane(joint, row, base, follower, at, kkt);
  } else if (universal) {
    write_universal_rotation(model, joint, base, follower, at, kkt);
  } else {
    write_fixed_rotation(joint, row - kRotX, base, follower, at, kkt);
  }
}

// Solver of the system. M = L Lᵀ, L body by body. With y = Lᵀ a and A = D G L^-T (D scales rows to length one) the
// system is
//   y − Aᵀ (D^-1 λ) = L^-1 F,   A y = D c,
// so y = L^-1 F + z with z = A⁺ (D c − A L^-1 F) and λ = D (Aᵀ)⁺ z. The factors are in double, the residuals in long
// double: three rounds bring the solution to the accuracy of the residuals as long as the condition is below some 1e13.
class Solver {
 public:
  explicit Solver(const DenseKkt& kkt) : kkt_(kkt), A_(kkt.rows.rows(), kkt.rows.cols()) {
    for (Index at = 0; at < kkt.mass.rows(); at += 6) L_.emplace_back(RealMatrix(kkt.mass.block(at, at, 6, 6)));
    if (A_.rows() == 0) return;  // Eigen accepts no empty blocks
    for (Index row = 0; row < A_.rows(); ++row) {
      RealVector entries = kkt.rows.row(row).transpose();
      for (std::size_t b = 0; b < L_.size(); ++b) solve_body(L_[b].matrixL(), b, entries);
      A_.row(row) = entries.transpose();
    }
    scale_ = A_.rowwise().norm().cwiseInverse();
    A_ = scale_.asDiagonal() * A_;
    cod_.compute(Eigen::MatrixXd(A_.cast<double>()));
  }

  DenseSolution solve(const RealVector& F, const RealVector& c, std::size_t joint_count) const {
    RealVector a = RealVector::Zero(F.size()), lambda = RealVector::Zero(c.size());
    constexpr int kRounds = 4;
    for (int round = 0; round < kRounds; ++round) {
      RealVector rest = F - kkt_.mass * a;
      if (c.size() > 0) rest += kkt_.rows.transpose() * lambda;
      update(rest, c.size() > 0 ? RealVector(c - kkt_.rows * a) : c, a, lambda);
    }
    return build_solution(a, lambda, c, joint_count);
  }

 private:
  // With matrices of a size that the compiler does not know: unrolled for six rows, this took it as long as all else.
  template <class Triangle>
  static void solve_body(const Triangle& triangle, std::size_t body, RealVector& y) {
    RealVector part = y.segment<6>(static_cast<Index>(6 * body));
    triangle.solveInPlace(part);
    y.segment<6>(static_cast<Index>(6 * body)) = part;
  }

  void update(const RealVector& F, const RealVector& c, RealVector& a, RealVector& lambda) const {
    RealVector y = F;
    for (std::size_t b = 0; b < L_.size(); ++b) solve_body(L_[b].matrixL(), b, y);
    if (c.size() > 0) {
      const RealVector missing = scale_.cwiseProduct(c) - A_ * y;
      const Eigen::VectorXd rest = missing.cast<double>(), z = cod_.solve(rest);
      const Eigen::VectorXd mu = cod_.transpose().solve(z);
      y += z.cast<Real>();
      lambda += scale_.cwiseProduct(mu.cast<Real>());
    }
    for (std::size_t b = 0; b < L_.size(); ++b) solve_body(L_[b].matrixU(), b, y);
    a += y;
  }

  DenseSolution build_solution(const RealVector& a, const RealVector& lambda, const RealVector& c,
                               std::size_t joint_count) const {
    DenseSolution solution;
    for (Index at = 0; at < a.size(); at += 6) {
      solution.linear.push_back(a.segment<3>(at).cast<double>());
      solution.angular.push_back(a.segment<3>(at + 3).cast<double>());
    }
    solution.multipliers.assign(joint_count, Eigen::Matrix<double, 6, 1>::Zero());
    for (Index k = 0; k < lambda.size(); ++k) {
      const DenseKkt::RowName& name = kkt_.names[static_cast<std::size_t>(k)];
      solution.multipliers[static_cast<std::size_t>(name.joint)](name.row) = static_cast<double>(lambda(k));
    }
    if (c.size() > 0) {
      const auto diagonal = cod_.matrixQTZ().diagonal().head(cod_.rank()).cwiseAbs();
      solution.condition = diagonal.maxCoeff() / diagonal.minCoeff();
      solution.redundant = static_cast<int>(c.size() - cod_.rank());
      solution.residual = static_cast<double>((kkt_.rows * a - c).cwiseAbs().maxCoeff());
    }
    return solution;
  }

  const DenseKkt& kkt_;
  std::vector<Eigen::LLT<RealMatrix>> L_;
  RealMatrix A_;
  RealVector scale_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> cod_;
};

}  // namespace

SystemState build_initial_state(const Model& model) {
  SystemState state;
  for (const Body& body : model.bodies) state.bodies.push_back({body.p_WB, body.v_WB, body.q_WB, body.w_WB_B});
  for (const Joint& joint : model.joints) state.modes.push_back(joint.mode);
  return state;
}

DenseKkt build_dense_kkt(const Model& model, const SystemState& state) {
  DenseKkt kkt;
  const auto size = static_cast<Index>(6 * model.bodies.size());
  kkt.mass = RealMatrix::Zero(size, size);
  kkt.gyroscopic = RealVector::Zero(size);
  kkt.speed = RealVector::Zero(size);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const auto at = static_cast<Index>(6 * b);
    const Vector3 w = state.bodies[b].w_WB_B.cast<Real>();
    const Matrix3 J = model.bodies[b].inertia.cast<Real>();
    kkt.mass.block<3, 3>(at, at) = static_cast<Real>(model.bodies[b].mass) * Matrix3::Identity();
    kkt.mass.block<3, 3>(at + 3, at + 3) = J;
    kkt.gyroscopic.segment<3>(at + 3) = -w.cross(J * w);
    kkt.speed.segment<3>(at) = state.bodies[b].v_WB.cast<Real>();
    kkt.speed.segment<3>(at + 3) = w;
  }

  const auto active = [&](std::size_t j) {
    return model.joints[j].modes[static_cast<std::size_t>(state.modes[j])].rows;
  };
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    for (int row = 0; row < kRows; ++row) {
      if (has_row(active(j), row)) kkt.names.push_back({static_cast<int>(j), row});
    }
  }
  kkt.rows = RealMatrix::Zero(static_cast<Index>(kkt.names.size()), size);
  kkt.bias = RealVector::Zero(static_cast<Index>(kkt.names.size()));
  for (std::size_t k = 0; k < kkt.names.size(); ++k) {
    const auto joint = static_cast<std::size_t>(kkt.names[k].joint);
    write_joint_row(model, model.joints[joint], active(joint), kkt.names[k].row, state, static_cast<Index>(k), kkt);
  }
  return kkt;
}

DenseSolution solve_accelerations(const Model& model, const SystemState& state, const std::vector<Wrench>& wrenches) {
  const DenseKkt kkt = build_dense_kkt(model, state);
  RealVector F = kkt.gyroscopic;
  for (std::size_t b = 0; b < wrenches.size(); ++b) {
    const Frame frame = calc_frame(state, static_cast<int>(b));
    F.segment<3>(frame.column) += wrenches[b].force.cast<Real>();
    F.segment<3>(frame.column + 3) += frame.C.transpose() * wrenches[b].torque.cast<Real>();
  }
  return Solver(kkt).solve(F, kkt.bias, model.joints.size());
}

DenseSolution solve_plastic_impulse(const Model& model, const SystemState& state) {
  const DenseKkt kkt = build_dense_kkt(model, state);
  return Solver(kkt).solve(RealVector::Zero(kkt.speed.size()), -(kkt.rows * kkt.speed), model.joints.size());
}

}  // namespace unlatch::test
