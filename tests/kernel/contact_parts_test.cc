// Parts into which closed contacts cut a step: what they must resolve, against references that share nothing with them.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/contact_models.h"
#include "tests/support/simulation.h"

namespace unlatch::test {
namespace {

// Place and speed of a point that is thrown up an incline: x'' = g_x − μ g_z x'/√(x'² + v_s²), by steps of 1/50 of the
// time in which the law's bend is passed.
struct Thrown {
  double x = 0, v = 0;
};
Thrown throw_up(double v, double along, double friction, double slip_speed, double duration) {
  const auto calc = [&](double u) { return along - friction * u / std::sqrt(u * u + slip_speed * slip_speed); };
  const int steps = static_cast<int>(std::ceil(duration * (std::abs(along) + friction) / slip_speed * 50));
  const double h = duration / steps;
  Thrown at{0, v};
  for (int i = 0; i < steps; ++i) {
    const double k1 = calc(at.v), k2 = calc(at.v + 0.5 * h * k1), k3 = calc(at.v + 0.5 * h * k2),
                 k4 = calc(at.v + h * k3);
    at.x += h * at.v + h * h / 6 * (k1 + k2 + k3);
    at.v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return at;
}

constexpr double kReversed = 5e-8;  // m and m/s; a part that spans the reversal is off by up to 1e-4

TEST(Contact, FrictionThatReversesWithinAStepIsResolved) {
  constexpr double kStiffness = 5e7, kMass = 500, kFriction = 0.3, kSlope = 0.6, kSlipSpeed = 3e-4;
  for (const double speed : {-0.5, -0.503, -0.506, -0.5093}) {
    Model model = build_dropped_ball(0);
    model.gravity.uniform = {kGravity * kSlope, 0, -kGravity};
    model.bodies[0] = box("block", kMass, 20, 20, 20);
    model.bodies[0].p_WB = {0, 0, kBallRadius - kGravity * kMass / kStiffness};
    model.bodies[0].v_WB = {speed, 0, 0};
    Joint guide;
    guide.name = "guide";
    guide.follower = 0;
    guide.modes = {{"guided", kRotationRows}};
    model.joints = {guide};
    model.contacts[0].stiffness = kStiffness;
    model.contacts[0].damping = 0.4;
    model.contacts[0].friction = kFriction;
    model.contacts[0].slip_speed = kSlipSpeed;
    Simulation s(model);
    for (int i = 0; i < 400; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    const Thrown reference = throw_up(speed, kGravity * kSlope, kFriction * kGravity, kSlipSpeed, 0.4);
    EXPECT_GT(reference.v, 0.5) << "it does not reverse";
    EXPECT_NEAR(s.state.bodies[0].p.x, reference.x, kReversed) << "thrown with " << speed;
    EXPECT_NEAR(s.state.bodies[0].v.x, reference.v, kReversed) << "thrown with " << speed;
  }
}

}  // namespace
}  // namespace unlatch::test
