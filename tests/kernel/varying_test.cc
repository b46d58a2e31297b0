// Bodies whose mass, centre of mass and inertia follow a law.
#include <gtest/gtest.h>

#include <cmath>

#include "kernel/dynamics/balance.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::varying_test {
namespace {

using Eigen::Vector3d;

MassLaw build_law(MassLaw::Of of, std::vector<MassLaw::Knot> knots) {
  MassLaw law;
  law.of = of;
  law.knots = std::move(knots);
  return law;
}

Load build_thrust(int body, const Vector3d& force, const Vector3d& point) {
  Load load;
  load.name = "thrust";
  load.body = body;
  load.direction = force;
  load.point = point;
  return load;
}

// A pendulum of two bars under gravity and a thrust, the second bar with its origin `shift` from its centre of mass.
Model build_shifted(const Vector3d& shift) {
  Model model = build_pendulum(false, 1.5);
  model.gravity.uniform = {0, -9.81, 0.3};
  Body& bar = model.bodies[1];
  bar.w_WB_B = {0, 0, 1.5};
  if (!shift.isZero(0)) {
    bar.law = build_law(MassLaw::Of::kTime, {{0, bar.mass, -shift, bar.inertia}});
    bar.p_WB += shift;
    bar.v_WB += bar.w_WB_B.cross(shift);
    model.joints[0].point_follower -= shift;
  }
  model.loads.push_back(build_thrust(1, {0.3, 2, -0.4}, Vector3d(0.2, 0.1, 0) - shift));
  return model;
}

TEST(Varying, AnOriginBesideTheCentreOfMassIsTheSameMotion) {
  const Vector3d shift(0.3, -0.2, 0.15);
  Simulation plain(build_shifted({0, 0, 0})), shifted(build_shifted(shift));
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(plain.advance().status, StepStatus::kOk);
    ASSERT_EQ(shifted.advance().status, StepStatus::kOk);
  }
  constexpr double kAgree = 1e-11;  // RK4 of one motion in two sets of coordinates: its error is far below 1e-11 here
  const auto& a = plain.state.bodies[1];
  const auto& b = shifted.state.bodies[1];
  const Vec3 centre = b.p - rotation_matrix(b.q) * Vec3{shift.x(), shift.y(), shift.z()};
  EXPECT_LT(norm(a.p - centre), kAgree);
  EXPECT_LT(norm(a.w - b.w), kAgree);
  const Balance x = calc_balance(plain.data(), plain.state, plain.evaluation());
  const Balance y = calc_balance(shifted.data(), shifted.state, shifted.evaluation());
  EXPECT_NEAR(x.kinetic, y.kinetic, kAgree * x.kinetic);
  EXPECT_LT(norm(x.angular_momentum - y.angular_momentum), kAgree * norm(x.angular_momentum));
  for (std::size_t r = 0; r < kRows; ++r)
    EXPECT_NEAR(plain.workspace.multipliers[r], shifted.workspace.multipliers[r], 1e-9);
}

TEST(Varying, ARocketGainsWhatTsiolkovskySays) {
  constexpr double kThrust = 3000, kExhaust = 2500, kStart = 120, kEnd = 60;  // N, m/s, kg
  Model model;
  Body rocket = box("rocket", kStart, 10, 20, 20);
  const Eigen::Matrix3d J = rocket.inertia;
  rocket.law = build_law(MassLaw::Of::kBurnt, {{0, kStart, {0, 0, 0}, J}, {60, kEnd, {0, 0, 0}, 0.5 * J}});
  model.bodies.push_back(rocket);
  Load load = build_thrust(0, {1, 0, 0}, {0, 0, 0});
  load.profile.value = kThrust;
  load.consumption = 1 / kExhaust;
  model.loads.push_back(load);
  Event burnout;
  burnout.name = "burnout";
  burnout.when = when(Condition::Kind::kBurnt, 0, 0, kStart - kEnd);
  burnout.then.push_back({});
  burnout.then[0].kind = Action::Kind::kSwitch;
  model.events.push_back(burnout);
  Simulation s(model, {.dt = 0.01});
  double fired = 0;
  while (s.get_time() < 60) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& event : report.events) fired = event.time;
  }
  EXPECT_NEAR(fired, (kStart - kEnd) * kExhaust / kThrust, 1e-9);
  EXPECT_NEAR(s.state.auxiliary[0], kStart - kEnd, 1e-9);
  EXPECT_NEAR(s.state.bodies[0].v.x, kExhaust * std::log(kStart / kEnd), 1e-8);
}

// J' = −j, m' = −μ, the exit at l from the centre of mass across the axis: J w' = (j − μ l²) w.
TEST(Varying, JetDampingSlowsASpin) {
  constexpr double kInertia = 20, kSlope = 3, kFlow = 5, kArm = 1.5, kSpin = 0.8, kTime = 2;
  Model model;
  Body body = box("body", 100, kInertia, kInertia, kInertia);
  body.w_WB_B = {0, 0, kSpin};
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  body.law = build_law(MassLaw::Of::kTime, {{0, 100, {0, 0, 0}, kInertia * one},
                                            {4, 100 - 4 * kFlow, {0, 0, 0}, (kInertia - 4 * kSlope) * one}});
  body.law->exit = {kArm, 0, 0};
  for (const bool damping : {false, true}) {
    body.law->jet_damping = damping;
    model.bodies = {body};
    Simulation s(model);
    while (s.get_time() < kTime) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    const double power = (kFlow * kArm * kArm - kSlope) / kSlope;
    const double expected = damping ? kSpin * std::pow(1 - kSlope * kTime / kInertia, power) : kSpin;
    EXPECT_NEAR(s.state.bodies[0].w.z, expected, 1e-9) << damping;
  }
}

// The flow ends at a knot on a tick, before the end: the damping torque jumps there, and no stage of a step may take it
// from the other side. w = w0 (1 − j t/J)^power up to the knot, constant after it.
TEST(Varying, AKnotOnATickLeavesTheOrderOfTheStep) {
  constexpr double kInertia = 20, kSlope = 3, kFlow = 5, kArm = 1.5, kSpin = 0.8, kEnd = 1.2;
  Model model;
  Body body = box("body", 100, kInertia, kInertia, kInertia);
  body.w_WB_B = {0, 0, kSpin};
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const auto knot = [&](double t) {
    return MassLaw::Knot{t, 100 - t * kFlow, {0, 0, 0}, (kInertia - t * kSlope) * one};
  };
  body.law = build_law(MassLaw::Of::kTime, {knot(0), knot(kEnd)});
  body.law->exit = {kArm, 0, 0};
  body.law->jet_damping = true;
  model.bodies = {body};
  const double power = (kFlow * kArm * kArm - kSlope) / kSlope;
  const double expected = kSpin * std::pow(1 - kSlope * kEnd / kInertia, power);
  for (const double dt : {0.1, 0.01, 0.001}) {
    Simulation s(model, {.dt = dt});
    while (s.get_time() < kEnd + 0.5) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_NEAR(s.state.bodies[0].w.z, expected, 1e-4 * std::pow(dt, 4) + 1e-13) << dt;
  }
}

// Knots of what is burnt, wherever they lie in a step: speed and spin follow from what is burnt alone, b, in each piece
// by dv/db = c / m and J dw/db = (j - μ l²) w with the slopes -μ of the mass and -j of the inertia. The thrust changes,
// so that no knot is where the flow of the beginning of a step would be at it.
TEST(Varying, KnotsOfWhatIsBurntLeaveTheOrderOfTheStep) {
  constexpr double kExhaust = 40, kArm = 0.7, kSpin = 0.8;
  struct Row {
    double at, mass, inertia;
  };
  constexpr Row kRows[] = {{0, 20, 9}, {1.31, 18, 8.5}, {2.47, 17.5, 6}, {5.03, 12, 4}};
  for (const bool damping : {false, true}) {
    Model model;
    Body body = box("body", 20, 9, 9, 9);
    body.w_WB_B = {kSpin, 0, 0};
    std::vector<MassLaw::Knot> knots;
    for (const Row& row : kRows)
      knots.push_back({row.at, row.mass, {0, 0, 0}, row.inertia * Eigen::Matrix3d::Identity()});
    body.law = build_law(MassLaw::Of::kBurnt, knots);
    body.law->exit = {0, kArm, 0};
    body.law->jet_damping = damping;
    model.bodies = {body};
    Load load = build_thrust(0, {1, 0, 0}, {0, 0, 0});
    load.profile.kind = Profile::Kind::kExponential;
    load.profile.initial = 40;
    load.profile.final = 160;
    load.profile.tau = 1.5;
    load.consumption = 1 / kExhaust;
    model.loads = {load};
    double errors[3];
    for (int i = 0; i < 3; ++i) {
      Simulation s(model, {.dt = 0.1 / (1 << i)});
      while (s.get_time() < 2.3) ASSERT_EQ(s.advance().status, StepStatus::kOk);
      double v = 0, w = kSpin;
      const double burnt = s.state.auxiliary[0];
      ASSERT_GT(burnt, kRows[3].at);
      for (int k = 0; k < 3; ++k) {
        const double width = kRows[k + 1].at - kRows[k].at, flow = (kRows[k].mass - kRows[k + 1].mass) / width,
                     slope = (kRows[k].inertia - kRows[k + 1].inertia) / width;
        v += kExhaust / flow * std::log(kRows[k].mass / kRows[k + 1].mass);
        if (damping) w *= std::pow(kRows[k + 1].inertia / kRows[k].inertia, (flow * kArm * kArm - slope) / slope);
      }
      v += kExhaust / kRows[3].mass * (burnt - kRows[3].at);
      const auto& found = s.state.bodies[0];
      errors[i] = std::max(std::abs(found.v.x - v), std::abs(found.w.x - w));
    }
    EXPECT_GT(errors[0], 11 * errors[1]) << damping;
    EXPECT_GT(errors[1], 11 * errors[2]) << damping;
    EXPECT_LT(errors[2], 1e-8) << damping;
  }
}

TEST(Varying, AMistakenLawIsNamed) {
  Model model = build_shifted({0.1, 0, 0});
  model.bodies[1].law->knots.push_back({-1, -2, {0, 0, 0}, Eigen::Matrix3d::Identity()});
  model.loads[0].body = 0;
  model.loads[0].consumption = 1e-3;
  std::string all;
  for (const ModelError& error : validate(model)) all += error.where + ": " + error.what + "\n";
  EXPECT_NE(all.find("body 'bar': its mass becomes -2 kg"), std::string::npos) << all;
  EXPECT_NE(all.find("knots do not increase"), std::string::npos) << all;
  EXPECT_NE(all.find("element 'thrust': it consumes propellant of a body that has no mass law"), std::string::npos)
      << all;
}

}  // namespace
}  // namespace unlatch::test::varying_test
