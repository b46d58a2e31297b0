// Rigid contacts: random systems, the limit of stiff contacts, what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"
#include "unlatch/energy.h"

namespace unlatch::test::rigid_limits_test {
namespace {

// Stools that fall on tables, rock, slide over edges and rails and fall off. Redundant feet go over edges: their rows
// become independent there, and must not throw them.
TEST(RigidContact, RandomStoolsOnTablesGainNoEnergy) {
  constexpr int kStools = 20, kTicks = 1000;
  int touches = 0;
  for (int seed = 0; seed < kStools; ++seed) {
    std::mt19937_64 random(static_cast<unsigned>(seed));
    const Model model =
        build_random_stool([&] { return std::uniform_real_distribution<>(-1, 1)(random); }, 0.3 * (seed % 3));
    Simulation s(model);
    const auto calc_energy = [&] {
      EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
      double sum = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0}).kinetic;
      for (std::size_t b = 0; b < 2; ++b) sum += model.bodies[b].mass * kGravity * s.state.bodies[b].p.z;
      for (int c = 0; c < 3; ++c) sum += get_contact_totals(s.plan, s.state, c).dissipated;
      return sum;
    };
    const double before = calc_energy();
    int postponed = 0;
    for (int i = 0; i < kTicks; ++i) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk) << "seed " << seed << ", tick " << i << ", contact " << report.contact;
      postponed += report.postponed;
      for (const FiredEvent& fired : report.events) touches += fired.event % 2 == 0 ? 1 : 0;
    }
    // A touch that waits for the next tick goes deeper until then, and is lifted: that is no work of the impulse.
    EXPECT_NEAR(calc_energy(), before, (postponed > 0 ? 2e-3 : 1e-6) * before) << "seed " << seed;
  }
  EXPECT_GT(touches, 300);
}

// Builds three balls in a box of six walls, without gravity; `stiffness` 0: rigid, else with Hertz's law.
Model build_balls_in_a_box(double stiffness) {
  Model model;
  model.name = "balls in a box";
  constexpr double kHalf = 0.3, kBall = 0.1;
  const Eigen::Vector3d places[] = {{-0.15, -0.1, 0.05}, {0.15, -0.12, -0.1}, {0.02, 0.15, 0.1}};
  const Eigen::Vector3d speeds[] = {{3, 1.3, -2}, {-2.2, 2.7, 0.4}, {0.7, -3.1, 1.9}};
  geometry::Shape wall = build_floor();
  std::vector<geometry::Shape> walls;
  for (const Vec3& inwards :
       {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}, Vec3{0, 0, -1}}) {
    wall.normal = inwards;
    wall.from = -kHalf * inwards;
    walls.push_back(wall);
  }
  model.surfaces.push_back({"walls", kGround, walls});
  for (int b = 0; b < 3; ++b) {
    const std::string name = "ball" + std::to_string(b);
    model.bodies.push_back(box(name, 1 + b, 0.004 * (1 + b), 0.004 * (1 + b), 0.004 * (1 + b)));
    model.bodies.back().p_WB = places[b];
    model.bodies.back().v_WB = speeds[b];
    model.surfaces.push_back({name, b, {build_sphere(kBall)}});
  }
  for (int follower = 1; follower <= 3; ++follower)
    for (int base = 0; base < follower; ++base) {
      Contact contact = touch_rigidly("contact" + std::to_string(model.contacts.size()), base, follower, 1);
      if (stiffness > 0) {
        contact.rigid = false;
        contact.restitution.reset();
        contact.stiffness = stiffness;
        contact.exponent = 1.5;
      }
      model.contacts.push_back(contact);
    }
  add_contact_events(model);
  return model;
}

// Flies until so many touches have been; the kinetic energy between them is that of the start, to a part `energy_error`
// of it for each touch, and no ball is deeper in a wall than `deepest`, m.
void expect_touches(double stiffness, int most, double energy_error, double deepest) {
  const Model model = build_balls_in_a_box(stiffness);
  Simulation s(model);
  const auto calc_energy = [&] {
    double sum = 0;
    for (std::size_t b = 0; b < model.bodies.size(); ++b)
      sum += 0.5 * model.bodies[b].mass * dot(s.state.bodies[b].v, s.state.bodies[b].v);
    return sum;
  };
  const double before = calc_energy();
  int touches = 0, postponed = 0;
  for (std::int64_t tick = 0; touches < most; ++tick) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk) << "tick " << tick << ", contact " << report.contact;
    postponed += report.postponed;
    for (const FiredEvent& fired : report.events) touches += fired.event % 2 == 0 ? 1 : 0;
    ASSERT_LT(tick, 100 * most) << "nothing touches any more";
    bool apart = true;
    for (const ContactState& pair : s.state.contacts) apart = apart && pair.closed == 0;
    if (apart) {
      ASSERT_NEAR(calc_energy(), before, energy_error * (touches + 1) * before)
          << "tick " << tick << ", touches " << touches;
    }
    for (const BodyState& ball : s.state.bodies)
      ASSERT_LT(std::max({std::abs(ball.p.x), std::abs(ball.p.y), std::abs(ball.p.z)}), 0.2 + deepest)
          << "tick " << tick;
  }
  EXPECT_EQ(postponed, 0);
}

TEST(RigidContact, TwentyThousandTouchesLeaveNoStepStuck) { expect_touches(0, 20000, 1e-14, 1e-9); }
TEST(LongRigidContact, AHundredThousandTouchesLeaveNoStepStuck) { expect_touches(0, 100000, 1e-14, 1e-9); }

TEST(CompliantContact, TenThousandTouchesLeaveNoStepStuck) { expect_touches(1e7, 10000, 2e-6, 0.02); }
TEST(LongCompliantContact, AHundredThousandTouchesLeaveNoStepStuck) { expect_touches(1e7, 100000, 2e-6, 0.02); }

// The same rod on a floor of the stiffness k: the vibration that it begins with, m g / k, is what it differs by.
TEST(RigidContact, ItIsTheLimitOfStiffContacts) {
  constexpr double kUntil = 0.3;
  const auto fly = [&](const Model& model) {
    Simulation s(model);
    for (int i = 0; i < std::lround(kUntil / 1e-3); ++i) EXPECT_EQ(s.advance().status, StepStatus::kOk);
    return s.state.bodies[0];
  };
  const BodyState limit = fly(build_falling_rod(1.2));
  double errors[3];
  for (int k = 0; k < 3; ++k) {
    Model model = build_falling_rod(1.2);
    model.contacts[0].rigid = false;
    model.contacts[0].restitution.reset();
    model.contacts[0].stiffness = 1e5 * std::pow(10, k);
    const BodyState rod = fly(model);
    errors[k] = norm(rod.p - limit.p);
  }
  EXPECT_LT(errors[2], 1e-6);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log10(errors[k] / errors[k + 1]), 1, 0.3) << errors[k];
}

// Four blows between rails. Each takes half a period, π √(m/k): the difference falls with √k, and goes on to zero.
TEST(RigidContact, BetweenRailsItIsTheLimitOfStiffContacts) {
  const auto fly = [](double stiffness) {
    const Model model = build_rails(stiffness);
    Simulation s(model);
    int touches = 0;
    for (int i = 0; i < 120; ++i) {
      const StepReport report = s.advance();
      EXPECT_EQ(report.status, StepStatus::kOk);
      for (const FiredEvent& fired : report.events) touches += fired.event % 2 == 0 ? 1 : 0;
    }
    EXPECT_EQ(touches, 4) << stiffness;
    return s.state.bodies[0];
  };
  const BodyState rigid = fly(0), soft = fly(1e7), stiff = fly(1e8), stiffest = fly(1e9);
  EXPECT_LT(norm(stiffest.p - rigid.p), 1e-7);
  const double order = std::log10(norm(soft.w - rigid.w) / norm(stiff.w - rigid.w));
  EXPECT_NEAR(order, 0.5, 0.02);
  const double root = std::sqrt(10.0);  // the limit by Richardson's rule, in 1/√k and 1/k
  const auto extrapolate = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto once = [&](const Vec3& one, const Vec3& next) { return (1 / (root - 1)) * (root * next - one); };
    return (1.0 / 9) * (10.0 * once(b, c) - once(a, b));
  };
  EXPECT_LT(norm(extrapolate(soft.w, stiff.w, stiffest.w) - rigid.w), 1e-6);
  EXPECT_LT(norm(extrapolate(soft.p, stiff.p, stiffest.p) - rigid.p), 1e-6);
}

std::string check(const Model& model) {
  std::string all;
  for (const ModelError& error : validate(model)) all += error.where + ": " + error.what + "; " + error.mend + "\n";
  return all;
}

TEST(RigidContact, WhatItCannotHoldIsRefused) {
  EXPECT_EQ(check(build_rigid_feet()), "");
  Model model = build_rigid_feet();
  model.contacts[0].friction = 0.3;
  EXPECT_EQ(check(model), "");
  model.contacts[0].friction = -0.3;
  EXPECT_NE(check(model).find("friction is -0.3; 0 or more"), std::string::npos);
  model = build_rigid_feet();
  model.contacts[0].stiffness = 1e5;
  EXPECT_NE(check(model).find("it is rigid, and has a stiffness"), std::string::npos);
  model = build_rigid_feet();
  model.contacts[0].restitution = 1.5;
  EXPECT_NE(check(model).find("restitution is 1.5; 0 to 1"), std::string::npos);
  model = build_rigid_feet();
  model.contacts[0].settle = 0;
  EXPECT_NE(check(model).find("settle is 0"), std::string::npos);
  model = build_rigid_feet();
  model.bodies[0].p_WB.z() -= 1e-6;
  EXPECT_NE(check(model).find("overlap by"), std::string::npos);
  model = build_rigid_feet();
  model.surfaces[1].shapes[2].kind = geometry::ShapeKind::kBox;
  model.surfaces[1].shapes[2].size = {0.1, 0.1, 0.1};
  EXPECT_NE(check(model).find("is a sphere"), std::string::npos);
  model = build_rigid_feet();
  for (int i = 0; i < 61; ++i) model.surfaces[1].shapes.push_back(build_sphere(0.1, {0, 0, 0}));
  EXPECT_NE(check(model).find("at most 64"), std::string::npos);
  model.surfaces[1].shapes.resize(22);
  EXPECT_EQ(check(model), "");
  model.contacts[0].friction = 0.3;
  EXPECT_NE(check(model).find("any other: 66; at most 64"), std::string::npos);
}

}  // namespace
}  // namespace unlatch::test::rigid_limits_test
