#include "tests/support/implicit_springs.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>

#include "tests/support/linear_algebra.h"
#include "tests/support/small_models.h"

namespace unlatch::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }
Index get_count(const SpringChain& chain) { return static_cast<Index>(chain.masses.size()); }
VectorXd to_vector(const std::vector<double>& a) { return VectorXd::Map(a.data(), static_cast<Index>(a.size())); }

// Kinetic energy in the rates of the stretches: mass i moves with the sum of the first i + 1.
MatrixXd calc_mass_matrix(const SpringChain& chain) {
  const Index n = get_count(chain);
  MatrixXd sums = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i) sums.row(i).head(i + 1).setOnes();
  return sums.transpose() * to_vector(chain.masses).asDiagonal() * sums;
}

}  // namespace

VectorXd step_ros2(const Rate& f, const MatrixXd& A, const VectorXd& y, double h) {
  const double gamma = 1 - std::sqrt(0.5);
  const MatrixXd W = MatrixXd::Identity(A.rows(), A.cols()) - gamma * h * A;
  const VectorXd k1 = solve_full_pivots(W, f(y));
  const VectorXd k2 = solve_full_pivots(W, f(y + h * k1) - 2 * k1);
  return y + 1.5 * h * k1 + 0.5 * h * k2;
}

VectorXd get_start(const SpringChain& chain) {
  VectorXd y(2 * get_count(chain));
  y << to_vector(chain.stretches), to_vector(chain.speeds);
  return y;
}

MatrixXd build_jacobian(const SpringChain& chain) {
  const Index n = get_count(chain);
  const MatrixXd mobility = calc_inverse(calc_mass_matrix(chain));
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -mobility * to_vector(chain.stiffnesses).asDiagonal();
  A.bottomRightCorner(n, n) = -mobility * to_vector(chain.dampings).asDiagonal();
  return A;
}

VectorXd calc_exact(const SpringChain& chain, double t) {
  const MatrixXd A = t * build_jacobian(chain), grown = A.exp();
  return grown * get_start(chain);
}

VectorXd run_ros2(const SpringChain& chain, double h, int steps) {
  const MatrixXd A = build_jacobian(chain);
  VectorXd y = get_start(chain);
  for (int i = 0; i < steps; ++i) y = step_ros2([&A](const VectorXd& x) -> VectorXd { return A * x; }, A, y, h);
  return y;
}

double calc_energy(const SpringChain& chain, const VectorXd& y) {
  const Index n = get_count(chain);
  const VectorXd stretch = y.head(n), rate = y.tail(n);
  return 0.5 * (stretch.cwiseAbs2().dot(to_vector(chain.stiffnesses)) + rate.dot(calc_mass_matrix(chain) * rate));
}

// The masses rest a metre apart along x, which is z of the joints; they start with stretched springs.
Model build_model(const SpringChain& chain) {
  Model model;
  model.name = "spring_chain";
  Eigen::Matrix3d axes;
  axes << Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d::UnitX();
  double position = 0, speed = 0;
  for (Index i = 0; i < get_count(chain); ++i) {
    const std::string id = std::to_string(i);
    position += 1 + chain.stretches[at(i)];
    speed += chain.speeds[at(i)];
    Body mass = box("mass" + id, chain.masses[at(i)], 1, 1, 1);
    mass.p_WB = {position, 0, 0};
    mass.v_WB = {speed, 0, 0};
    model.bodies.push_back(mass);
    Joint joint;
    joint.name = "slide" + id;
    joint.base = i == 0 ? kGround : static_cast<int>(i) - 1;
    joint.follower = static_cast<int>(i);
    joint.point_base = {1, 0, 0};
    joint.axes = axes;
    joint.modes = {{"prismatic", static_cast<RowSet>(row_bit(kX) | row_bit(kY) | kRotationRows)}};
    model.joints.push_back(joint);
    JointSpring spring;
    spring.name = "spring" + id;
    spring.joint = static_cast<int>(i);
    spring.axis = kZ;
    spring.stiffness = chain.stiffnesses[at(i)];
    spring.damping = chain.dampings[at(i)];
    model.joint_springs.push_back(spring);
  }
  return model;
}

VectorXd calc_rate(const SpringPendulum& p, const VectorXd& y) {
  const double moment = -p.stiffness * y[0] - p.damping * y[1] - p.mass * p.gravity * p.arm * std::cos(y[0]);
  return Eigen::Vector2d(y[1], moment / (p.inertia + p.mass * p.arm * p.arm));
}

MatrixXd build_spring_jacobian(const SpringPendulum& p) {
  const double inertia = p.inertia + p.mass * p.arm * p.arm;
  MatrixXd A(2, 2);
  A << 0, 1, -p.stiffness / inertia, -p.damping / inertia;
  return A;
}

VectorXd run_ros2(const SpringPendulum& p, double h, int steps) {
  VectorXd y = Eigen::Vector2d(p.angle, p.speed);
  for (int i = 0; i < steps; ++i)
    y = step_ros2([&p](const VectorXd& x) { return calc_rate(p, x); }, build_spring_jacobian(p), y, h);
  return y;
}

VectorXd calc_accurate(const SpringPendulum& p, double t) {
  using Wide = long double;
  struct Pair {
    Wide angle, speed;
  };
  const auto real = [](double x) { return static_cast<Wide>(x); };
  const Wide inertia = real(p.inertia) + real(p.mass) * real(p.arm) * real(p.arm);
  const Wide weight = real(p.mass) * real(p.gravity) * real(p.arm);
  const auto rate = [&](const Pair& y) -> Pair {
    return {y.speed, (-real(p.stiffness) * y.angle - real(p.damping) * y.speed - weight * std::cos(y.angle)) / inertia};
  };
  // Step of a thousandth of the fastest oscillation's radian: an error of some 1e-13 of the amplitude per radian.
  const double fastest = std::sqrt((p.stiffness + p.mass * p.gravity * p.arm) / static_cast<double>(inertia)) + 1;
  const long steps = std::lround(std::ceil(t * fastest * 1000)) + 1;
  const Wide h = static_cast<Wide>(t) / static_cast<Wide>(steps);
  Pair y{real(p.angle), real(p.speed)};
  for (long i = 0; i < steps; ++i) {
    const auto ahead = [&](Wide c, const Pair& k) { return Pair{y.angle + c * k.angle, y.speed + c * k.speed}; };
    const Pair k1 = rate(y), k2 = rate(ahead(h / 2, k1)), k3 = rate(ahead(h / 2, k2)), k4 = rate(ahead(h, k3));
    y.angle += h / 6 * (k1.angle + 2 * k2.angle + 2 * k3.angle + k4.angle);
    y.speed += h / 6 * (k1.speed + 2 * k2.speed + 2 * k3.speed + k4.speed);
  }
  return Eigen::Vector2d(static_cast<double>(y.angle), static_cast<double>(y.speed));
}

double calc_energy(const SpringPendulum& p, const VectorXd& y) {
  const double inertia = p.inertia + p.mass * p.arm * p.arm;
  return 0.5 * (inertia * y[1] * y[1] + p.stiffness * y[0] * y[0]) + p.mass * p.gravity * p.arm * std::sin(y[0]);
}

Model build_model(const SpringPendulum& p) {
  Model model;
  model.name = "spring_pendulum";
  model.gravity.uniform = {0, -p.gravity, 0};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(p.angle, Vector3d::UnitZ()));
  Body bar = box("bar", p.mass, p.inertia, p.inertia, p.inertia);
  bar.p_WB = turn * Vector3d(p.arm, 0, 0);
  bar.q_WB = turn;
  bar.w_WB_B = {0, 0, p.speed};
  bar.v_WB = Vector3d(0, 0, p.speed).cross(bar.p_WB);
  model.bodies.push_back(bar);
  Joint hinge;
  hinge.name = "hinge";
  hinge.point_follower = {-p.arm, 0, 0};
  hinge.follower_axes = Eigen::Matrix3d::Identity();
  hinge.modes = {{"hinge", kRevoluteRows}};
  model.joints.push_back(hinge);
  JointSpring spring;
  spring.name = "spring";
  spring.stiffness = p.stiffness;
  spring.damping = p.damping;
  model.joint_springs.push_back(spring);
  return model;
}

}  // namespace unlatch::test
