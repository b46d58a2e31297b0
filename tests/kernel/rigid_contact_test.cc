// Rigid contacts: closed forms, an independent integration, balances, several at once, what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <random>

#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/kinds/contact/rigid_row.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/reference_models.h"
#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"
#include "unlatch/energy.h"

namespace unlatch::test::rigid_contact_test {
namespace {

// The gap of a closed pair, m, and its rate, m/s: the projections leave rounding.
constexpr double kDrift = 1e-12;

struct Logged {
  double time;
  std::string name;
  Vec3 place;
};

// Steps; returns the events that acted.
std::vector<Logged> run(Simulation& s, const Model& model, int ticks) {
  std::vector<Logged> events;
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    EXPECT_EQ(report.status, StepStatus::kOk) << "tick " << i;
    for (const FiredEvent& fired : report.events)
      events.push_back({fired.time, model.events[static_cast<std::size_t>(fired.event)].name, s.state.bodies[0].p});
    if (report.status != StepStatus::kOk) break;
  }
  return events;
}

double calc_gap(const Simulation& s) { return calc_shape_distance(s.plan, s.state, 0, 1).least.distance; }

TEST(RigidContact, ABallBouncesAtTheTimesOfTheClosedForm) {
  constexpr double kHeight = 0.2, kRestitution = 0.5;
  constexpr double kTime = 1e-8;  // s: each touch is located to 1e-6 of the step
  const Model model = build_bouncing_ball(kHeight, kRestitution);
  Simulation s(model);
  int settled = 0;
  std::vector<double> touches;
  for (int i = 0; i < 1000; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    EXPECT_EQ(report.postponed, 0);
    settled += report.settled;
    for (const FiredEvent& fired : report.events)
      if (fired.event == 0) touches.push_back(fired.time);
  }
  double time = std::sqrt(2 * kHeight / kGravity), flight = 2 * time;
  std::size_t bounces = 0;
  for (; flight >= 0.5e-3 / kRestitution; ++bounces) {
    ASSERT_LT(bounces, touches.size());
    EXPECT_NEAR(touches[bounces], time, kTime) << "bounce " << bounces;
    flight *= kRestitution;
    time += flight;
  }
  EXPECT_GT(bounces, 7u);
  EXPECT_EQ(touches.size(), bounces + 1) << "the next flight would be shorter than half of the step";
  EXPECT_EQ(settled, 1);
  EXPECT_NEAR(calc_gap(s), 0, kDrift);
  EXPECT_NEAR(s.state.bodies[0].v.z, 0, kDrift);
  const ContactTotals totals = get_contact_totals(s.plan, s.state, 0);
  EXPECT_NEAR(totals.impulse, kGravity * 1.0, 1e-9) << "what the weight has given in 1 s";
  EXPECT_NEAR(totals.dissipated, kGravity * kHeight, 1e-6);
  EXPECT_NEAR(calc_contact(s.plan, s.state, 0).normal, kGravity, 1e-10);
}

TEST(RigidContact, OneAtRestBearsTheWeightFromTheStart) {
  const Model model = build_bouncing_ball(0, 0.5);
  Simulation s(model);
  EXPECT_EQ(s.state.contacts[0].closed, 1);
  ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  EXPECT_NEAR(s.workspace.accelerations[0].lin.z, 0, 1e-13);
  store_rigid_forces(s.plan, s.workspace, s.state);
  EXPECT_NEAR(calc_contact(s.plan, s.state, 0).normal, kGravity, 1e-12);
  EXPECT_TRUE(run(s, model, 1000).empty());
  EXPECT_NEAR(calc_gap(s), 0, kDrift);
}

// (J + m l² cos²θ) θ'' = m l² sinθ cosθ θ'² − m g l cosθ: one degree of freedom, RK4 of steps that are far finer.
double integrate_rod(double angle, double until) {
  constexpr int kSteps = 200000;
  constexpr double J = 1.0 / 12, l = kRodHalf;
  const double h = until / kSteps;
  const auto f = [](double a, double w) {
    const double c = std::cos(a), s = std::sin(a);
    return (l * l * s * c * w * w - kGravity * l * c) / (J + l * l * c * c);
  };
  double a = angle, w = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double a1 = w, w1 = f(a, w), a2 = w + h / 2 * w1, w2 = f(a + h / 2 * a1, w + h / 2 * w1);
    const double a3 = w + h / 2 * w2, w3 = f(a + h / 2 * a2, w + h / 2 * w2), a4 = w + h * w3,
                 w4 = f(a + h * a3, w + h * w3);
    a += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    w += h / 6 * (w1 + 2 * w2 + 2 * w3 + w4);
  }
  return a;
}

TEST(RigidContact, ARodSlidesDownWithOrderFour) {
  constexpr double kAngle = 1.2, kUntil = 0.4;
  const double expected = integrate_rod(kAngle, kUntil);
  double errors[3];
  for (int k = 0; k < 3; ++k) {
    const double dt = 0.01 / (1 << k);
    const Model model = build_falling_rod(kAngle);
    Simulation s(model, {.dt = dt});
    EXPECT_TRUE(run(s, model, static_cast<int>(std::lround(kUntil / dt))).empty());
    const BodyState& rod = s.state.bodies[0];
    errors[k] = std::abs(-2 * std::atan2(rod.q.y, rod.q.w) - expected);
    EXPECT_NEAR(rod.p.x, 0, 1e-12) << "nothing pushes it along the floor";
    EXPECT_NEAR(calc_gap(s), 0, 1e-11);
  }
  EXPECT_LT(errors[2], 1e-9);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 4, 0.5) << errors[k];
}

// A ball without friction slides down a sphere from the angle a; energy and force: it leaves where cos = 2/3 cos a.
TEST(RigidContact, ABallLeavesASphereWhereItsForceFallsToZero) {
  constexpr double kAngle = 0.3, kSphere = 1, kReach = kSphere + kBallRadius;
  Model model = build_bouncing_ball(0, 0);
  model.surfaces[0].shapes = {build_sphere(kSphere)};
  model.bodies[0].p_WB = {kReach * std::sin(kAngle), 0, kReach * std::cos(kAngle)};
  Simulation s(model);
  ASSERT_EQ(s.state.contacts[0].closed, 1);
  const std::vector<Logged> events = run(s, model, 900);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].name, "lift");
  // up to the tick after the lift the ball goes on less than 4 mm
  EXPECT_NEAR(events[0].place.z, kReach * 2 / 3 * std::cos(kAngle), 4e-3);
  const double speed = std::sqrt(kReach * kGravity * 2 / 3 * std::cos(kAngle));  // v² = g r cos there
  const double c = 2.0 / 3 * std::cos(kAngle), sine = std::sqrt(1 - c * c), t = s.get_time() - events[0].time;
  EXPECT_NEAR(s.state.bodies[0].p.x, kReach * sine + speed * c * t, 1e-8);
  EXPECT_NEAR(s.state.bodies[0].p.z, kReach * c - speed * sine * t - 0.5 * kGravity * t * t, 1e-8);
}

TEST(RigidContact, FourFeetShareTheLoadAsIfEquallyStiff) {
  Model model = build_rigid_feet();
  Simulation s(model);
  run(s, model, 100);
  for (const double force : s.state.rigid_forces) EXPECT_NEAR(force, 2 * kGravity / 4, 1e-10);
  Load push;  // of 2 N down, over the feet at x = 0.25 m, and along x
  push.name = "push";
  push.point = {0.25, 0, 0};
  push.direction = {1, 0, -2};
  model.loads.push_back(push);
  Simulation pressed(model);
  run(pressed, model, 100);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(pressed.state.rigid_forces[i], 2 * kGravity / 4 + (i < 2 ? 0 : 1), 1e-9) << i;
  EXPECT_NEAR(pressed.state.bodies[0].v.x, 0.5 * 0.1, 1e-12);
  EXPECT_NEAR(pressed.state.bodies[0].p.z, 0.25, kDrift);
}

TEST(RigidContact, FourFeetThatLandAtOnceBounceTogether) {
  Model model = build_rigid_feet();
  model.contacts[0].restitution = 0.5;
  model.bodies[0].p_WB.z() += 0.05;
  Simulation s(model);
  run(s, model, 110);  // the fall takes 0.1010 s
  const double landing = std::sqrt(2 * 0.05 / kGravity), speed = kGravity * landing;
  EXPECT_NEAR(s.state.bodies[0].v.z, 0.5 * speed - kGravity * (0.11 - landing), 1e-10);
  EXPECT_NEAR(norm(s.state.bodies[0].w), 0, 1e-10);
}

// Of the four rows one is redundant, and no velocity has the restitution of all: two opposite feet bounce by theirs,
// which is larger, and the others are lifted off.
TEST(RigidContact, FourFeetThatLandAtOnceBounceByTheLargerRestitutionOfTheTwoDiagonals) {
  for (const bool first_is_larger : {true, false}) {
    Model model = build_rigid_feet();
    std::vector<geometry::Shape>& feet = model.surfaces[1].shapes;
    model.surfaces.push_back({"others", 0, {feet[1], feet[2]}});
    feet = {feet[0], feet[3]};
    model.contacts.push_back(touch_rigidly("others on floor", 0, 2));
    model.contacts[0].restitution = first_is_larger ? 0.6 : 0.2;
    model.contacts[1].restitution = first_is_larger ? 0.2 : 0.6;
    model.events.clear();
    add_contact_events(model);
    model.bodies[0].p_WB.z() += 0.05;
    Simulation s(model);
    run(s, model, 110);
    const double landing = std::sqrt(2 * 0.05 / kGravity), speed = kGravity * landing;
    EXPECT_NEAR(s.state.bodies[0].v.z, 0.6 * speed - kGravity * (0.11 - landing), 1e-10);
    EXPECT_NEAR(norm(s.state.bodies[0].w), 0, 1e-10);
  }
}

// Random blows of a spinning body with a ball against another one: momenta, restitution, loss.
TEST(RigidContact, ABlowKeepsMomentaAndLosesItsPartOfTheEnergy) {
  std::mt19937_64 random(5);
  const auto draw = [&] { return std::uniform_real_distribution<>(-1, 1)(random); };
  int blows = 0;
  for (int k = 0; k < 20; ++k) {
    const double e = 0.5 + 0.5 * draw();
    Model model;
    model.name = "pair";
    for (const double side : {0.0, 0.6}) {
      Body body = box(side > 0 ? "ball" : "block", 1 + 0.5 * draw(), 0.02, 0.03, 0.025);
      body.p_WB = {side, 0.1 * draw(), 0.1 * draw()};
      body.q_WB = Eigen::Quaterniond(1, 0.2 * draw(), 0.2 * draw(), 0.2 * draw()).normalized();
      body.w_WB_B = {2 * draw(), 2 * draw(), 2 * draw()};
      body.v_WB = {side > 0 ? -4.0 : 0.0, 0.1 * draw(), 0.1 * draw()};
      model.bodies.push_back(body);
    }
    geometry::Shape block;
    block.kind = geometry::ShapeKind::kBox;
    block.size = {0.4, 0.5, 0.6};
    model.surfaces = {{"block", 0, {block}}, {"ball", 1, {build_sphere(0.2, {0.02, 0.03, -0.01})}}};
    model.contacts = {touch_rigidly("blow", 0, 1, e)};
    add_contact_events(model);
    Simulation s(model);
    for (int i = 0; i < 200; ++i) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk);
      for (const EventAudit& audit : report.audits) {
        EXPECT_LT(norm(audit.jump.momentum), 1e-13);
        EXPECT_LT(norm(audit.jump.angular_momentum), 1e-13);
        EXPECT_NEAR(audit.jump.kinetic, audit.allowed.kinetic, 1e-12);
        EXPECT_LE(audit.allowed.kinetic, 1e-15);
        blows += audit.allowed.kinetic < 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(blows, 10);
}

TEST(RigidContact, AHeadOnBlowHasNewtonsRestitution) {
  for (const double e : {0.0, 0.3, 1.0}) {
    Model model;
    model.name = "balls";
    for (const double side : {0.0, 1.0}) {
      model.bodies.push_back(box(side > 0 ? "b" : "a", side > 0 ? 3 : 2, 1, 1, 1));
      model.bodies.back().p_WB = {side, 0, 0};
      model.bodies.back().v_WB = {side > 0 ? -2.0 : 1.0, 0, 0};
    }
    model.surfaces = {{"a", 0, {build_sphere(0.3)}}, {"b", 1, {build_sphere(0.2)}}};
    model.contacts = {touch_rigidly("blow", 0, 1, e)};
    add_contact_events(model);
    Simulation s(model);
    run(s, model, 500);
    EXPECT_NEAR(s.state.bodies[1].v.x - s.state.bodies[0].v.x, e * 3, 1e-12);
    EXPECT_NEAR(get_contact_totals(s.plan, s.state, 0).impulse, 1.2 * (1 + e) * 3, 1e-12);
    EXPECT_NEAR(get_contact_totals(s.plan, s.state, 0).dissipated, 0.5 * 1.2 * (1 - e * e) * 9, 1e-12);
  }
}

// Ball 1 meets ball 2, which touches ball 3: the rows take part together.
TEST(RigidContact, ABlowGoesThroughAContactAtRest) {
  Model model;
  model.name = "row";
  for (int b = 0; b < 3; ++b) {
    model.bodies.push_back(box("ball" + std::to_string(b), 1, 1, 1, 1));
    model.bodies.back().p_WB = {b == 0 ? -1.0 : 0.5 * b, 0, 0};
    model.surfaces.push_back({"ball" + std::to_string(b), b, {build_sphere(0.25)}});
  }
  model.bodies[0].v_WB = {3, 0, 0};
  model.contacts = {touch_rigidly("first", 0, 1, 1), touch_rigidly("second", 1, 2, 1)};
  add_contact_events(model);
  Simulation s(model);
  ASSERT_EQ(s.state.contacts[1].closed, 1);
  run(s, model, 500);
  // 1 against 2 kg, elastic: −1/3 and 2/3 of the speed
  EXPECT_NEAR(s.state.bodies[0].v.x, -1, 1e-12);
  EXPECT_NEAR(s.state.bodies[1].v.x, 2, 1e-12);
  EXPECT_NEAR(s.state.bodies[2].v.x, 2, 1e-12);
}

// tests/references/rigid_reference.py: minimal coordinates. It bounces, settles, slides, lifts off and bounces again.
TEST(RigidContact, AChainOnAFloorAgreesWithAnIndependentIntegration) {
  constexpr double kTime = 1e-8, kAngle = 1e-7;  // s; rad and rad/s
  const nlohmann::json reference = load_reference("rigid");
  const Model model = build_falling_chain();
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const double dt = k == 0 ? 1e-3 : 0.5e-3;
    Simulation s(model, {.dt = dt});
    const std::vector<Logged> events = run(s, model, static_cast<int>(std::lround(reference["t"].get<double>() / dt)));
    ASSERT_EQ(events.size(), reference["events"].size());
    errors[k] = 0;
    for (std::size_t i = 0; i < events.size(); ++i) {
      EXPECT_EQ(events[i].name, reference["events"][i]["name"].get<std::string>()) << i;
      EXPECT_NEAR(events[i].time, reference["events"][i]["t"].get<double>(), kTime) << i;
      errors[k] = std::max(errors[k], std::abs(events[i].time - reference["events"][i]["t"].get<double>()));
    }
    const std::vector<double> end = reference["state"];
    for (std::size_t b = 0; b < 2; ++b) {
      const BodyState& body = s.state.bodies[b];
      const double turns = std::remainder(2 * std::atan2(body.q.z, body.q.w) - end[b], 4 * std::acos(-1.0));
      EXPECT_NEAR(turns, 0, kAngle) << b;
      EXPECT_NEAR(body.w.z, end[b + 2], 10 * kAngle) << b;
    }
  }
  std::cout << "largest error of an event, s: " << errors[0] << " at 1 ms, " << errors[1] << " at 0.5 ms\n";
}

// Between explicit and implicit elements nothing differs for the row: stages of ROS2 hold it as those of RK4 do.
TEST(RigidContact, AGapStaysClosedBesideAnImplicitSpring) {
  Model model = build_falling_chain();
  model.contacts[0].restitution = 0;
  JointSpring spring;
  spring.name = "spring";
  spring.joint = 1;
  spring.axis = kRotZ;
  spring.stiffness = 1e6;
  spring.damping = 10;
  spring.rest = -0.5;
  spring.implicit = true;
  model.joint_springs.push_back(spring);
  Simulation s(model);
  int closed = 0;
  for (int i = 0; i < 1500; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    if (s.state.contacts[0].closed == 0) continue;
    ++closed;
    EXPECT_NEAR(calc_gap(s), 0, kDrift) << i;
    EXPECT_GE(s.state.rigid_forces[0], 0) << i;
  }
  EXPECT_GT(closed, 50);
}

// The ball of a pendulum meets a wall: the hinge's rows take part in the impulse.
TEST(RigidContact, APendulumBouncesAboutItsHinge) {
  Model model = build_pendulum(true, 2);
  geometry::Shape wall = build_floor();
  wall.normal = {0, -1, 0};
  wall.from = {0, 0.5, 0};
  model.surfaces = {{"wall", kGround, {wall}}, {"end", 0, {build_sphere(0.1, {0.5, 0, 0})}}};
  model.contacts = {touch_rigidly("blow", 0, 1, 0.25)};
  add_contact_events(model);
  Simulation s(model);
  const std::vector<Logged> events = run(s, model, 400);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_NEAR(events[0].time, std::asin(0.4) / 2, 1e-9);
  EXPECT_NEAR(s.state.bodies[0].w.z, -0.5, 1e-10);
  EXPECT_NEAR(norm(s.state.bodies[0].p), 0.5, 1e-12);
}

// The bias against differences of the distance itself, on bodies that move and turn, for each kind of shape.
TEST(RigidContact, TheSecondDerivativeOfTheGapIsThatOfTheDistance) {
  std::mt19937_64 random(11);
  const auto draw = [&] { return std::uniform_real_distribution<>(-1, 1)(random); };
  const auto draw_vec = [&] { return Vec3{draw(), draw(), draw()}; };
  std::vector<geometry::Shape> shapes(8);
  shapes[0] = build_floor();
  shapes[1] = build_sphere(0.4);
  shapes[2].kind = geometry::ShapeKind::kCapsule;
  shapes[2].from = {-0.3, 0, 0};
  shapes[2].to = {0.4, 0.1, 0};
  shapes[2].radius = 0.2;
  shapes[3].kind = geometry::ShapeKind::kBox;
  shapes[3].size = {0.5, 0.7, 0.9};
  shapes[4].kind = geometry::ShapeKind::kCylinder;
  shapes[4].from = {0, 0, -0.4};
  shapes[4].to = {0, 0.1, 0.4};
  shapes[4].radius = 0.3;
  shapes[5].kind = geometry::ShapeKind::kFrustum;
  shapes[5].from = {0, 0, -0.4};
  shapes[5].to = {0, 0, 0.4};
  shapes[5].radius = 0.4;
  shapes[5].end_radius = 0.2;
  shapes[6].kind = geometry::ShapeKind::kHull;
  shapes[6].points = {{0.5, 0, 0}, {-0.5, 0.1, 0}, {0, 0.6, 0}, {0, -0.5, 0.1}, {0, 0.1, 0.5}, {0.1, 0, -0.5}};
  // a long capsule and a short one against the ball's capsule: crossing, and end to end
  shapes[7] = shapes[2];
  shapes[7].from = {-1.5, 0.2, 0.1};
  shapes[7].to = {1.5, -0.1, 0.2};
  geometry::Shape capsule = shapes[2];
  capsule.from = {0.1, -0.8, 0.2};
  capsule.to = {-0.1, 0.7, -0.1};
  int skipped = 0, crossed = 0, ended = 0;
  for (std::size_t kind = 0; kind < shapes.size() + 2; ++kind)
    for (int k = 0; k < 40; ++k) {
      Model model;
      model.name = "pair";
      for (int b = 0; b < 2; ++b) model.bodies.push_back(box(b > 0 ? "ball" : "other", 1, 1, 1, 1));
      model.bodies[1].p_WB = {0, 0, 5};
      const bool capsules = kind >= shapes.size();
      const geometry::Shape& other = capsules ? shapes[kind == shapes.size() ? 2 : 7] : shapes[kind];
      const geometry::Shape ball = capsules ? capsule : build_sphere(0.15, {0.1, -0.05, 0.2});
      model.surfaces = {{"other", 0, {other}}, {"ball", 1, {ball}}};
      model.contacts = {touch_rigidly("pair", k % 2, 1 - k % 2)};
      Simulation s(model);
      struct Motion {
        Vec3 p, v, a, w, alpha;
        Mat3 R;
      } m[2];
      for (Motion& body : m) body = {0.3 * draw_vec(), draw_vec(), draw_vec(), draw_vec(), draw_vec(), kIdentity3};
      const Vec3 out = {draw(), draw(), 2 + draw()};
      m[1].p = m[0].p + (1.2 / norm(out)) * out;
      const auto get = [&](const Motion& body, double t) {
        // of third order in t: angular velocity w + alpha t, turned about its mean with its commutator
        const Vec3 turn = t * body.w + (0.5 * t * t) * body.alpha + (t * t * t / 12) * cross(body.alpha, body.w);
        const double angle = norm(turn);
        Mat3 R = body.R;
        if (angle > 0) {
          const double half = 0.5 * angle, size = std::sin(half) / angle;
          R = rotation_matrix(Quat{std::cos(half), size * turn.x, size * turn.y, size * turn.z}) * body.R;
        }
        return BodyFrame{R, body.p + t * body.v + (0.5 * t * t) * body.a, body.v + t * body.a, body.w + t * body.alpha};
      };
      const int base = k % 2, follower = 1 - base;
      RigidRow row{};
      const auto calc = [&](double t) {
        EXPECT_TRUE(calc_rigid_row(s.data(), 0, get(m[base], t), get(m[follower], t), row));
        return row.gap;
      };
      const auto differentiate = [&](double width) {
        return (calc(width) - 2 * calc(0) + calc(-width)) / (width * width);
      };
      constexpr double kWidth = 1e-3, kError = 1e-4;  // by the fourth derivative, and by rounding
      const double expected = differentiate(kWidth), rate = (calc(kWidth) - calc(-kWidth)) / (2 * kWidth);
      // where the nearest point passes an edge between the three places there is no second derivative
      if (std::abs(differentiate(2 * kWidth) - expected) > kError) {
        ++skipped;
        continue;
      }
      calc(0);
      const double second =
          row.bias + apply_rigid_row(row, {m[base].a, m[base].alpha}, {m[follower].a, m[follower].alpha});
      EXPECT_NEAR(row.rate, rate, kError) << "kind " << kind << ", draw " << k;
      EXPECT_NEAR(second, expected, kError) << "kind " << kind << ", draw " << k;
      if (!capsules) continue;
      const geometry::CompiledShape of_base = geometry::compile_shape(base == 0 ? other : ball),
                                    of_follower = geometry::compile_shape(base == 0 ? ball : other);
      const BodyFrame at_base = get(m[base], 0), at_follower = get(m[follower], 0);
      const double distance =
          geometry::calc_distance(of_base, {at_base.p, at_base.R}, of_follower, {at_follower.p, at_follower.R})
              .distance;
      EXPECT_NEAR(row.gap, distance, 1e-14) << "kind " << kind << ", draw " << k;
      const Vec3 axis =
          geometry::calc_capsule_distance(of_follower, {at_follower.p, at_follower.R}, of_base, {at_base.p, at_base.R})
              .axis;
      ++(norm(axis) > 0 ? crossed : ended);
    }
  EXPECT_LT(skipped, 20);
  EXPECT_GT(crossed, 20);
  EXPECT_GT(ended, 5);
}

TEST(RigidContact, StepsDoNotAllocate) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer has its own malloc";
  const Model model = build_bouncing_ball(0.01, 0.7);
  Simulation s(model);
  const AllocationCount count;
  for (int i = 0; i < 500; ++i) s.advance();
  EXPECT_EQ(count.get(), 0);
}

TEST(RigidContact, ACopiedStateGoesOnWithTheSameBits) {
  Model model = build_rigid_feet();
  model.contacts[0].restitution = 0.4;
  model.bodies[0].p_WB.z() += 0.01;
  model.bodies[0].w_WB_B = {0.3, -0.2, 0};
  Simulation whole(model), first(model);
  for (int i = 0; i < 300; ++i) whole.advance();
  for (int i = 0; i < 120; ++i) first.advance();
  Simulation second(model);
  std::memcpy(second.state.get_bytes().data(), first.state.get_bytes().data(), first.state.get_bytes().size());
  for (int i = 120; i < 300; ++i) second.advance();
  EXPECT_EQ(calc_hash(second.state), calc_hash(whole.state));
}

TEST(RigidContact, EveryWidthGivesTheSameBits) {
  Model model = build_rigid_feet();
  model.contacts[0].restitution = 0.4;
  model.bodies[0].p_WB.z() += 0.01;
  model.bodies[0].w_WB_B = {0.3, -0.2, 0};
  std::vector<std::uint64_t> hashes;
  for (const InstructionSet set : {InstructionSet::kScalar, InstructionSet::kAuto}) {
    Simulation s(model, {.instruction_set = set});
    for (int i = 0; i < 300; ++i) s.advance();
    hashes.push_back(calc_hash(s.state));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(RigidContact, OneThatTheJointsHoldBearsNothing) {
  Model model = build_rigid_feet();
  Joint weld;
  weld.name = "weld";
  weld.base = kGround;
  weld.follower = 0;
  weld.point_base = {0, 0, 0.25};
  weld.modes = {{"held", kWeldRows}, {"free", 0}};
  model.joints.push_back(weld);
  Event release;
  release.name = "release";
  release.when = when_time(0.05);
  release.then = {act_set_mode(0, 1)};
  model.events.push_back(release);
  Simulation s(model);
  run(s, model, 49);
  for (const double force : s.state.rigid_forces) EXPECT_EQ(force, 0);
  run(s, model, 51);
  for (const double force : s.state.rigid_forces) EXPECT_NEAR(force, 2 * kGravity / 4, 1e-9);
  EXPECT_NEAR(s.state.bodies[0].p.z, 0.25, kDrift);
}

// A body that lands on one foot rocks from foot to foot: touches of other feet while one bears.
TEST(RigidContact, ALandingOnOneFootComesToRestOnFour) {
  Model model = build_rigid_feet();
  model.contacts[0].restitution = 0.3;
  model.bodies[0].p_WB.z() += 0.05;
  model.bodies[0].q_WB = Eigen::Quaterniond(1, 0.05, 0.03, 0).normalized();
  Simulation s(model);
  const EnergyFlow before = [&] {
    EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
    return calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
  }();
  run(s, model, 3000);
  for (const ContactState& pair : s.state.contacts) EXPECT_EQ(pair.closed, 1);
  EXPECT_NEAR(s.state.bodies[0].p.z, 0.25, 1e-9);
  EXPECT_LT(norm(s.state.bodies[0].w), 1e-9);
  const double lost = get_contact_totals(s.plan, s.state, 0).dissipated, fallen = model.bodies[0].p_WB.z() - 0.25;
  EXPECT_NEAR(lost, before.kinetic + 2 * kGravity * fallen, 1e-4);
}

}  // namespace
}  // namespace unlatch::test::rigid_contact_test
