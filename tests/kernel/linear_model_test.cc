// Linear models: poles and gains against closed forms, and small deviations of whole runs against the integrated model.
#include "unlatch/linear_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "tests/support/linear_algebra.h"
#include "tests/support/mast_model.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::linear_model_test {
namespace {

using Kind = LinearCoordinate::Kind;

LinearModel linearise(Simulation& s, const LinearOutputs& outputs = {}) {
  std::optional<LinearModel> model = calc_linear_model(s.plan, s.state, s.commands, outputs);
  EXPECT_TRUE(model.has_value());
  return model ? *model : LinearModel{};
}

// The largest imaginary part of the poles: the highest frequency of an undamped system, rad/s.
double find_highest_frequency(const LinearModel& model) { return calc_eigenvalues(model.A).imag().maxCoeff(); }

// Central differences of smooth forces of size 1 to 1000 with widths of 1e-3 and 5e-4, extrapolated.
constexpr double kDifferences = 1e-9;

TEST(LinearModel, APendulumAtRestHasItsFrequency) {
  Model model = build_pendulum(true, 0);
  model.gravity.uniform = {9.81, 0, 0};  // along the bar: it hangs
  Simulation s(model);
  const LinearModel linear = linearise(s);
  ASSERT_EQ(linear.coordinates.size(), 1u);
  EXPECT_EQ(linear.coordinates[0].kind, Kind::kJoint);
  EXPECT_EQ(linear.coordinates[0].axis, kRotZ);
  // m g l/2 over the inertia about the hinge, 1/12 + 1/4
  EXPECT_NEAR(linear.A(1, 0), -9.81 * 0.5 / (1.0 / 12 + 0.25), 1e-7 * 14.7);
  EXPECT_NEAR(linear.A(0, 1), 1, 0);
  EXPECT_NEAR(linear.A(1, 1), 0, kDifferences);
  EXPECT_LT(std::abs(linear.accelerations[0]), 1e-12);
}

TEST(LinearModel, AFreeBodyWithAChannelIsADoubleIntegrator) {
  Model model;
  model.name = "free";
  model.bodies.push_back(box("body", 4, 2, 3, 5));
  model.channels.push_back({"thrust", 0, -10, 10, 0, "N"});
  Load load;
  load.name = "thrust";
  load.direction = {0, 1, 0};
  load.point = {0.5, 0, 0};
  load.channel = 0;
  model.loads.push_back(load);
  Simulation s(model);
  const LinearModel linear = linearise(s);
  ASSERT_EQ(linear.coordinates.size(), 6u);
  Eigen::VectorXd gain = Eigen::VectorXd::Zero(12);
  gain[7] = 1.0 / 4;
  gain[11] = 0.5 / 5;
  EXPECT_LT((linear.B.col(0) - gain).cwiseAbs().maxCoeff(), kDifferences);
  EXPECT_LT(linear.A.bottomRows(6).cwiseAbs().maxCoeff(), kDifferences);
  EXPECT_TRUE(linear.A.topRightCorner(6, 6).isIdentity(0));
}

// A hub of mass M in space with a flexible part of mass m, frequency ω and modal momentum S along y: with nothing that
// holds the hub, ω² / (1 − S²/(M + m)).
TEST(LinearModel, AFlexibleAppendageOnAFreeHubIsFasterThanHeld) {
  constexpr double kHub = 30, kPart = 10, kOmega = 7, kMomentum = 2.5;
  Model model;
  model.name = "appendage";
  model.bodies.push_back(box("hub", kHub, 1e3, 1e3, 1e3));
  Body part = box("part", kPart, 1, 1, 1);
  FlexibleBody shape;
  shape.frequencies = Eigen::VectorXd::Constant(1, kOmega);
  shape.damping = Eigen::VectorXd::Zero(1);
  shape.momentum = Eigen::Vector3d(0, kMomentum, 0);
  shape.first = {Eigen::Matrix3d::Zero()};
  shape.second = {Eigen::Vector3d(0, 1, 0).asDiagonal()};
  part.flexible = shape;
  model.bodies.push_back(part);
  Body root;
  root.name = "root";
  root.marker = Marker{1, {0, 0, 0}, Eigen::Matrix3Xd::Zero(3, 1), Eigen::Matrix3Xd::Zero(3, 1)};
  model.bodies.push_back(root);
  Joint weld;
  weld.name = "weld";
  weld.base = 0;
  weld.follower = 2;
  weld.modes = {{"held", kWeldRows}};
  model.joints.push_back(weld);
  Simulation s(place_markers(model));
  const LinearModel linear = linearise(s);
  ASSERT_EQ(linear.coordinates.size(), 7u);
  EXPECT_NEAR(find_highest_frequency(linear), kOmega / std::sqrt(1 - kMomentum * kMomentum / (kHub + kPart)), 1e-7);
}

TEST(LinearModel, AMastWithRedundantRowsHasTwoFreedoms) {
  Simulation s(build_mast(5));
  const LinearModel linear = linearise(s);
  // a unit's angle, and the turn of the whole mast about its hinge on the ground
  EXPECT_EQ(linear.coordinates.size(), 2u);
}

// Its force ends where its length is the free one.
TEST(LinearModel, APusherAtItsEndIsACorner) {
  Model model;
  model.name = "pusher";
  model.bodies.push_back(box("body", 1, 1, 1, 1));
  Joint rail;
  rail.name = "rail";
  rail.modes = {{"held", static_cast<RowSet>(kWeldRows & ~row_bit(kX))}};
  model.joints.push_back(rail);
  PointSpring pusher;
  pusher.name = "pusher";
  pusher.follower = 0;
  pusher.point_base = {-1, 0, 0};
  pusher.stiffness = 100;
  pusher.free_length = 1;
  pusher.push_only = true;
  model.point_springs.push_back(pusher);
  Simulation s(model);
  const LinearModel linear = linearise(s);
  ASSERT_EQ(linear.coordinates.size(), 1u);
  EXPECT_EQ(linear.corners, std::vector<int>{0});
}

// A tumbling body with an arm on a ball joint and a flap on a universal joint behind it, springs and commanded torques:
// all kinds of coordinates, none at rest.
Model build_tumbling(Random& random) {
  Model model;
  model.name = "tumbling";
  const auto vector = [&](double size) {
    return Eigen::Vector3d(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size));
  };
  const Eigen::Vector3d w = vector(0.5), v = vector(0.3);
  const double mass[] = {20, 6, 3};
  const Eigen::Vector3d place[] = {{0, 0, 0}, {1.5, 0, 0}, {2.5, 0.5, 0}};
  const char* const names[] = {"bus", "arm", "flap"};
  for (int b = 0; b < 3; ++b) {
    Body body = box(names[b], mass[b], mass[b] * 0.3, mass[b] * 0.4, mass[b] * 0.5);
    body.p_WB = place[b];
    body.v_WB = v + w.cross(place[b]);
    body.w_WB_B = w;
    model.bodies.push_back(body);
  }
  // the arm and the flap turn about their joints too
  const Eigen::Vector3d arm = vector(0.4), joint1(1, 0, 0), joint2(2, 0, 0);
  model.bodies[1].w_WB_B += arm;
  model.bodies[1].v_WB += arm.cross(place[1] - joint1);
  const Eigen::Vector3d flap = Eigen::Vector3d(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0);
  model.bodies[2].w_WB_B += arm + flap;
  model.bodies[2].v_WB += arm.cross(joint2 - joint1) + (arm + flap).cross(place[2] - joint2);
  const auto add = [&](const char* name, int base, RowSet rows, bool universal, const Eigen::Vector3d& point) {
    Joint joint;
    joint.name = name;
    joint.base = base;
    joint.follower = base + 1;
    joint.point_base = point - place[base];
    joint.point_follower = point - place[base + 1];
    joint.universal = universal;
    joint.modes = {{"held", rows}};
    model.joints.push_back(joint);
  };
  add("ball", 0, kPointRows, false, joint1);
  add("cross", 1, kPointRows | row_bit(kRotZ), true, joint2);
  const auto spring = [&](const char* name, int joint, int axis) {
    JointSpring own;
    own.name = name;
    own.joint = joint;
    own.axis = axis;
    own.stiffness = random.uniform(5, 20);
    own.damping = random.uniform(0.1, 1);
    model.joint_springs.push_back(own);
  };
  spring("bend", 1, kRotX);
  spring("flap", 1, kRotY);
  PointSpring line;
  line.name = "line";
  line.base = 0;
  line.follower = 2;
  line.point_base = {0, 0.7, 0.2};
  line.point_follower = {0.1, 0, 0.3};
  line.stiffness = 40;
  line.damping = 2;
  line.free_length = 1;
  model.point_springs.push_back(line);
  for (const char* const name : {"roll", "yaw"}) {
    Load load;
    load.name = name;
    load.kind = Load::Kind::kTorque;
    load.body = name[0] == 'r' ? 0 : 2;
    load.direction = name[0] == 'r' ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(0, 0.6, 0.8);
    load.channel = static_cast<int>(model.channels.size());
    model.channels.push_back({name, 0.5, -10, 10, 0, "N m"});
    model.loads.push_back(load);
  }
  for (const auto kind : {Quantity::Kind::kRate, Quantity::Kind::kPosition})
    for (int i = 0; i < 3; ++i) {
      Quantity own;
      own.name = (kind == Quantity::Kind::kRate ? "rate" : "position") + std::to_string(i);
      own.kind = kind;
      own.subject = 2;
      own.direction = Eigen::Vector3d::Unit(i);
      model.quantities.push_back(own);
    }
  return model;
}

// Deviations of a run from another one with slightly other commands, against dx/dt = A x + B c integrated along the
// run: a hundred linear models of one motion.
TEST(LinearModel, DeviationsOfRunsFollowIt) {
  constexpr unsigned kSeed = 20261;
  constexpr double kDeviation = 1e-6;  // N m: differences of runs lose 1e-16/1e-6 of 1, and are nonlinear by 1e-6
  constexpr double kTolerance = 3e-5;  // beside the largest: rounding, nonlinearity, the trapezoidal rule with 1 ms
  Random random(kSeed);
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  const Model model = build_tumbling(random);
  Simulation run(model), other(model);
  other.commands[0] += kDeviation;
  other.commands[1] -= 2 * kDeviation;
  const Eigen::Vector2d c(1, -2);
  LinearOutputs outputs;
  for (int i = 0; i < 6; ++i) outputs.quantities.push_back(i);

  LinearModel before = linearise(run, outputs);
  ASSERT_EQ(before.coordinates.size(), 11u);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(22);
  const double h = run.plan.get_options().dt;
  for (int k = 0; k < 100; ++k) {
    ASSERT_EQ(run.advance().status, StepStatus::kOk);
    ASSERT_EQ(other.advance().status, StepStatus::kOk);
    const LinearModel after = linearise(run, outputs);
    const Eigen::MatrixXd A = 0.5 * h * (before.A + after.A);
    const Eigen::VectorXd b = 0.5 * h * (before.B + after.B) * c;
    // the exponential to its third order, with the mean of both ends
    const Eigen::VectorXd first = A * x + b, second = A * first, third = A * second;
    x += first + second / 2 + third / 6;
    before = after;
  }
  const Eigen::VectorXd linear = before.C * x + before.D * c;
  Eigen::VectorXd truth(6);
  ASSERT_EQ(update_outputs(run.plan, {run.commands}, run.state, run.workspace), StepStatus::kOk);
  ASSERT_EQ(update_outputs(other.plan, {other.commands}, other.state, other.workspace), StepStatus::kOk);
  for (int i = 0; i < 6; ++i)
    truth[i] = (other.workspace.quantities[at(i)] - run.workspace.quantities[at(i)]) / kDeviation;
  EXPECT_LT((linear - truth).head(3).norm(), kTolerance * truth.head(3).norm()) << linear << "\n\n" << truth;
  EXPECT_LT((linear - truth).tail(3).norm(), kTolerance * truth.tail(3).norm()) << linear << "\n\n" << truth;
}

}  // namespace
}  // namespace unlatch::test::linear_model_test
