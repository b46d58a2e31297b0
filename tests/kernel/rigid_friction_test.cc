// Friction of rigid contacts: closed forms, an independent integration, blows, balances, what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <random>
#include <vector>

#include "kernel/elements/kinds/contact/rigid_row.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"
#include "unlatch/energy.h"

namespace unlatch::test::rigid_friction_test {
namespace {

// The block on four feet on a floor that is tilted by an angle about y: it would slide along +x.
Model build_incline(double friction, double tilt) {
  Model model = build_rigid_feet();
  model.contacts[0].friction = friction;
  model.gravity.uniform = {kGravity * std::sin(tilt), 0, -kGravity * std::cos(tilt)};
  return model;
}

constexpr double kRadius = 0.1;  // m

// A homogeneous ball of 1 kg, `height` above a floor.
Model build_rolling_ball(double friction, double height, double restitution = 0) {
  Model model;
  model.name = "ball";
  model.gravity.uniform = {0, 0, -kGravity};
  constexpr double kInertia = 0.4 * kRadius * kRadius;
  model.bodies.push_back(box("ball", 1, kInertia, kInertia, kInertia));
  model.bodies[0].p_WB = {0, 0, kRadius + height};
  model.surfaces = {{"floor", kGround, {build_floor()}}, {"ball", 0, {build_sphere(kRadius)}}};
  model.contacts = {touch_rigidly("ball on floor", 0, 1, restitution)};
  model.contacts[0].friction = friction;
  add_contact_events(model);
  return model;
}

void run(Simulation& s, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk) << "tick " << i;
    ASSERT_EQ(report.postponed, 0) << "tick " << i;
  }
}

double calc_energy(Simulation& s, const Model& model) {
  EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  double sum = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0}).kinetic;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Eigen::Vector3d& g = model.gravity.uniform;
    const Vec3& p = s.state.bodies[b].p;
    sum -= model.bodies[b].mass * (g.x() * p.x + g.y() * p.y + g.z() * p.z);
  }
  for (std::size_t c = 0; c < model.contacts.size(); ++c)
    sum += get_contact_totals(s.plan, s.state, static_cast<int>(c)).dissipated;
  return sum;
}

TEST(RigidFriction, ABlockSticksOnAnInclineBelowTheFrictionAngle) {
  const double tilt = std::atan(0.4);
  Simulation s(build_incline(0.5, tilt));
  run(s, 1000);
  EXPECT_NEAR(norm(s.state.bodies[0].v), 0, 1e-14);
  EXPECT_NEAR(norm(s.state.bodies[0].p - Vec3{0, 0, 0.25}), 0, 1e-13);
  const ContactReading reading = calc_contact(s.plan, s.state, 0);
  EXPECT_NEAR(reading.force.x, -2 * kGravity * std::sin(tilt), 1e-11);
  EXPECT_NEAR(reading.normal, 2 * kGravity * std::cos(tilt), 1e-11);
}

TEST(RigidFriction, ABlockSlidesOnAnInclineAboveTheFrictionAngle) {
  const double tilt = std::atan(0.6), gain = kGravity * (std::sin(tilt) - 0.5 * std::cos(tilt));
  const Model model = build_incline(0.5, tilt);
  Simulation s(model);
  const double before = calc_energy(s, model);
  run(s, 1000);
  // Slips that begin keep their directions up to 4e-5 m/s; those of four feet are iterated up to 32 times, to 0.03 rad.
  constexpr double kBegins = 1e-7;  // m/s and m
  EXPECT_NEAR(s.state.bodies[0].v.x, gain, kBegins);
  EXPECT_NEAR(s.state.bodies[0].p.x, 0.5 * gain, kBegins);
  EXPECT_NEAR(norm(s.state.bodies[0].w), 0, 1e-12);
  EXPECT_NEAR(get_contact_totals(s.plan, s.state, 0).slip, 0.5 * gain, kBegins);
  EXPECT_NEAR(calc_energy(s, model), before, 1e-10);
}

TEST(RigidFriction, ASlidingBlockStopsWhereTheClosedFormSays) {
  constexpr double kSpeed = 2, kFriction = 0.4, kPlace = 1e-9;
  Model model = build_incline(kFriction, 0);
  model.bodies[0].v_WB = {kSpeed * 0.6, kSpeed * 0.8, 0};
  Simulation s(model);
  const double before = calc_energy(s, model);
  run(s, 1000);
  const double way = kSpeed * kSpeed / (2 * kFriction * kGravity);
  EXPECT_NEAR(s.state.bodies[0].p.x, 0.6 * way, kPlace);
  EXPECT_NEAR(s.state.bodies[0].p.y, 0.8 * way, kPlace);
  EXPECT_NEAR(norm(s.state.bodies[0].v), 0, 1e-14);
  for (const ContactState& pair : s.state.contacts) EXPECT_EQ(pair.closed, kPairSticks);
  EXPECT_NEAR(calc_energy(s, model), before, 1e-9);
}

// A block that slides across an incline: its slip turns, and lasts. Beside a point that the same forces pull.
TEST(RigidFriction, ASlipThatTurnsIsOfOrderFour) {
  constexpr double kFriction = 0.3, kEnd = 0.5;
  const double tilt = 0.2;
  const double pull = kGravity * std::sin(tilt), hold = kFriction * kGravity * std::cos(tilt);
  double x = 0, y = 0, vx = 0, vy = 2;  // of the point
  constexpr int kFine = 50000;
  const double h = kEnd / kFine;
  const auto calc = [&](double a, double b, double* out) {
    const double size = std::sqrt(a * a + b * b);
    out[0] = pull - hold * a / size;
    out[1] = -hold * b / size;
  };
  for (int i = 0; i < kFine; ++i) {
    double k1[2], k2[2], k3[2], k4[2];
    calc(vx, vy, k1);
    calc(vx + 0.5 * h * k1[0], vy + 0.5 * h * k1[1], k2);
    calc(vx + 0.5 * h * k2[0], vy + 0.5 * h * k2[1], k3);
    calc(vx + h * k3[0], vy + h * k3[1], k4);
    x += h * vx + h * h / 6 * (k1[0] + k2[0] + k3[0]);
    y += h * vy + h * h / 6 * (k1[1] + k2[1] + k3[1]);
    vx += h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0]);
    vy += h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1]);
  }
  double errors[3];
  for (int k = 0; k < 3; ++k) {
    const double dt = 0.025 / (1 << k);
    Model model = build_incline(kFriction, tilt);
    model.bodies[0].v_WB = {0, 2, 0};
    Simulation s(model, {.dt = dt});
    run(s, static_cast<int>(std::lround(kEnd / dt)));
    const BodyState& body = s.state.bodies[0];
    errors[k] = norm(body.p - Vec3{x, y, 0.25}) + norm(body.v - Vec3{vx, vy, 0});
    std::cout << "dt " << dt << ": " << errors[k] << "\n";
  }
  EXPECT_LT(errors[2], 1e-8);
  EXPECT_GT(errors[0] / errors[1], 10);
  EXPECT_GT(errors[1] / errors[2], 10);
}

TEST(RigidFriction, ANumberOfPartsInTheModelHoldsForSlipsToo) {
  Model model = build_incline(0.3, 0.2);
  model.contact_substeps = 4;
  model.bodies[0].v_WB = {0, 2, 0};
  Simulation s(model);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(s.advance().substeps, 4) << i;
}

TEST(RigidFriction, ABallWithBackspinSlipsThenRolls) {
  constexpr double kFriction = 0.2, kSpeed = 1, kSpin = -30;  // about y: backwards
  Model model = build_rolling_ball(kFriction, 0);
  model.bodies[0].v_WB = {kSpeed, 0, 0};
  model.bodies[0].w_WB_B = {0, kSpin, 0};
  Simulation s(model);
  const double slip = kSpeed - kRadius * kSpin;  // decays by 7/2 μ g
  const double time = slip / (3.5 * kFriction * kGravity), speed = kSpeed - 2.0 / 7 * slip;
  run(s, 1000);
  EXPECT_NEAR(s.state.bodies[0].v.x, speed, 1e-9);
  EXPECT_NEAR(s.state.bodies[0].w.y, speed / kRadius, 1e-8);
  const double way = kSpeed * time - 0.5 * kFriction * kGravity * time * time + speed * (1 - time);
  EXPECT_NEAR(s.state.bodies[0].p.x, way, 1e-9);
  EXPECT_EQ(s.state.contacts[0].closed, kPairSticks);
  EXPECT_NEAR(s.state.bodies[0].p.z, kRadius, 1e-12);
}

TEST(RigidFriction, ABallRollsDownAnInclineWithFiveSeventhsOfTheSlide) {
  const double tilt = 0.3;
  Model model = build_rolling_ball(0.3, 0);
  model.gravity.uniform = {kGravity * std::sin(tilt), 0, -kGravity * std::cos(tilt)};
  Simulation s(model);
  run(s, 1000);
  EXPECT_NEAR(s.state.bodies[0].v.x, 5.0 / 7 * kGravity * std::sin(tilt), 1e-10);
  Simulation smooth([&] {
    Model steep = model;
    steep.contacts[0].friction = 0.05;  // less than 2/7 tan
    return steep;
  }());
  run(smooth, 1000);
  EXPECT_NEAR(smooth.state.bodies[0].v.x, kGravity * (std::sin(tilt) - 0.05 * std::cos(tilt)), 1e-9);
  EXPECT_NEAR(smooth.state.bodies[0].w.y, 2.5 * 0.05 * kGravity * std::cos(tilt) / kRadius, 1e-8);
}

// Its spin about the normal turns the body by 0.09 rad a step: the point of contact then drifts by an error of the
// integration, which is no slip.
TEST(RigidFriction, ABallThatRollsAndSpinsAboutTheNormalDoesNotSlip) {
  Model model = build_rolling_ball(0.3, 0);
  model.gravity.uniform = {1.2, 0, -kGravity};  // less than 7/2 μ g along the floor
  model.bodies[0].w_WB_B = {0, 0, 9};
  PlanOptions options;
  options.dt = 0.01;
  Simulation s(model, options);
  run(s, 300);
  EXPECT_EQ(s.state.contacts[0].closed, kPairSticks);
  EXPECT_NEAR(s.state.bodies[0].v.x, 5.0 / 7 * 1.2 * 3, 1e-6);
  EXPECT_EQ(get_contact_totals(s.plan, s.state, 0).slip, 0);
}

// Newton's restitution along the normal; across it the impulse that stops the slip, or μ times the normal one.
TEST(RigidFriction, ASpinningBallHitsTheFloorAsTheClosedFormSays) {
  constexpr double kRestitution = 0.6, kHeight = 0.2;
  for (const double friction : {0.05, 0.5}) {
    Model model = build_rolling_ball(friction, kHeight, kRestitution);
    model.bodies[0].v_WB = {3, -2, 0};
    model.bodies[0].w_WB_B = {3, 5, 2};
    Simulation s(model);
    const double fall = std::sqrt(2 * kHeight / kGravity), blow = (1 + kRestitution) * kGravity * fall;
    run(s, 210);  // the fall takes 0.2019 s
    const double sx = 3 - kRadius * 5, sy = -2 + kRadius * 3, slip = std::hypot(sx, sy);
    const double p = std::min(friction * blow, slip / 3.5);
    const BodyState& body = s.state.bodies[0];
    EXPECT_NEAR(body.v.x, 3 - p * sx / slip, 1e-10) << friction;
    EXPECT_NEAR(body.v.y, -2 - p * sy / slip, 1e-10) << friction;
    EXPECT_NEAR(body.v.z, blow - kGravity * fall - kGravity * (0.21 - fall), 1e-8) << friction;
    const Vec3 w = rotation_matrix(body.q) * body.w;
    EXPECT_NEAR(w.x, 3 - p * sy / slip / (0.4 * kRadius), 1e-9) << friction;
    EXPECT_NEAR(w.y, 5 + p * sx / slip / (0.4 * kRadius), 1e-9) << friction;
    EXPECT_NEAR(w.z, 2, 1e-12) << friction;
  }
}

// A push that grows, ends and turns: the block sticks, slips, stops. Force against time is a triangle.
TEST(RigidFriction, ABlockThatIsPushedBreaksLooseWhereThePushOutgrowsTheCone) {
  constexpr double kFriction = 0.25, kRate = 20;  // N/s
  Model model = build_incline(kFriction, 0);
  Load push;
  push.name = "push";
  push.point = {0, 0, -0.25};  // at the height of the floor
  push.direction = {0.6, 0.8, 0};
  push.profile.kind = Profile::Kind::kTable;
  push.profile.times = {0, 1};
  push.profile.values = {0, kRate};
  model.loads.push_back(push);
  Simulation s(model);
  run(s, 500);
  const double start = kFriction * 2 * kGravity / kRate, t = 0.5 - start;
  ASSERT_LT(start, 0.5);
  EXPECT_NEAR(norm(s.state.bodies[0].v), 0.5 * kRate * t * t / 2, 1e-9);
  EXPECT_NEAR(s.state.bodies[0].v.y / s.state.bodies[0].v.x, 0.8 / 0.6, 1e-7);
}

// Painlevé's rod: where it slides with its tip ahead, friction would press the tip into the floor the more, the more it
// presses. Below 4/3 no rod does.
TEST(RigidFriction, ARodThatWedgesIsRefused) {
  const auto fly = [](double friction) {
    Model model = build_falling_rod(1.1);
    model.contacts[0].friction = friction;
    model.bodies[0].v_WB = {-1, 0, 0};
    Simulation s(model);
    StepReport report;
    for (int i = 0; i < 50 && report.status == StepStatus::kOk; ++i) report = s.advance();
    return report;
  };
  EXPECT_EQ(fly(1.0).status, StepStatus::kOk);
  const StepReport wedged = fly(2.5);
  EXPECT_EQ(wedged.status, StepStatus::kRigidContact);
  EXPECT_EQ(wedged.contact, 0);
  EXPECT_TRUE(wedged.wedged);
}

// Random blows of a spinning block and a ball, with friction: momenta, energy.
TEST(RigidFriction, ABlowKeepsMomentaAndGainsNoEnergy) {
  std::mt19937_64 random(7);
  const auto draw = [&] { return std::uniform_real_distribution<>(-1, 1)(random); };
  int blows = 0;
  for (int k = 0; k < 40; ++k) {
    Model model;
    model.name = "pair";
    for (const double side : {0.0, 0.6}) {
      Body body = box(side > 0 ? "ball" : "block", 1 + 0.5 * draw(), 0.02, 0.03, 0.025);
      body.p_WB = {side, 0.1 * draw(), 0.1 * draw()};
      body.q_WB = Eigen::Quaterniond(1, 0.2 * draw(), 0.2 * draw(), 0.2 * draw()).normalized();
      body.w_WB_B = {5 * draw(), 5 * draw(), 5 * draw()};
      body.v_WB = {side > 0 ? -4.0 : 0.0, 2 * draw(), 2 * draw()};
      model.bodies.push_back(body);
    }
    geometry::Shape block;
    block.kind = geometry::ShapeKind::kBox;
    block.size = {0.4, 0.5, 0.6};
    model.surfaces = {{"block", 0, {block}}, {"ball", 1, {build_sphere(0.2, {0.02, 0.03, -0.01})}}};
    model.contacts = {touch_rigidly("blow", 0, 1, 0.5 + 0.5 * draw())};
    model.contacts[0].friction = 0.5 + 0.5 * draw();
    add_contact_events(model);
    Simulation s(model);
    for (int i = 0; i < 200; ++i) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk) << "draw " << k;
      for (const EventAudit& audit : report.audits) {
        EXPECT_LT(norm(audit.jump.momentum), 1e-13);
        EXPECT_LT(norm(audit.jump.angular_momentum), 1e-13);
        EXPECT_NEAR(audit.jump.kinetic, audit.allowed.kinetic, 1e-12);
        EXPECT_LE(audit.allowed.kinetic, 1e-12);
        blows += audit.allowed.kinetic < 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(blows, 20);
}

// The rates of the slip's rows against differences of the slip itself, on bodies that move and turn, where it is zero.
TEST(RigidFriction, TheRowsOfTheSlipAreItsRates) {
  std::mt19937_64 random(13);
  const auto draw = [&] { return std::uniform_real_distribution<>(-1, 1)(random); };
  const auto draw_vec = [&] { return Vec3{draw(), draw(), draw()}; };
  std::vector<geometry::Shape> shapes(4);
  shapes[0] = build_floor();
  shapes[1] = build_sphere(0.4);
  shapes[2].kind = geometry::ShapeKind::kCapsule;
  shapes[2].from = {-1.5, 0, 0};
  shapes[2].to = {1.5, 0.1, 0};
  shapes[2].radius = 0.2;
  shapes[3] = shapes[2];
  geometry::Shape capsule = shapes[2];  // across shapes[3]
  capsule.from = {0.1, -0.9, -0.1};
  capsule.to = {0, 0.8, 0.1};
  for (std::size_t kind = 0; kind < shapes.size(); ++kind)
    for (int k = 0; k < 20; ++k) {
      Model model;
      model.name = "pair";
      for (int b = 0; b < 2; ++b) model.bodies.push_back(box(b > 0 ? "ball" : "other", 1, 1, 1, 1));
      model.bodies[1].p_WB = {0, 0, 5};
      const geometry::Shape ball = kind == 3 ? capsule : build_sphere(0.15, {0.1, -0.05, 0.2});
      model.surfaces = {{"other", 0, {shapes[kind]}}, {"ball", 1, {ball}}};
      model.contacts = {touch_rigidly("pair", k % 2, 1 - k % 2)};
      model.contacts[0].friction = 0.5;
      Simulation s(model);
      struct Motion {
        Vec3 p, v, a, w, alpha;
      } m[2];
      for (Motion& body : m) body = {0.3 * draw_vec(), draw_vec(), draw_vec(), draw_vec(), draw_vec()};
      m[1].p = m[0].p + Vec3{0.1 * draw(), 0.1 * draw(), 1.1};
      const auto get = [&](const Motion& body, double t) {
        const Vec3 turn = t * body.w + (0.5 * t * t) * body.alpha + (t * t * t / 12) * cross(body.alpha, body.w);
        const double angle = norm(turn);
        Mat3 R = kIdentity3;
        if (angle > 0) {
          const double half = 0.5 * angle, size = std::sin(half) / angle;
          R = rotation_matrix(Quat{std::cos(half), size * turn.x, size * turn.y, size * turn.z});
        }
        return BodyFrame{R, body.p + t * body.v + (0.5 * t * t) * body.a, body.v + t * body.a, body.w + t * body.alpha};
      };
      const int base = k % 2, follower = 1 - base;
      RigidRow rows[3];
      const auto calc = [&](double t) {
        const BodyFrame of_base = get(m[base], t), of_follower = get(m[follower], t);
        EXPECT_TRUE(calc_rigid_row(s.data(), 0, of_base, of_follower, rows[0]));
        calc_slip_rows(s.data(), {kPairSticks, 0}, {1, 0.2, 0}, of_base, of_follower, rows);
        return rows[1].rate * rows[1].along + rows[2].rate * rows[2].along;
      };
      // the slip and the gap's rate are brought to zero by the velocity of the ball
      const Vec3 slip = calc(0);
      const double side = dot(rows[1].on_follower.lin, rows[1].along) > 0 ? 1 : -1;
      m[follower].v = m[follower].v - side * (slip + rows[0].rate * rows[0].along);
      EXPECT_LT(norm(calc(0)), 1e-12);
      constexpr double kWidth = 1e-4, kError = 1e-5;
      const Vec3 expected = (0.5 / kWidth) * (calc(kWidth) - calc(-kWidth));
      calc(0);
      for (int i = 1; i <= 2; ++i) {
        const double rate =
            rows[i].bias + apply_rigid_row(rows[i], {m[base].a, m[base].alpha}, {m[follower].a, m[follower].alpha});
        EXPECT_NEAR(rate, dot(rows[i].along, expected), kError) << "kind " << kind << ", draw " << k;
      }
    }
}

// A block that lands on rough feet, rocks and comes to rest: bits, memory.
Model build_landing() {
  Model model = build_rigid_feet();
  model.contacts[0].restitution = 0.4;
  model.contacts[0].friction = 0.3;
  model.bodies[0].p_WB.z() += 0.01;
  model.bodies[0].v_WB = {0.5, 0.2, 0};
  model.bodies[0].w_WB_B = {0.3, -0.2, 0.5};
  return model;
}

TEST(RigidFriction, ALandingBlockComesToRest) {
  const Model model = build_landing();
  Simulation s(model);
  const double before = calc_energy(s, model);
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk) << i;
  EXPECT_LT(norm(s.state.bodies[0].v), 1e-12);
  EXPECT_LT(norm(s.state.bodies[0].w), 1e-12);
  EXPECT_NEAR(s.state.bodies[0].p.z, 0.25, 1e-9);
  EXPECT_NEAR(calc_energy(s, model), before, 1e-7);
}

// Blows on a body that rests on several rough feet may have impulses that are not found. Then the run ends: no motion
// is made up, and none gains energy until then.
TEST(RigidFriction, RandomStoolsOnRoughTablesGainNoEnergyOrAreRefused) {
  int touches = 0;
  for (int seed = 0; seed < 30; ++seed) {
    std::mt19937_64 random(static_cast<unsigned>(seed));
    Model model = build_random_stool([&] { return std::uniform_real_distribution<>(-1, 1)(random); }, 0.3 * (seed % 3));
    for (Contact& contact : model.contacts) contact.friction = 0.1 + 0.2 * (seed % 4);
    Simulation s(model);
    const double before = calc_energy(s, model);
    double latest = before;
    for (int i = 0; i < 1000; ++i) {
      const StepReport report = s.advance();
      if (report.status != StepStatus::kOk) {
        EXPECT_EQ(report.status, StepStatus::kRigidContact);
        EXPECT_GE(report.contact, 0);
        break;
      }
      if (report.postponed > 0) break;
      for (const EventAudit& audit : report.audits) EXPECT_LE(audit.allowed.kinetic, 1e-11);
      for (const FiredEvent& fired : report.events) touches += fired.event % 2 == 0 ? 1 : 0;
      latest = calc_energy(s, model);
    }
    EXPECT_NEAR(latest, before, 1e-6 * before) << "seed " << seed;
  }
  EXPECT_GT(touches, 50);
}

TEST(RigidFriction, StepsDoNotAllocate) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer has its own malloc";
  const Model model = build_landing();
  Simulation s(model);
  const AllocationCount count;
  for (int i = 0; i < 500; ++i) s.advance();
  EXPECT_EQ(count.get(), 0);
}

TEST(RigidFriction, ACopiedStateGoesOnWithTheSameBits) {
  const Model model = build_landing();
  Simulation whole(model);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 400; ++i) {
    whole.advance();
    hashes.push_back(calc_hash(whole.state));
  }
  for (const int at : {20, 60, 100, 250}) {
    Simulation first(model), second(model);
    for (int i = 0; i < at; ++i) first.advance();
    std::memcpy(second.state.get_bytes().data(), first.state.get_bytes().data(), first.state.get_bytes().size());
    for (int i = at; i < 400; ++i) {
      second.advance();
      ASSERT_EQ(calc_hash(second.state), hashes[static_cast<std::size_t>(i)]) << "from " << at << " at " << i;
    }
  }
}

TEST(RigidFriction, EveryWidthGivesTheSameBits) {
  const Model model = build_landing();
  std::vector<std::uint64_t> hashes;
  for (const InstructionSet set : {InstructionSet::kScalar, InstructionSet::kAuto}) {
    Simulation s(model, {.instruction_set = set});
    for (int i = 0; i < 300; ++i) s.advance();
    hashes.push_back(calc_hash(s.state));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace unlatch::test::rigid_friction_test
