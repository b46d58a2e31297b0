// Springs that the step does not resolve: ROS2 with compliant rows in the step's own matrix.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernel/dynamics/balance.h"
#include "kernel/integration/integrator.h"
#include "tests/support/implicit_springs.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::compliance_test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

SpringChain build_chain(double stiffness, double damping) {
  return {{1, 2, 0.5},
          {stiffness, 2 * stiffness, stiffness},
          {damping, damping, 2 * damping},
          {0.05, -0.02, 0.03},
          {0.1, 0.2, -0.1}};
}

// Reads stretches of a chain's springs, then their rates.
VectorXd read_chain(const Simulation& s) {
  const auto n = static_cast<Eigen::Index>(s.state.bodies.size());
  VectorXd y(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto b = static_cast<std::size_t>(i);
    y[i] = s.state.bodies[b].p.x - (i == 0 ? 0 : s.state.bodies[b - 1].p.x) - 1;
    y[n + i] = s.state.bodies[b].v.x - (i == 0 ? 0 : s.state.bodies[b - 1].v.x);
  }
  return y;
}

TEST(Compliance, IsRos2OnAChainOfSprings) {
  for (const double stiffness : {1e4, 1e6, 1e9}) {
    const SpringChain chain = build_chain(stiffness, 3);
    Model model = build_model(chain);
    for (JointSpring& spring : model.joint_springs) spring.implicit = true;
    Simulation s(model);
    VectorXd expected = get_start(chain);
    const Eigen::MatrixXd A = build_jacobian(chain);
    double scale = expected.tail(3).norm();
    for (int i = 0; i < 50; ++i) {
      ASSERT_EQ(s.advance().status, StepStatus::kOk);
      expected = step_ros2([&A](const VectorXd& y) -> VectorXd { return A * y; }, A, expected, 1e-3);
      scale = std::max(scale, expected.norm());
      // Positions of some metres determine the stretches: their rounding times the highest rate √(k/m).
      EXPECT_LT((read_chain(s) - expected).norm(), 1e-9 * scale) << stiffness << " N/m, step " << i;
    }
  }
}

double run_pendulum(const SpringPendulum& pendulum, double h, double t) {
  Model model = build_model(pendulum);
  model.joint_springs[0].implicit = true;
  Simulation s(model, {.dt = h});
  for (int i = 0; i < std::lround(t / h); ++i) EXPECT_EQ(s.advance().status, StepStatus::kOk);
  return std::atan2(s.state.bodies[0].p.y, s.state.bodies[0].p.x);
}

TEST(Compliance, HasOrderTwoWhereTheStepResolvesTheSpring) {
  SpringPendulum pendulum;
  pendulum.stiffness = 50;
  pendulum.damping = 0.1;
  pendulum.angle = 0.4;
  pendulum.speed = -0.3;
  const double exact = calc_accurate(pendulum, 1)[0];
  const double coarse = std::abs(run_pendulum(pendulum, 2e-3, 1) - exact);
  const double fine = std::abs(run_pendulum(pendulum, 1e-3, 1) - exact);
  EXPECT_NEAR(coarse / fine, 4, 0.4);
}

// The latch of 1e9 N m/rad at 1 ms: h ω is 27,000. It holds the bar against its weight, at rest.
TEST(Compliance, AStiffLatchIsStableAndHolds) {
  SpringPendulum pendulum;
  pendulum.stiffness = 1e9;
  pendulum.angle = 1e-3;
  pendulum.speed = 0.5;
  Model model = build_model(pendulum);
  Simulation s(model);
  ASSERT_NE(s.data().joint_springs[0].compliant, kNone);  // the plan's own decision
  for (int i = 0; i < 10'000; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const double sag = -pendulum.mass * pendulum.gravity * pendulum.arm / pendulum.stiffness;  // 4.9e-9 rad
  EXPECT_NEAR(std::atan2(s.state.bodies[0].p.y, s.state.bodies[0].p.x), sag, 1e-12);
  EXPECT_NEAR(s.state.bodies[0].w.z, 0, 1e-9);
}

// Two bodies on six springs without rows, a bushing, that turn together.
Model build_bushing(double stiffness) {
  Model model;
  model.bodies = {box("left", 3, 1, 2, 1.5), box("right", 2, 0.5, 1, 1)};
  model.bodies[1].p_WB = {2, 0, 0};
  const Vector3d turning(0.3, -0.2, 0.5);
  model.bodies[0].v_WB = {0.1, 0.2, -0.3};
  model.bodies[1].v_WB = model.bodies[0].v_WB + turning.cross(model.bodies[1].p_WB);
  model.bodies[0].w_WB_B = model.bodies[1].w_WB_B = turning;
  Joint joint;
  joint.name = "bushing";
  joint.base = 0;
  joint.follower = 1;
  joint.point_base = {1, 0, 0};
  joint.point_follower = {-1, 0, 0};
  joint.modes = {{"free", 0}};
  model.joints.push_back(joint);
  for (int axis = 0; axis < kRows; ++axis) {
    JointSpring spring;
    spring.name = std::string("spring_") + kRowNames[axis];
    spring.joint = 0;
    spring.axis = axis;
    spring.stiffness = stiffness;
    spring.damping = 1e-4 * stiffness;
    model.joint_springs.push_back(spring);
  }
  return model;
}

TEST(Compliance, ABushingOfSixSpringsKeepsMomentaAndBecomesAWeld) {
  const Model model = build_bushing(1e8);
  Simulation s(model);
  EXPECT_EQ(s.data().compliant.size(), 6u);
  ASSERT_EQ(evaluate_state(s), kNone);
  const Balance before = calc_balance(s.data(), s.state, s.evaluation());
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const Balance after = calc_balance(s.data(), s.state, s.evaluation());
  // Momentum is linear, angular momentum is not: its error is of the method's order, as (w h)² of its size per radian.
  EXPECT_LT(norm(after.momentum - before.momentum), 1e-11);
  EXPECT_LT(norm(after.angular_momentum - before.angular_momentum), 1e-6);
  const Vec3 turning = rotation_matrix(s.state.bodies[0].q) * s.state.bodies[0].w -
                       rotation_matrix(s.state.bodies[1].q) * s.state.bodies[1].w;
  EXPECT_LT(norm(turning), 1e-6);
}

TEST(Compliance, ThePlanDecidesByTheStepAndTheUserOverrules) {
  const SpringPendulum pendulum{.stiffness = 1e4};  // ω is about 170 rad/s
  Model model = build_model(pendulum);
  EXPECT_EQ(Simulation(model, {.dt = 1e-3}).data().joint_springs[0].compliant, kNone);
  EXPECT_NE(Simulation(model, {.dt = 1e-2}).data().joint_springs[0].compliant, kNone);
  model.joint_springs[0].implicit = false;
  EXPECT_EQ(Simulation(model, {.dt = 1e-2}).data().joint_springs[0].compliant, kNone);
  model.joint_springs[0].implicit = true;
  EXPECT_NE(Simulation(model, {.dt = 1e-3}).data().joint_springs[0].compliant, kNone);
}

// h c / (m r²) is 10: an explicit step would be unstable, although the stiffness is small.
TEST(Compliance, AStrongDamperIsImplicitWhateverItsStiffness) {
  SpringPendulum pendulum;
  pendulum.stiffness = 1;
  const double inertia = pendulum.mass * pendulum.arm * pendulum.arm;  // about the hinge, without the body's own
  pendulum.damping = 10 / 1e-3 * inertia;
  const Model model = build_model(pendulum);
  EXPECT_NE(Simulation(model, {.dt = 1e-3}).data().joint_springs[0].compliant, kNone);
  EXPECT_EQ(Simulation(model, {.dt = 1e-6}).data().joint_springs[0].compliant, kNone);
}

TEST(Compliance, ASpringInAJointThatClosesALoopStaysExplicitUnlessDemanded) {
  Model model = build_model(SpringPendulum{.stiffness = 1e9});
  Joint second = model.joints[0];
  second.name = "second";
  model.joints.push_back(second);
  model.joint_springs.push_back(model.joint_springs[0]);
  model.joint_springs[1].name = "other";
  model.joint_springs[1].joint = 1;
  EXPECT_EQ(Simulation(model).data().compliant.size(), 1u);
  model.joint_springs[1].implicit = true;
  const PlanResult result = compile_plan(model, {});
  ASSERT_EQ(result.errors.size(), 1u);
  EXPECT_NE(result.errors[0].what.find("closes a loop"), std::string::npos);
}

TEST(Compliance, AJointWithAStiffSpringIsNotTheOneThatClosesALoop) {
  Model model = build_model(SpringPendulum{.stiffness = 1e9});
  Joint second = model.joints[0];
  second.name = "second";
  model.joints.push_back(second);
  for (const int with : {0, 1}) {
    model.joint_springs[0].joint = with;
    const Simulation s(model);
    EXPECT_EQ(s.data().compliant.size(), 1u);
    EXPECT_EQ(s.list_loops(), std::vector<std::int32_t>{1 - with});
  }
}

// Switched off, the spring has no effect: the step is RK4, bit for bit. A latch becomes rigid in flight: the data that
// a fresh workspace lacks, or an old one has, do not matter.
// had.
TEST(Compliance, ASpringWhoseAxisAModeHoldsIsStillInAnyWorkspace) {
  Model model;
  model.bodies = {box("a", 5, 2, 2.1, 2.2), box("b", 1, 0.1, 0.11, 0.12)};
  model.bodies[1].p_WB = {1, 0.3, 0.2};
  model.bodies[1].q_WB = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized());
  Joint hinge;
  hinge.name = "hinge";
  hinge.base = 0;
  hinge.follower = 1;
  hinge.point_base = model.bodies[1].p_WB;
  hinge.modes = {{"free", kRevoluteRows}, {"locked", kWeldRows}};
  model.joints.push_back(hinge);
  JointSpring spring;
  spring.name = "spring";
  spring.joint = 0;
  spring.axis = kRotZ;
  spring.stiffness = spring.effort = 1e6;
  model.joint_springs.push_back(spring);
  Event lock;
  lock.name = "lock";
  lock.when = when_time(0.00423);
  lock.then.push_back({.kind = Action::Kind::kSetMode, .subject = 0, .mode = 1});
  model.events.push_back(lock);
  Simulation old(model), fresh(model);
  ASSERT_EQ(old.data().compliant.size(), 1u);
  for (int i = 0; i < 7; ++i) ASSERT_EQ(old.advance().status, StepStatus::kOk);
  std::ranges::copy(old.state.get_bytes(), fresh.state.get_bytes().begin());
  std::ranges::fill(fresh.evaluation().blocks, 1e3);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(old.advance().status, StepStatus::kOk);
    ASSERT_EQ(fresh.advance().status, StepStatus::kOk);
    EXPECT_EQ(calc_hash(old.state), calc_hash(fresh.state)) << "tick " << old.state.header->tick;
  }
}

TEST(Compliance, ASpringThatIsOffLeavesTheStepAlone) {
  Model with = build_pendulum(false, 2), without = build_pendulum(false, 2);
  JointSpring spring;
  spring.name = "latch";
  spring.stiffness = 1e9;
  spring.on = false;
  with.joint_springs.push_back(spring);
  Simulation a(with), b(without);
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(a.advance().status, StepStatus::kOk);
    ASSERT_EQ(b.advance().status, StepStatus::kOk);
  }
  for (std::size_t body = 0; body < 2; ++body) {
    EXPECT_EQ(a.state.bodies[body].p.x, b.state.bodies[body].p.x);
    EXPECT_EQ(a.state.bodies[body].w.z, b.state.bodies[body].w.z);
  }
}

}  // namespace
}  // namespace unlatch::test::compliance_test
