// Mechanisms with published motions.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernel/joints/residuals.h"
#include "tests/support/linkages.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::mechanisms_test {
namespace {

using Eigen::Vector3d;

// Andrews' squeezing mechanism: seven bodies in a plane, a motor, a spring, three loops. Giles 1978; Manning 1981;
// Hairer and Wanner, Solving Ordinary Differential Equations II, VII.7; test set for IVP solvers (Bari, Amsterdam),
// problem "andrews", whose constants, start and solution at 0.03 s these are. tests/references/andrews.py integrates
// its planar equations and finds the same solution to 1.4e-9 rad and 5.4e-7 rad/s.
//
// m, kg, kg m², N/m, N m. Names as published: lengths of a body and its centre of mass (a) along it.
namespace andrews {
constexpr double kMass[] = {0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498};
constexpr double kInertia[] = {2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5};
constexpr double rr = 0.007, ra = 0.00092, d = 0.028, da = 0.0115, sa = 0.01874, sb = 0.01043, sc = 0.018, sd = 0.02,
                 e = 0.02, ea = 0.01421, zf = 0.02, fa = 0.01421, zt = 0.04, ta = 0.02308, tb = 0.00916, u = 0.04,
                 ua = 0.01228, ub = 0.00449;
constexpr double kSpring = 4530, kFreeLength = 0.07785, kTorque = 0.033;
const Vector3d kA(-0.06934, -0.00227, 0), kB(-0.03635, 0.03273, 0), kC(0.014, 0.072, 0);

struct Angles {
  double beta, theta, gamma, phi, delta, omega, epsilon;  // rad; theta, phi and omega against the neighbour
};
constexpr Angles kStart = {
    -0.0617138900142764496, 0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550, -0.222668390165885885,
    1.23054744454982119};
constexpr Angles kEnd = {15.81077119629904,  -15.75637105984298, 0.04082224013073101, -0.5347301163226948,
                         0.5244099658805304, 0.5347301163226948, 1.048080741042263};
constexpr Angles kEndSpeeds = {1139.920302151208,  -1424.379294994111, 11.03291221937134, 19.29337464421385,
                               0.5735699284790808, -19.29337464421385, 0.3231791658026955};

// Attitude angles of the bodies K1 … K7 in space.
std::vector<double> calc_headings(const Angles& a) {
  return {a.beta, a.beta + a.theta, a.gamma, a.phi + a.delta, a.delta, a.omega + a.epsilon, a.epsilon};
}

Vector3d along(double angle) { return {std::cos(angle), std::sin(angle), 0}; }
Vector3d across(double angle) { return {std::sin(angle), -std::cos(angle), 0}; }

Model build() {
  const std::vector<double> heading = calc_headings(kStart);
  const Vector3d crank = rr * along(heading[0]), tip = crank - d * along(heading[1]);
  const Vector3d upper = kA + zt * along(heading[4]), lower = kA + u * across(heading[6]);
  const Vector3d centres[] = {
      ra * along(heading[0]),
      crank - da * along(heading[1]),
      kB + sa * across(heading[2]) + sb * along(heading[2]),
      upper + (e - ea) * across(heading[3]),
      kA + ta * across(heading[4]) + tb * along(heading[4]),
      lower + (zf - fa) * along(heading[5]),
      kA + ua * across(heading[6]) - ub * along(heading[6]),
  };
  Model model;
  model.name = "andrews";
  for (std::size_t k = 0; k < 7; ++k) {
    // Only the moment about z has an effect in the plane.
    Body body = box("K" + std::to_string(k + 1), kMass[k], 0.6 * kInertia[k], 0.6 * kInertia[k], kInertia[k]);
    body.p_WB = centres[k];
    body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(heading[k], Vector3d::UnitZ()));
    model.bodies.push_back(body);
  }
  const auto hinge = [&](int base, int follower, const Vector3d& point) {
    model.joints.push_back(build_hinge(model, base, follower, point, Vector3d::UnitZ()));
  };
  hinge(kGround, 0, Vector3d::Zero());
  hinge(0, 1, crank);
  hinge(1, 2, tip);
  hinge(1, 3, tip);
  hinge(1, 5, tip);
  hinge(3, 4, upper);
  hinge(5, 6, lower);
  hinge(kGround, 2, kB);
  hinge(kGround, 4, kA);
  hinge(kGround, 6, kA);

  PointSpring spring;
  spring.name = "spring";
  spring.point_base = kC;
  spring.follower = 2;
  const Vector3d end = kB + sc * across(heading[2]) + sd * along(heading[2]);
  spring.point_follower = model.bodies[2].q_WB.conjugate() * (end - model.bodies[2].p_WB);
  spring.stiffness = kSpring;
  spring.free_length = kFreeLength;
  model.point_springs.push_back(spring);

  Load motor;
  motor.name = "motor";
  motor.kind = Load::Kind::kTorque;
  motor.direction = {0, 0, kTorque};
  model.loads.push_back(motor);
  return model;
}
}  // namespace andrews

struct AndrewsError {
  double angle = 0, speed = 0;  // rad, rad/s
};

AndrewsError run_andrews(double dt) {
  PlanOptions options;
  options.dt = dt;
  Simulation s(andrews::build(), options);
  const long ticks = std::lround(0.03 / dt);
  double drift = 0;
  for (long i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    EXPECT_EQ(report.status, StepStatus::kOk) << "tick " << i;
    EXPECT_EQ(report.redundant, 9) << "tick " << i;  // three loops, each with three rows out of the plane too many
    if (report.status != StepStatus::kOk) break;
    drift = std::max(drift, calc_drift(s.data(), s.state, s.evaluation()));
  }
  EXPECT_LT(drift, 1e-10);  // m, rad
  AndrewsError error;
  const std::vector<double> angles = andrews::calc_headings(andrews::kEnd);
  const std::vector<double> speeds = andrews::calc_headings(andrews::kEndSpeeds);
  for (std::size_t k = 0; k < 7; ++k) {
    const BodyState& body = s.state.bodies[k];
    const double heading = 2 * std::atan2(body.q.z, body.q.w);
    error.angle = std::max(error.angle, std::abs(std::remainder(heading - angles[k], 2 * M_PI)));
    error.speed = std::max(error.speed, std::abs(body.w.z - speeds[k]));
  }
  return error;
}

// The crank ends at 1140 rad/s; at 25 µs it turns by 0.03 rad a step.
TEST(Mechanisms, AndrewsSqueezerGoesWhereItIsPublishedToGo) {
  constexpr double kAngle = 1e-7, kSpeed = 1e-4;  // rad, rad/s of 1140, at 25 µs
  const AndrewsError coarse = run_andrews(1e-4), fine = run_andrews(2.5e-5);
  std::printf("Andrews' squeezer at 0.03 s: %.1e rad, %.1e rad/s at 100 us; %.1e rad, %.1e rad/s at 25 us\n",
              coarse.angle, coarse.speed, fine.angle, fine.speed);
  EXPECT_LT(fine.angle, kAngle);
  EXPECT_LT(fine.speed, kSpeed);
  EXPECT_GT(coarse.angle / fine.angle, 50);  // order four: 256 in the limit, until the published digits end
}

}  // namespace
}  // namespace unlatch::test::mechanisms_test
