// Rigid contacts of capsules that cross: closed forms, balances, what has no row.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"
#include "unlatch/energy.h"

namespace unlatch::test::rigid_capsules_test {
namespace {

constexpr double kPeg = 0.2, kRod = 0.05, kReach = kPeg + kRod;  // m, radii and their sum
constexpr double kTurn = 1.0 / 12;                               // kg m², of the rod of 1 kg across its axis

geometry::Shape build_capsule(const Vec3& from, const Vec3& to, double radius) {
  geometry::Shape shape;
  shape.kind = geometry::ShapeKind::kCapsule;
  shape.from = from;
  shape.to = to;
  shape.radius = radius;
  return shape;
}

// Builds a rod of 1 kg that lies on a fixed peg through the origin along `peg`, at rest. It points along x, `angle`
// above the horizontal; its centre is `along` beyond the place of touch.
Model build_rod_on_peg(const Vec3& peg, double along, double angle, double friction) {
  Model model;
  model.name = "rod on a peg";
  model.gravity.uniform = {0, 0, -kGravity};
  model.bodies.push_back(box("rod", 1, 1e-3, kTurn, kTurn));
  model.bodies[0].p_WB = {along * std::cos(angle) - kReach * std::sin(angle), 0,
                          along * std::sin(angle) + kReach * std::cos(angle)};
  model.bodies[0].q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY()));
  model.surfaces = {{"peg", kGround, {build_capsule(-2.0 * peg, 2.0 * peg, kPeg)}},
                    {"rod", 0, {build_capsule({-0.8, 0, 0}, {0.8, 0, 0}, kRod)}}};
  model.contacts = {touch_rigidly("rod on peg", 0, 1)};
  model.contacts[0].friction = friction;
  add_contact_events(model);
  return model;
}

double get_angle(const BodyState& rod) { return -2 * std::atan2(rod.q.y, rod.q.w); }
// Of the rod's centre beyond the place of touch, m.
double get_along(const BodyState& rod) {
  const double a = get_angle(rod);
  return rod.p.x * std::cos(a) + rod.p.z * std::sin(a);
}

struct Sliding {
  double s, angle, ds, dangle;
};

// Lagrange's equations of a rod that slides on a peg without friction, its centre ρ n + s t with the rod's direction t:
//   (J + s²) θ'' = ρ s θ'² − 2 s s' θ' − g s cos θ,   s'' = ρ θ'' + s θ'² − g sin θ   (for 1 kg).
Sliding integrate_sliding(Sliding y, double until) {
  constexpr int kSteps = 20000;
  const double h = until / kSteps;
  const auto f = [](const Sliding& at) {
    const double turn =
        (kReach * at.s * at.dangle * at.dangle - 2 * at.s * at.ds * at.dangle - kGravity * at.s * std::cos(at.angle)) /
        (kTurn + at.s * at.s);
    return Sliding{at.ds, at.dangle, kReach * turn + at.s * at.dangle * at.dangle - kGravity * std::sin(at.angle),
                   turn};
  };
  const auto add = [](const Sliding& a, double c, const Sliding& b) {
    return Sliding{a.s + c * b.s, a.angle + c * b.angle, a.ds + c * b.ds, a.dangle + c * b.dangle};
  };
  for (int i = 0; i < kSteps; ++i) {
    const Sliding k1 = f(y), k2 = f(add(y, h / 2, k1)), k3 = f(add(y, h / 2, k2)), k4 = f(add(y, h, k3));
    y = add(add(add(add(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  return y;
}

double calc_energy(Simulation& s) {
  EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  return calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0}).kinetic + kGravity * s.state.bodies[0].p.z;
}

void run(Simulation& s, double until, double dt) {
  for (int i = 0; i < std::lround(until / dt); ++i) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk) << "tick " << i;
    ASSERT_TRUE(report.events.empty()) << "tick " << i;
  }
}

TEST(RigidCapsules, ARodSlidesOverAPegWithOrderFour) {
  constexpr double kUntil = 0.3, kAlong = 0.1, kAngle = 0.2;
  const Sliding expected = integrate_sliding({kAlong, kAngle, 0, 0}, kUntil);
  double errors[3];
  for (int k = 0; k < 3; ++k) {
    const double dt = 0.01 / (1 << k);
    Simulation s(build_rod_on_peg({0, 1, 0}, kAlong, kAngle, 0), {.dt = dt});
    ASSERT_EQ(s.state.contacts[0].closed, 1);
    run(s, kUntil, dt);
    const BodyState& rod = s.state.bodies[0];
    errors[k] = std::max(std::abs(get_angle(rod) - expected.angle), std::abs(get_along(rod) - expected.s));
    EXPECT_NEAR(calc_shape_distance(s.plan, s.state, 0, 1).least.distance, 0, 1e-12);
    EXPECT_NEAR(rod.p.y, 0, 1e-12);
  }
  EXPECT_LT(errors[2], 1e-8);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 4, 0.6) << errors[k];
}

// Without slip the centre moves by R θ along the rod: one degree of freedom, (m r² + m R² θ² + J) θ'²/2 + m g (ρ cos θ
// + R θ sin θ) stays.
TEST(RigidCapsules, ARodRocksOnAPegWithoutSlip) {
  constexpr double kAngle = 0.3, kDt = 1e-3;
  const auto calc_potential = [](double a) { return kGravity * (kReach * std::cos(a) + kPeg * a * std::sin(a)); };
  Simulation s(build_rod_on_peg({0, 1, 0}, kPeg * kAngle, kAngle, 0.8), {.dt = kDt});
  bool other_side = false;
  for (int i = 0; i < 2000; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk) << "tick " << i;
    ASSERT_EQ(s.state.contacts[0].closed, 3) << "it sticks, tick " << i;
    const BodyState& rod = s.state.bodies[0];
    const double a = get_angle(rod), mass = kRod * kRod + kPeg * kPeg * a * a + kTurn;
    EXPECT_NEAR(get_along(rod), kPeg * a, 1e-9);
    EXPECT_NEAR(0.5 * mass * rod.w.y * rod.w.y + calc_potential(a), calc_potential(kAngle), 1e-9) << "tick " << i;
    other_side = other_side || a < -0.29;
  }
  EXPECT_TRUE(other_side);
}

TEST(RigidCapsules, ARodThatSlidesAndTurnsOverASkewPegKeepsItsEnergyWithOrderFour) {
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const double dt = 0.01 / (1 << k);
    Model model = build_rod_on_peg({0.4, 1, 0}, 0.05, 0, 0);
    model.bodies[0].w_WB_B = {2, 0, 3};
    Simulation s(model, {.dt = dt});
    ASSERT_EQ(s.state.contacts[0].closed, 1);
    const double before = calc_energy(s);
    run(s, 0.2, dt);
    errors[k] = std::abs(calc_energy(s) - before);
    EXPECT_NEAR(calc_shape_distance(s.plan, s.state, 0, 1).least.distance, 0, 1e-12);
  }
  EXPECT_LT(errors[1], 1e-7);
  EXPECT_GT(errors[0] / errors[1], 12) << errors[0];
}

// p = (1 + e) v / (1/m + s²/J).
TEST(RigidCapsules, ABlowOfCrossingRodsHasTheImpulseOfTheClosedForm) {
  constexpr double kAlong = 0.3, kRestitution = 0.5;
  Model model = build_rod_on_peg({0, 1, 0}, kAlong, 0, 0);
  model.gravity.uniform = {0, 0, 0};
  model.contacts[0].restitution = kRestitution;
  model.bodies[0].p_WB.z() += 0.05;
  model.bodies[0].v_WB = {0, 0, -1};
  Simulation s(model);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const double impulse = (1 + kRestitution) / (1 + kAlong * kAlong / kTurn);
  EXPECT_NEAR(s.state.bodies[0].v.z, -1 + impulse, 1e-10);
  EXPECT_NEAR(s.state.bodies[0].w.y, kAlong * impulse / kTurn, 1e-9);
  EXPECT_NEAR(get_contact_totals(s.plan, s.state, 0).impulse, impulse, 1e-10);
}

TEST(RigidCapsules, ParallelOnesHaveNoRowAndTheStepFailsWithThatReason) {
  Model model = build_rod_on_peg({0, 1, 0}, 0, 0, 0);
  model.bodies[0].p_WB.z() += 0.01;
  model.bodies[0].q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(std::acos(-1.0) / 2, Eigen::Vector3d::UnitZ()));
  Simulation s(model);
  StepReport report;
  for (int i = 0; i < 100 && report.status == StepStatus::kOk; ++i) report = s.advance();
  EXPECT_EQ(report.status, StepStatus::kRigidContact);
  EXPECT_TRUE(report.degenerate);
  EXPECT_FALSE(report.wedged);
  EXPECT_EQ(report.contact, 0);
}

}  // namespace
}  // namespace unlatch::test::rigid_capsules_test
