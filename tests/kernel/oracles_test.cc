// Checks of the oracles of implicit springs and of flexible bodies; the kernel's own springs, which are explicit where
// the step resolves them, follow the oracles.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/implicit_springs.h"
#include "tests/support/lumped_flexible.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"

namespace unlatch::test::oracles_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

SpringChain build_chain(double stiffness) {
  return {{1, 2, 0.5}, {stiffness, 2 * stiffness, stiffness}, {0, 0, 0}, {0.05, -0.02, 0.03}, {0.1, 0.2, -0.1}};
}
SpringPendulum build_pendulum(double stiffness) {
  SpringPendulum pendulum;
  pendulum.stiffness = stiffness;
  pendulum.damping = 0.1;
  pendulum.angle = 0.4;
  pendulum.speed = -0.3;
  return pendulum;
}

TEST(Ros2, HasOrderTwoWhereTheStepResolvesTheSpring) {
  const SpringChain chain = build_chain(100);
  const SpringPendulum pendulum = build_pendulum(50);
  const VectorXd chain_exact = calc_exact(chain, 1), pendulum_exact = calc_accurate(pendulum, 1);
  for (const int steps : {200, 400, 800}) {
    const double h = 1.0 / steps;
    const double ratio =
        (run_ros2(chain, h, steps) - chain_exact).norm() / (run_ros2(chain, h / 2, 2 * steps) - chain_exact).norm();
    EXPECT_NEAR(ratio, 4, 0.4);
    // A contains the spring alone and not gravity: order two nevertheless.
    const double pendulum_ratio = (run_ros2(pendulum, h, steps) - pendulum_exact).norm() /
                                  (run_ros2(pendulum, h / 2, 2 * steps) - pendulum_exact).norm();
    EXPECT_NEAR(pendulum_ratio, 4, 0.4);
  }
}

TEST(Ros2, DampsWhatTheStepDoesNotResolveAndNeverGainsEnergy) {
  for (const double stiffness : {1e2, 1e4, 1e6, 1e9, 1e12}) {
    const SpringChain chain = build_chain(stiffness);
    const Eigen::MatrixXd A = build_jacobian(chain);
    VectorXd y = get_start(chain);
    double energy = calc_energy(chain, y);
    for (int i = 0; i < 100; ++i) {
      y = step_ros2([&A](const VectorXd& x) -> VectorXd { return A * x; }, A, y, 1e-3);
      const double next = calc_energy(chain, y);
      EXPECT_LE(next, energy * (1 + 1e-12)) << stiffness << " N/m, step " << i;
      energy = next;
    }
    if (stiffness >= 1e9) {
      EXPECT_LT(energy, 1e-20 * calc_energy(chain, get_start(chain)));
    }
  }
  // A latch at the balance of spring and gravity stays at rest.
  SpringPendulum latch = build_pendulum(1e9);
  latch.angle = 1e-6;
  latch.speed = 0;
  const VectorXd y = run_ros2(latch, 1e-3, 100);
  EXPECT_NEAR(y[0], -latch.mass * latch.gravity * latch.arm / latch.stiffness, 1e-15);
  EXPECT_NEAR(y[1], 0, 1e-9);
}

// Runge–Kutta stages of order four, where they resolve the springs.
TEST(Springs, FollowTheirExactMotionWhereTheStepResolvesThem) {
  constexpr double kChain = 2e-8, kPendulum = 2e-8;  // m, m/s; rad, rad/s; fastest swing 0.02 rad a step, 1 s
  const SpringChain chain = build_chain(100);
  Simulation s(build_model(chain));
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const VectorXd exact = calc_exact(chain, 1);
  double position = 0, speed = 0;
  for (Index k = 0; k < 3; ++k) {
    position += 1 + exact[k];
    speed += exact[3 + k];
    EXPECT_NEAR(s.state.bodies[static_cast<std::size_t>(k)].p.x, position, kChain);
    EXPECT_NEAR(s.state.bodies[static_cast<std::size_t>(k)].v.x, speed, kChain);
  }

  const SpringPendulum pendulum = build_pendulum(50);
  Simulation p(build_model(pendulum));
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(p.advance().status, StepStatus::kOk);
  const VectorXd accurate = calc_accurate(pendulum, 1);
  EXPECT_NEAR(2 * std::atan2(p.state.bodies[0].q.z, p.state.bodies[0].q.w), accurate[0], kPendulum);
  EXPECT_NEAR(p.state.bodies[0].w.z, accurate[1], kPendulum);
}

// --- Flexible bodies ------------------------------------------------------------------------------------------------

FlexibleState draw_state(const ModalBody& body, Random& random) {
  const auto vector = [&random](double size) {
    const double x = random.uniform(-size, size), y = random.uniform(-size, size), z = random.uniform(-size, size);
    return Vector3d(x, y, z);
  };
  FlexibleState state{vector(3), vector(2), {}, vector(1), VectorXd(body.get_modes()), VectorXd(body.get_modes())};
  const Vector3d turn = vector(1);
  state.q_WB = Eigen::Quaterniond(1, turn.x(), turn.y(), turn.z()).normalized();
  for (double& eta : state.eta) eta = random.uniform(-0.2, 0.2);
  for (double& rate : state.eta_rate) rate = random.uniform(-1, 1);
  return state;
}

std::vector<Vector3d> draw_forces(const ModalBody& body, Random& random) {
  std::vector<Vector3d> forces;
  for (std::size_t i = 0; i < body.masses.size(); ++i)
    forces.emplace_back(random.uniform(-20, 20), random.uniform(-20, 20), random.uniform(-20, 20));
  return forces;
}

TEST(LumpedFlexible, FreeModesCarryNoMomentumAndClampedOnesStandStillAtTheRoot) {
  const ModalBody free = build_lattice_mast(5, 6, Support::kFree), held = build_lattice_mast(5, 6, Support::kClamped);
  Eigen::Matrix3Xd linear = Eigen::Matrix3Xd::Zero(3, 6), angular = linear;
  Eigen::MatrixXd modal = Eigen::MatrixXd::Zero(6, 6);
  for (std::size_t i = 0; i < free.masses.size(); ++i) {
    linear += free.masses[i] * free.shapes[i];
    for (Index k = 0; k < 6; ++k) angular.col(k) += free.masses[i] * free.positions[i].cross(free.shapes[i].col(k));
    modal += free.masses[i] * free.shapes[i].transpose() * free.shapes[i];
  }
  EXPECT_LT(linear.norm(), 1e-10);
  EXPECT_LT(angular.norm(), 1e-10);
  EXPECT_LT((modal - Eigen::MatrixXd::Identity(6, 6)).norm(), 1e-10);
  EXPECT_GT(free.frequencies[0], 1);
  EXPECT_LT(held.frequencies[0], free.frequencies[0]);  // a cantilever is slower than a free beam
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(held.shapes[i].norm(), 0);
}

// Lagrange's equations by numerical differentiation of the kinetic energy alone. Coordinates: the origin's position, a
// rotation vector from the present attitude, η; along q(t) = q' t + q'' t²/2 with the oracle's accelerations.
class Lagrange {
 public:
  Lagrange(const ModalBody& body, const FlexibleState& state) : body_(body), state_(state) {}

  // d/dt ∂T/∂q' − ∂T/∂q at t = 0.
  RealVector calc_inertial_forces(const RealVector& q_rate, const RealVector& q_second) const {
    const Real h = 2e-5L;
    RealVector out(q_rate.size());
    for (Index k = 0; k < q_rate.size(); ++k) {
      const auto momentum = [&](Real t) {
        const RealVector q = q_rate * t + q_second * (t * t / 2);
        RealVector up = q_rate + q_second * t, down = up;
        up[k] += 1;
        down[k] -= 1;
        return (calc_energy(q, up) - calc_energy(q, down)) / 2;  // exact: T is quadratic in the rates
      };
      const auto energy = [&](Real step) {
        RealVector q = RealVector::Zero(q_rate.size());
        q[k] = step;
        return calc_energy(q, q_rate);
      };
      const auto difference = [&](auto& f) { return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h); };
      out[k] = difference(momentum) - difference(energy);
    }
    return out;
  }

 private:
  // Positions and their rates by the exponential of the rotation vector, differentiated along the motion.
  Real calc_energy(const RealVector& q, const RealVector& rate) const {
    using V = Eigen::Matrix<Real, 3, 1>;
    const Real e = 1e-5L;
    const auto position = [&](std::size_t i, Real t) -> V {
      const V turn = q.segment<3>(3) + t * rate.segment<3>(3);
      const Real angle = turn.norm();
      const V axis = angle > 0 ? V(turn / angle) : V(V::UnitX());
      const RealVector eta = state_.eta.cast<Real>() + q.tail(body_.get_modes()) + t * rate.tail(body_.get_modes());
      const V s = body_.positions[i].cast<Real>() + body_.shapes[i].cast<Real>() * eta;
      const V turned = state_.q_WB.cast<Real>() * (Eigen::AngleAxis<Real>(angle, axis) * s);
      return q.head<3>() + t * rate.head<3>() + turned;
    };
    Real sum = 0;
    for (std::size_t i = 0; i < body_.masses.size(); ++i) {
      const V speed = (8 * (position(i, e) - position(i, -e)) - (position(i, 2 * e) - position(i, -2 * e))) / (12 * e);
      sum += static_cast<Real>(body_.masses[i]) * speed.squaredNorm() / 2;
    }
    return sum;
  }

  const ModalBody& body_;
  const FlexibleState& state_;
};

TEST(LumpedFlexible, AccelerationsObeyLagrangesEquations) {
  constexpr double kDifferentiation = 1e-7;  // relative: two nested differentiations, in long double
  for (const Support support : {Support::kFree, Support::kClamped}) {
    const ModalBody body = build_lattice_mast(2, 3, support);
    Random random(11);
    const FlexibleState state = draw_state(body, random);
    const std::vector<Vector3d> forces = draw_forces(body, random);
    const FlexibleAcceleration a = calc_flexible_acceleration(body, state, forces);
    RealVector rate(9), second(9), applied = RealVector::Zero(9);
    rate << state.v_WB.cast<Real>(), state.w_WB_B.cast<Real>(), state.eta_rate.cast<Real>();
    second << a.linear.cast<Real>(), a.angular.cast<Real>(), a.modal.cast<Real>();
    for (std::size_t i = 0; i < forces.size(); ++i)
      applied += calc_point_jacobian(body, state, i).J.transpose() * forces[i].cast<Real>();
    for (Index k = 0; k < 3; ++k)
      applied[6 + k] -= static_cast<Real>(body.frequencies[k] * body.frequencies[k] * state.eta[k] +
                                          body.damping[k] * state.eta_rate[k]);
    const RealVector inertial = Lagrange(body, state).calc_inertial_forces(rate, second);
    const auto error = static_cast<double>((inertial - applied).norm() / applied.norm());
    EXPECT_LT(error, kDifferentiation);
    std::printf("  Lagrange's equations hold to %.1e\n", error);
  }
}

TEST(LumpedFlexible, IsARigidBodyWithoutModes) {
  const ModalBody mast = build_lattice_mast(3, 4, Support::kFree);
  ModalBody rigid = mast;
  rigid.frequencies.resize(0);
  rigid.damping.resize(0);
  for (Eigen::Matrix3Xd& shape : rigid.shapes) shape.resize(3, 0);
  Random random(5);
  FlexibleState state = draw_state(rigid, random);
  const std::vector<Vector3d> forces = draw_forces(rigid, random);
  const FlexibleAcceleration a = calc_flexible_acceleration(rigid, state, forces);
  double mass = 0;
  Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < rigid.masses.size(); ++i) {
    const Vector3d r = rigid.positions[i];
    mass += rigid.masses[i];
    force += forces[i];
    torque += r.cross(state.q_WB.conjugate() * forces[i]);
    inertia += rigid.masses[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Vector3d gyroscopic = state.w_WB_B.cross(inertia * state.w_WB_B);
  EXPECT_LT((a.linear - force / mass).norm(), 1e-12);
  EXPECT_LT((inertia * a.angular - (torque - gyroscopic)).norm(), 1e-10);
}

}  // namespace
}  // namespace unlatch::test::oracles_test
