// Parts into which closed contacts cut a step: what they must resolve, against references that share nothing with them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/contact_models.h"
#include "tests/support/simulation.h"

namespace unlatch::test::contact_parts_test {
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

// A bar along x of 1 kg that does not turn, on a rail along y at the origin, both rounded: the nearest point of the bar
// runs off its end.
constexpr double kBarRadius = 1e-3, kBarHalf = 0.1, kBarStiffness = 1e5;  // m, m, N/m
struct Bar {
  double x, z, vx, vz;
};
Bar calc_rates(const Bar& at) {
  const double left = std::max(0.0, at.x - kBarHalf), apart = std::sqrt(left * left + at.z * at.z);
  const double force = kBarStiffness * std::max(0.0, 2 * kBarRadius - apart);
  return {at.vx, at.vz, force * left / apart, force * at.z / apart - kGravity};
}
Bar add(const Bar& at, double h, const Bar& rate) {
  return {at.x + h * rate.x, at.z + h * rate.z, at.vx + h * rate.vx, at.vz + h * rate.vz};
}
// By steps so short that the corner of the force does not count.
Bar slide(Bar at, double duration) {
  constexpr double kStep = 1e-6;
  const int steps = static_cast<int>(std::lround(duration / kStep));
  for (int i = 0; i < steps; ++i) {
    const Bar k1 = calc_rates(at), k2 = calc_rates(add(at, kStep / 2, k1)), k3 = calc_rates(add(at, kStep / 2, k2)),
              k4 = calc_rates(add(at, kStep, k3));
    at = add(add(add(add(at, kStep / 6, k1), kStep / 3, k2), kStep / 3, k3), kStep / 6, k4);
  }
  return at;
}
Model build_bar(double x, double speed) {
  Model model;
  model.name = "bar";
  model.gravity.uniform = {0, 0, -kGravity};
  model.bodies.push_back(box("bar", 1, 1, 1, 1));
  model.bodies[0].p_WB = {x, 0, 2 * kBarRadius - kGravity / kBarStiffness};
  model.bodies[0].v_WB = {speed, 0, 0};
  Joint guide;
  guide.name = "guide";
  guide.follower = 0;
  guide.modes = {{"guided", kRotationRows}};
  model.joints = {guide};
  geometry::Shape rail = build_sphere(kBarRadius, {0, -0.1, 0}), bar = build_sphere(kBarRadius, {-kBarHalf, 0, 0});
  rail.kind = bar.kind = geometry::ShapeKind::kCapsule;
  rail.to = {0, 0.1, 0};
  bar.to = {kBarHalf, 0, 0};
  model.surfaces = {{"rail", kGround, {rail}}, {"bar", 0, {bar}}};
  model.contacts = {touch("bar on rail", 0, 1, kBarStiffness)};
  add_contact_events(model);
  return model;
}

constexpr double kOffTheEnd = 1e-9;  // m and m/s; a part that spans the border of the end is off by up to 2e-7

TEST(Contact, APointThatRunsFromASideOntoARoundedEndIsResolved) {
  constexpr double kStep = 62.5e-6, kDuration = 11.5e-3;
  for (const double x : {0.0902, 0.0906, 0.091}) {
    Simulation s(build_bar(x, 0.9), {.dt = kStep});
    for (int i = 0; i < std::lround(kDuration / kStep); ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    const Bar reference = slide({x, 2 * kBarRadius - kGravity / kBarStiffness, 0.9, 0}, kDuration);
    EXPECT_GT(reference.vx, 0.9) << "it does not get to the end";
    const BodyState& bar = s.state.bodies[0];
    EXPECT_NEAR(bar.p.x, reference.x, kOffTheEnd) << "from " << x;
    EXPECT_NEAR(bar.p.z, reference.z, kOffTheEnd) << "from " << x;
    EXPECT_NEAR(bar.v.x, reference.vx, kOffTheEnd) << "from " << x;
    EXPECT_NEAR(bar.v.z, reference.vz, kOffTheEnd) << "from " << x;
  }
}

}  // namespace
}  // namespace unlatch::test::contact_parts_test
