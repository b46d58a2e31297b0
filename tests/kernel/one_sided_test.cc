// Pushers, stops, cords, friction in joints and impulses, against closed forms and a separate integration.
#include <gtest/gtest.h>

#include <cmath>

#include "kernel/dynamics/balance.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/elementary.h"
#include "unlatch/energy.h"
#include "unlatch/readings.h"

namespace unlatch::test::one_sided_test {
namespace {

constexpr double kIntegrator = 1e-9;  // relative error of RK4 at 1 ms over the times of these tests
constexpr double kLocated = 1e-8;     // s, instants: two iterations at 1 ms
constexpr double kSpeed = 1e-7;       // m/s, effect of a force of some 100 N on some kg during a part of that
constexpr double kEnergy = 1e-6;      // J, likewise
constexpr RowSet kSlideX = static_cast<RowSet>(kWeldRows & ~row_bit(kX));

// Two bodies of 3 kg and 2 kg in line along x, their points 0.2 m apart, at rest.
Model build_line() {
  Model model;
  model.bodies = {box("a", 3, 1, 1, 1), box("b", 2, 1, 1, 1)};
  model.bodies[1].p_WB = {0.2, 0, 0};
  return model;
}
constexpr double kReduced = 3.0 * 2.0 / 5.0;

OneSided between(OneSided::Kind kind) {
  OneSided f;
  f.name = "f";
  f.kind = kind;
  f.base = 0;
  f.follower = 1;
  return f;
}

OneSided push(double preload, double stroke) {
  OneSided f = between(OneSided::Kind::kPusher);
  f.preload = preload;
  f.stroke = stroke;
  return f;
}

struct Seen {
  std::vector<std::pair<std::string, double>> events;  // name, time
  double unexplained = 0;                              // largest |d(T + U) − ∫ P dt| without resistance, J
  std::vector<EventAudit> audits;
};

// Runs a model; returns the events and, for a model without resistance, energies at each tick.
Seen run(Simulation& s, const Model& model, int ticks) {
  const Model whole = complete_events(model);
  Seen seen;
  double start = 0;
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    EXPECT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& e : report.events)
      seen.events.emplace_back(whole.events[static_cast<std::size_t>(e.event)].name, e.time);
    seen.audits.insert(seen.audits.end(), report.audits.begin(), report.audits.end());
    const EnergyFlow flow = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
    if (i == 0) start = flow.kinetic + flow.strain;
    seen.unexplained = std::max(seen.unexplained, std::abs(flow.kinetic + flow.strain - start));
  }
  return seen;
}

double get_speed(const Simulation& s) { return s.state.bodies[1].v.x - s.state.bodies[0].v.x; }

// --- Pushers ---------------------------------------------------------------------------------------------------------

TEST(OneSided, APusherGivesItsWorkAndEndsWithItsStroke) {
  Model model = build_line();
  OneSided f = push(100, 0.05);
  f.stiffness = 1000;
  model.one_sided = {f};
  Simulation s(model);
  const Seen seen = run(s, model, 300);
  const double work = 100 * 0.05 - 0.5 * 1000 * 0.05 * 0.05, w = std::sqrt(1000 / kReduced);
  EXPECT_NEAR(get_speed(s), std::sqrt(2 * work / kReduced), kSpeed);
  // u = P/k (1 − cos wt) reaches the stroke.
  ASSERT_EQ(seen.events.size(), 1u);
  EXPECT_EQ(seen.events[0].first, "stroke_end");
  EXPECT_NEAR(seen.events[0].second, std::acos(1 - 0.05 * 1000 / 100) / w, kLocated);
  EXPECT_LT(seen.unexplained, kEnergy);
  EXPECT_NEAR(3 * s.state.bodies[0].v.x + 2 * s.state.bodies[1].v.x, 0, 1e-14);
  const double after = get_speed(s);
  run(s, model, 100);
  EXPECT_EQ(get_speed(s), after) << "it acts beyond its stroke";
}

TEST(OneSided, APusherReturnsWhenItsBodiesDo) {
  Model model = build_line();
  model.one_sided = {push(100, 0.05)};
  model.bodies[1].p_WB = {0.3, 0, 0};
  model.one_sided[0].limit = 0.25;
  model.bodies[1].v_WB = {-1, 0, 0};
  Simulation s(model);
  const Seen seen = run(s, model, 400);
  ASSERT_EQ(seen.events.size(), 2u);
  EXPECT_EQ(seen.events[0].first, "touch");
  EXPECT_NEAR(seen.events[0].second, 0.05, kLocated);
  EXPECT_NEAR(seen.events[1].second, 0.05 + 2 * 1 * kReduced / 100, kLocated);
  EXPECT_NEAR(get_speed(s), 1, kIntegrator);
}

TEST(OneSided, GasExpandsByItsLaw) {
  for (const double exponent : {1.0, 1.4}) {
    Model model = build_line();
    OneSided f = push(400, 0.06);
    f.law = OneSided::Law::kGas;
    f.gas_length = 0.03;
    f.exponent = exponent;
    model.one_sided = {f};
    Simulation s(model);
    const Seen seen = run(s, model, 200);
    const double work = exponent == 1 ? 400 * 0.03 * std::log(3.0) : 400 * 0.03 / 0.4 * (1 - std::pow(1 / 3.0, 0.4));
    EXPECT_NEAR(get_speed(s), std::sqrt(2 * work / kReduced), 5 * kSpeed) << exponent;  // 400 N
    EXPECT_LT(seen.unexplained, 10 * kEnergy);
    ASSERT_EQ(seen.events.size(), 1u);
  }
}

TEST(OneSided, ATableGivesTheAreaUnderIt) {
  Model model = build_line();
  OneSided f = push(0, 0.05);
  f.law = OneSided::Law::kTable;
  f.travels = {0, 0.02, 0.04};
  f.forces = {50, 120, 30};
  model.one_sided = {f};
  Simulation s(model);
  run(s, model, 300);
  const double work = 85 * 0.02 + 75 * 0.02 + 30 * 0.01;
  EXPECT_NEAR(get_speed(s), std::sqrt(2 * work / kReduced), kSpeed) << "a step saw a corner of the table";
}

// 100 N that fall to 0 at 29.4 mm of 38.22 mm of stroke, both within one step: a sine, then a constant speed.
TEST(OneSided, APusherWhoseTableEndsBeforeItsStrokeEndsWithItsStroke) {
  constexpr double kMass = 5, kSpeed0 = 9.62, kKnot = 0.0294, kStroke = 0.03822;
  Model model;
  model.bodies = {box("b", kMass, 1, 1, 1)};
  model.bodies[0].v_WB = {kSpeed0, 0, 0};
  OneSided f = push(0, kStroke);
  f.base = kGround;
  f.follower = 0;
  f.law = OneSided::Law::kTable;
  f.travels = {0, kKnot};
  f.forces = {100, 0};
  f.guide = {1, 0, 0};
  model.one_sided.push_back(f);
  Simulation s(model);
  const Seen seen = run(s, model, 20);
  ASSERT_EQ(seen.events.size(), 1U);
  EXPECT_EQ(seen.events[0].first, "stroke_end");
  // u'' = w² (knot − u) from u = 0: knot − u = knot cos(w t) − v / w sin(w t)
  const double w = std::sqrt(100 / kKnot / kMass), knot = std::atan2(kKnot, kSpeed0 / w) / w;
  const double speed = std::sqrt(kSpeed0 * kSpeed0 + w * w * kKnot * kKnot);
  EXPECT_NEAR(seen.events[0].second, knot + (kStroke - kKnot) / speed, kLocated);
}

TEST(OneSided, FrictionTakesItsPartOfTheWork) {
  Model model = build_line();
  OneSided f = push(100, 0.05);
  f.friction = 20;
  f.friction_speed = 1e-6;  // regularised away within 1e-6 m/s of rest
  model.one_sided = {f};
  Simulation s(model);
  const Seen seen = run(s, model, 300);
  EXPECT_NEAR(get_speed(s), std::sqrt(2 * (100 - 20) * 0.05 / kReduced), 1e-3);
  // Runs to the end of the stroke, where rounding decides the side of the limit.
  constexpr auto kDampers = static_cast<std::size_t>(PowerSource::kDampers);
  ASSERT_EQ(seen.audits.size(), 1u);
  EXPECT_NEAR(seen.audits[0].flow_before.power[kDampers], -20 * get_speed(s), 1e-6);
  EXPECT_EQ(seen.audits[0].flow_after.power[kDampers], 0);
}

TEST(OneSided, AGuidedPusherHasNoLateralForce) {
  Model model = build_line();
  OneSided f = push(100, 0.05);
  f.guide = Eigen::Vector3d::UnitX();
  model.one_sided = {f};
  model.bodies[0].inertia = 1e9 * Eigen::Matrix3d::Identity();  // the guide keeps its direction
  model.bodies[1].v_WB = {0, 2, 0};
  Simulation s(model);
  update_motion(s);
  const Balance before = calc_balance(s.data(), s.state, s.evaluation());
  const Seen seen = run(s, model, 200);
  update_motion(s);
  const Balance after = calc_balance(s.data(), s.state, s.evaluation());
  EXPECT_NEAR(s.state.bodies[1].v.y, 2, 1e-7);
  EXPECT_NEAR(s.state.bodies[1].v.x, 3 / 5.0 * std::sqrt(2 * 5 / kReduced), 1e-7);
  EXPECT_LT(norm(after.angular_momentum - before.angular_momentum), 1e-12);
  EXPECT_LT(seen.unexplained, kEnergy);
}

// A joint spring would pull the body back once the joint is free and the displacement beyond its rest position.
TEST(OneSided, APusherAlongAJointNeverPullsBack) {
  Model model = build_line();
  Joint joint;
  joint.name = "slide";
  joint.base = 0;
  joint.follower = 1;
  joint.point_base = {0.2, 0, 0};
  joint.modes = {{"slide", kSlideX}, {"free", 0}};
  model.joints = {joint};
  OneSided f = push(100, 0.05);
  f.joint = 0;
  f.axis = kX;
  model.one_sided = {f};
  model.events.push_back(
      {"release", "", when(Condition::Kind::kDisplacement, 0, kX, 0.03), 0, {act_set_mode(0, 1)}, false});
  Simulation s(model);
  run(s, model, 1000);
  EXPECT_NEAR(get_speed(s), std::sqrt(2 * 5 / kReduced), kSpeed);
}

TEST(OneSided, ATorsionPusherEndsAtItsAngle) {
  Model model = build_pendulum(true, 0);
  OneSided f = push(2, 0.5);
  f.joint = 0;
  f.axis = kRotZ;
  model.one_sided = {f};
  Simulation s(model);
  run(s, model, 1500);
  EXPECT_NEAR(s.state.bodies[0].w.z, std::sqrt(2 * 2 * 0.5 / (1.0 / 12 + 0.25)), kIntegrator);
}

// --- Stops and cords -------------------------------------------------------------------------------------------------

// Solution of m x'' + c x' + k x = 0 from x = 0 with x' = 1 until the force k x + c x' is 0: time and −x'.
std::pair<double, double> calc_bounce(double m, double k, double c) {
  const double w = std::sqrt(k / m), z = c / (2 * std::sqrt(k * m)), wd = w * std::sqrt(1 - z * z);
  const double t = std::atan2(2 * z * std::sqrt(1 - z * z), 2 * z * z - 1) / wd;
  return {t, -std::exp(-z * w * t) * (std::cos(wd * t) - z * w / wd * std::sin(wd * t))};
}

TEST(OneSided, AStopGivesBackWhatItsDamperLeaves) {
  for (const double damping : {0.0, 30.0}) {
    Model model = build_line();
    Joint joint;
    joint.name = "slide";
    joint.base = 0;
    joint.follower = 1;
    joint.point_base = {0.2, 0, 0};
    joint.modes = {{"slide", kSlideX}};
    model.joints = {joint};
    OneSided f = between(OneSided::Kind::kStop);
    f.joint = 0;
    f.axis = kX;
    f.pulls = true;
    f.limit = 0.1;
    f.stiffness = 4000;
    f.damping = damping;
    model.one_sided = {f};
    model.bodies[1].v_WB = {1, 0, 0};
    Simulation s(model);
    const Seen seen = run(s, model, 300);
    const auto [time, speed] = calc_bounce(kReduced, 4000, damping);
    ASSERT_EQ(seen.events.size(), 2u);
    EXPECT_EQ(seen.events[0].first, "touch");
    EXPECT_NEAR(seen.events[0].second, 0.1, kLocated);
    EXPECT_EQ(seen.events[1].first, "lift");
    EXPECT_NEAR(seen.events[1].second, 0.1 + time, 1e-6);
    EXPECT_NEAR(get_speed(s), -speed, 1e-6);
    if (damping == 0) {
      EXPECT_LT(seen.unexplained, kEnergy);
    }
  }
}

TEST(OneSided, ABodyComesToRestOnAStop) {
  Model model;
  model.bodies = {box("ball", 2, 1, 1, 1)};
  model.bodies[0].p_WB = {0, 0, 0.1};
  model.gravity.uniform = {0, 0, -10};
  OneSided f = between(OneSided::Kind::kStop);
  f.base = kGround;
  f.follower = 0;
  f.guide = Eigen::Vector3d::UnitZ();
  f.limit = 0;
  f.stiffness = 5000;
  f.damping = 40;
  model.one_sided = {f};
  Simulation s(model);
  run(s, model, 4000);
  EXPECT_NEAR(s.state.bodies[0].p.z, -20 / 5000.0, 1e-9);
  EXPECT_NEAR(calc_one_sided(s.plan, s.workspace, 0).force, 20, 1e-6);
}

TEST(OneSided, ACordIsSlackUntilItIsTaut) {
  Model model = build_line();
  OneSided f = between(OneSided::Kind::kCord);
  f.pulls = true;
  f.limit = 0.5;
  f.stiffness = 3000;
  model.one_sided = {f};
  model.bodies[1].v_WB = {1, 0, 0};
  Simulation s(model);
  const Seen seen = run(s, model, 500);
  ASSERT_EQ(seen.events.size(), 2u);
  EXPECT_EQ(seen.events[0].first, "taut");
  EXPECT_NEAR(seen.events[0].second, 0.3, kLocated);
  EXPECT_EQ(seen.events[1].first, "slack");
  EXPECT_NEAR(seen.events[1].second, 0.3 + M_PI / std::sqrt(3000 / kReduced), 1e-6);  // h w = 0.05: error of its phase
  EXPECT_NEAR(get_speed(s), -1, 1e-7);
}

TEST(OneSided, ACordOfItsOwnLengthAtTheStartHolds) {
  Model model = build_line();
  OneSided f = between(OneSided::Kind::kCord);
  f.pulls = true;
  f.limit = 0.2;
  f.stiffness = 3000;
  model.one_sided = {f};
  model.bodies[1].v_WB = {1, 0, 0};
  Simulation s(model);
  run(s, model, 200);
  EXPECT_NEAR(get_speed(s), -1, 1e-7);
}

TEST(OneSided, WhatIsSwitchedOffHasNoForceAndNoEvents) {
  Model model = build_line();
  model.one_sided = {push(100, 0.05)};
  model.one_sided[0].on = false;
  Action on;
  on.kind = Action::Kind::kSwitch;
  on.value = 1;
  model.events.push_back({"on", "", when_time(0.1), 0, {on}, false});
  Simulation s(model);
  EXPECT_TRUE(run(s, model, 90).events.empty());
  EXPECT_EQ(get_speed(s), 0);
  const Seen seen = run(s, model, 300);
  ASSERT_EQ(seen.events.size(), 2u);
  EXPECT_EQ(seen.events[0].first, "on");
  EXPECT_EQ(seen.events[1].first, "stroke_end");
  EXPECT_NEAR(get_speed(s), std::sqrt(2 * 5 / kReduced), kSpeed);
}

TEST(OneSided, ACordPartsAtItsLoad) {
  Model model = build_line();
  OneSided f = between(OneSided::Kind::kCord);
  f.pulls = true;
  f.limit = 0.2;
  f.stiffness = 3000;
  model.one_sided = {f};
  model.bodies[1].v_WB = {1, 0, 0};
  Action off;
  off.kind = Action::Kind::kSwitch;
  model.events.push_back({"part", "", when(Condition::Kind::kOneSidedForce, 0, 0, 30), 0, {off}, false});
  Simulation s(model);
  const Seen seen = run(s, model, 200);
  ASSERT_EQ(seen.events.size(), 1u);
  EXPECT_NEAR(seen.events[0].second, std::asin(30 / std::sqrt(3000 * kReduced)) / std::sqrt(3000 / kReduced), kLocated);
  EXPECT_NEAR(get_speed(s), std::sqrt(1 - 30.0 * 30 / 3000 / kReduced), kSpeed);
}

TEST(OneSided, AJointPartsWhereTheSizeOfItsReactionReachesALoad) {
  Model model;
  model.bodies = {box("bob", 2, 1, 1, 1)};
  Joint joint;
  joint.name = "bolt";
  joint.modes = {{"held", kWeldRows}, {"free", 0}};
  model.joints = {joint};
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(3, 0, 0), Eigen::Vector3d(0, 4, 0)}) {
    Load load;
    load.name = "pull" + std::to_string(model.loads.size());
    load.frame = Load::Frame::kWorld;
    load.direction = direction;
    load.profile.kind = Profile::Kind::kTable;
    load.profile.times = {0, 1};
    load.profile.values = {0, 10};
    model.loads.push_back(load);
  }
  model.events.push_back({"part", "", when(Condition::Kind::kForceSize, 0, 0, 25), 0, {act_set_mode(0, 1)}, false});
  Simulation s(model);
  const Seen seen = run(s, model, 700);
  ASSERT_EQ(seen.events.size(), 1u);
  EXPECT_NEAR(seen.events[0].second, 0.5, kLocated);  // 5 N · 10 t
}

// --- Friction --------------------------------------------------------------------------------------------------------

Model build_incline(double angle, double coefficient, double v_s) {
  Model model;
  model.bodies = {box("block", 2, 1, 1, 1)};
  model.gravity.uniform = {10 * std::sin(angle), 0, -10 * std::cos(angle)};
  Joint joint;
  joint.name = "rail";
  joint.modes = {{"slide", kSlideX}};
  model.joints = {joint};
  JointFriction f;
  f.name = "rub";
  f.axis = kX;
  f.coefficient = coefficient;
  f.speed = v_s;
  model.frictions = {f};
  return model;
}

TEST(JointFriction, ABlockSlidesDownItsRailByCoulombsLaw) {
  const Model model = build_incline(0.5, 0.3, 1e-3);
  Model thrown = model;
  thrown.bodies[0].v_WB = {1, 0, 0};  // v_s² / 2 v² of the friction is lost to regularisation: 5e-7 and falling
  Simulation s(thrown);
  run(s, thrown, 1000);
  const double a = 10 * (std::sin(0.5) - 0.3 * std::cos(0.5));
  EXPECT_NEAR(s.state.bodies[0].v.x, 1 + a, 1e-6);
  EXPECT_NEAR(s.state.bodies[0].p.x, 1 + a / 2, 1e-6);
}

TEST(JointFriction, BelowItsThresholdABlockCreepsAsItsRegularisationSays) {
  const double angle = 0.2, ratio = std::tan(angle) / 0.3;  // load / (μ |R|)
  const Model model = build_incline(angle, 0.3, 1e-2);
  Simulation s(model);
  run(s, model, 2000);
  EXPECT_NEAR(s.state.bodies[0].v.x, 1e-2 * ratio / std::sqrt(1 - ratio * ratio), 1e-9);
}

// A pin whose friction changes its own reaction: φ'' = −(m g l cos φ + T) / J, T = μ r |R| by a separate integration.
TEST(JointFriction, AHingePinTakesTheReactionThatItsFrictionMoves) {
  constexpr double kRadius = 0.05, kMu = 0.4, kJ = 1.0 / 12 + 0.25, kG = 10;
  Model model = build_pendulum(true, 3);
  model.gravity.uniform = {0, -kG, 0};
  JointFriction f;
  f.name = "pin";
  f.axis = kRotZ;
  f.coefficient = kMu;
  f.radius = kRadius;
  model.frictions = {f};
  Simulation s(model);
  run(s, model, 150);
  // Separate integration: at each instant T is solved by many sweeps.
  const auto calc = [&](double phi, double w) {
    double torque = 0, alpha = 0;
    for (int i = 0; i < 60; ++i) {
      alpha = (-kG * 0.5 * std::cos(phi) - torque) / kJ;
      const double along = -0.5 * w * w + kG * std::sin(phi), across = 0.5 * alpha + kG * std::cos(phi);
      const double v = kRadius * w;
      torque = kMu * kRadius * std::hypot(along, across) * v / std::sqrt(v * v + 1e-6);
    }
    return alpha;
  };
  double phi = 0, w = 3;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 15000; ++i) {
    const double a1 = calc(phi, w), w2 = w + kStep / 2 * a1, a2 = calc(phi + kStep / 2 * w, w2);
    const double w3 = w + kStep / 2 * a2, a3 = calc(phi + kStep / 2 * w2, w3), w4 = w + kStep * a3;
    const double a4 = calc(phi + kStep * w3, w4);
    phi += kStep / 6 * (w + 2 * w2 + 2 * w3 + w4);
    w += kStep / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  EXPECT_NEAR(s.state.bodies[0].w.z, w, 1e-6);  // (μ |R_1|)^4 of the reaction: R_1 = r l / J
}

// --- Impulses --------------------------------------------------------------------------------------------------------

TEST(Impulse, ItChangesMomentaByItselfAndIsAudited) {
  for (const bool grounded : {true, false}) {
    Model model = build_pendulum(grounded, 1);
    Impulse hit;
    hit.body = grounded ? 0 : 1;
    hit.point = {0.5, 0, 0};
    hit.linear = {0.3, 2, 0.1};
    hit.angular = {0, 0, 0.2};
    model.impulses = {hit};
    Action act;
    act.kind = Action::Kind::kImpulse;
    model.events.push_back({"hit", "", when_time(0.1005), 0, {act}, false});
    Simulation s(model);
    for (int i = 0; i < 200; ++i) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk);
      for (const EventAudit& audit : report.audits) {
        EXPECT_LT(norm(audit.jump.momentum - audit.allowed.momentum), 1e-12);
        EXPECT_LT(norm(audit.jump.angular_momentum - audit.allowed.angular_momentum), 1e-12);
        EXPECT_NEAR(audit.jump.kinetic, audit.allowed.kinetic, 1e-12);
        EXPECT_GT(audit.jump.kinetic, 1);
      }
    }
    if (grounded) {
      EXPECT_NEAR(s.state.bodies[0].w.z, 1 + (2 * 1 + 0.2) / (1.0 / 12 + 0.25), kIntegrator);
    }
  }
}

TEST(Impulse, ACommandMultipliesIt) {
  Model model;
  model.bodies = {box("ball", 2, 1, 1, 1)};
  model.channels.push_back({"charge", 0.5, 0, 1, 0, "1"});
  Impulse hit;
  hit.frame = Load::Frame::kWorld;
  hit.linear = {4, 0, 0};
  hit.channel = 0;
  model.impulses = {hit};
  Action act;
  act.kind = Action::Kind::kImpulse;
  model.events.push_back({"hit", "", when_time(0.01), 0, {act}, false});
  Simulation s(model);
  run(s, model, 20);
  EXPECT_NEAR(s.state.bodies[0].v.x, 1, 1e-15);
}

TEST(Elementary, TheLogarithmIsWithinTwoUnits) {
  for (double x :
       {1e-300, 1e-9, 0.3, 0.7071, 0.7072, 0.999999999, 1.0, 1.0000001, 1.4142, 1.4143, 2.0, 3.0, 1e5, 1e300}) {
    const double exact = std::log(x);
    EXPECT_NEAR(elementary::log(x), exact, 2 * 2.3e-16 * std::abs(exact)) << x;
  }
  for (const double x : {0.0, -1.0, std::nan(""), HUGE_VAL}) EXPECT_TRUE(std::isnan(elementary::log(x)));
}

}  // namespace
}  // namespace unlatch::test::one_sided_test
