// Flight near a planet: starts against what was asked for, orbits against their integrals, clearances far from the
// centre, mistakes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "kernel/environment/environment.h"
#include "kernel/quantities/quantities.h"
#include "tests/kernel/flight_support.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/quantities.h"

namespace unlatch::test::flight_test {
namespace {

using Eigen::Vector3d;
using Kind = Quantity::Kind;
using Long = long double;

// --- Starts and quantities -------------------------------------------------------------------------------------------

Quantity make(Kind kind, int subject, int other = kGround, int part = Quantity::kSize) {
  Quantity q;
  q.name = "q";
  q.kind = kind;
  q.subject = subject;
  q.other = other;
  q.part = part;
  return q;
}

// Two bodies, the second turned and moving beside the first.
Model build_pair() {
  Model model;
  model.name = "pair";
  model.bodies = {box("stage", 500, 100, 300, 310), box("satellite", 20, 2, 3, 4)};
  model.bodies[0].p_WB = {3, -1, 2};
  model.bodies[0].q_WB = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
  model.bodies[0].w_WB_B = {0.01, 0.02, -0.03};
  model.bodies[1].p_WB = {4, -1, 2.5};
  model.bodies[1].v_WB = {0.3, 0.1, 0};
  model.bodies[1].q_WB = Eigen::Quaterniond(0.6, 0, 0.8, 0);
  model.environment.planet = Planet{};
  model.environment.atmosphere = Atmosphere{};
  model.environment.wind = Wind{{0}, {{5, -10, 1}}};
  model.environment.planet->meridian = 0.7;
  return model;
}

Start draw_start(Random& random) {
  Start start;
  start.latitude = random.uniform(-1.5, 1.5);
  start.longitude = random.uniform(-3.1, 3.1);
  start.altitude = random.uniform(-100, 9e5);
  start.velocity = random.uniform(10, 9000) * draw_direction(random);
  start.inertial = random.chance(0.5);
  start.euler = Vector3d(random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3));
  start.rate = 0.1 * draw_direction(random);
  start.turns = static_cast<Start::Turns>(static_cast<int>(random.uniform(0, 2.999)));
  start.body = random.chance(0.5) ? 0 : kGround;
  return start;
}

// Values at the start, in the order of `quantities`.
std::vector<double> read_at_start(Model model, const std::vector<Quantity>& quantities) {
  for (Quantity q : quantities) {
    q.name += std::to_string(model.quantities.size());
    model.quantities.push_back(q);
  }
  Simulation s(model);
  EXPECT_EQ(evaluate_state(s), kNone);
  std::vector<double> values;
  const Inputs inputs{s.commands};
  for (const PlanQuantity& own : s.data().quantities)
    values.push_back(calc_scalar({s.data(), inputs, s.state, 0.0}, s.evaluation(), own));
  return values;
}

TEST(Flight, AStartIsWhereItWasAskedForInAllFrames) {
  constexpr double kRounding = 2e-9;  // of 6.4e6 m
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    Start start = draw_start(random);
    start.body = 0;
    start.turns = Start::Turns::kInertial;
    const Vector3d v = start.velocity;
    for (const Start::Origin origin : {Start::Origin::kKept, Start::Origin::kStart, Start::Origin::kFalling}) {
      if (origin == Start::Origin::kFalling && v.norm() + 500 > 7500) continue;  // no ellipse
      start.origin = origin;
      const Model model = place_start(build_pair(), start);
      ASSERT_TRUE(validate(model).empty()) << validate(model).front().what;
      const Kind angle = start.inertial ? Kind::kInertialFlightPathAngle : Kind::kFlightPathAngle,
                 azimuth = start.inertial ? Kind::kInertialAzimuth : Kind::kAzimuth,
                 speed = start.inertial ? Kind::kInertialVelocity : Kind::kSurfaceVelocity;
      const std::vector<double> got =
          read_at_start(model, {make(Kind::kAltitude, 0), make(Kind::kLatitude, 0), make(Kind::kLongitude, 0),
                                make(speed, 0), make(angle, 0), make(azimuth, 0),
                                make(Kind::kEulerAngles, 0, kGround, 0), make(Kind::kEulerAngles, 0, kGround, 1),
                                make(Kind::kEulerAngles, 0, kGround, 2), make(Kind::kRate, 0)});
      const double expected[] = {start.altitude,
                                 start.latitude,
                                 start.longitude,
                                 v.norm(),
                                 std::atan2(-v.z(), std::hypot(v.x(), v.y())),
                                 std::atan2(v.y(), v.x()),
                                 start.euler->x(),
                                 start.euler->y(),
                                 start.euler->z(),
                                 start.rate.norm()};
      for (std::size_t k = 0; k < got.size(); ++k)
        EXPECT_NEAR(got[k], expected[k], kRounding * (1 + std::abs(expected[k]) / 1e3)) << "seed 5, " << i << ", " << k;
    }
  }
}

// What bodies are to each other does not change.
TEST(Flight, AnAssemblyMovesToItsStartAsOne) {
  constexpr double kRounding = 1e-8;
  Random random(6);
  const std::vector<Quantity> seen{make(Kind::kPosition, 1, 0, 0), make(Kind::kPosition, 1, 0, 1),
                                   make(Kind::kPosition, 1, 0, 2), make(Kind::kRate, 1, 0),
                                   make(Kind::kAttitude, 1, 0)};
  const std::vector<double> before = read_at_start(build_pair(), seen);
  for (int i = 0; i < 60; ++i) {
    const Model model = place_start(build_pair(), draw_start(random));
    const std::vector<double> after = read_at_start(model, seen);
    for (std::size_t k = 0; k < seen.size(); ++k) EXPECT_NEAR(after[k], before[k], kRounding) << "seed 6, " << i;
    const auto drift = [](const Model& m) {  // v₂ − v₁ − w₁ × (p₂ − p₁), in axes of the first body
      const Body &a = m.bodies[0], &b = m.bodies[1];
      const Eigen::Matrix3d R = a.q_WB.toRotationMatrix();
      return Vector3d(R.transpose() * (b.v_WB - a.v_WB - (R * a.w_WB_B).cross(b.p_WB - a.p_WB)));
    };
    EXPECT_LT((drift(model) - drift(build_pair())).norm(), kRounding);
  }
}

TEST(Flight, AirAsABodyMeetsItFollowsFromItsVelocityAndTheWind) {
  Start start;
  start.body = 0;
  start.altitude = 10e3;
  start.velocity = {200, 30, -40};
  start.euler = Vector3d(0.1, -0.2, 0.3);
  const std::vector<double> got = read_at_start(
      place_start(build_pair(), start),
      {make(Kind::kAirspeed, 0), make(Kind::kMach, 0), make(Kind::kDynamicPressure, 0), make(Kind::kAngleOfAttack, 0),
       make(Kind::kSideslip, 0), make(Kind::kAirVelocity, 0, kGround, 0), make(Kind::kDensity, 0)});
  const Vector3d through = start.velocity - Vector3d(5, -10, 1);
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.3, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.2, Vector3d::UnitY()) *
                             Eigen::AngleAxisd(0.1, Vector3d::UnitX()))
                                .toRotationMatrix();
  const Vector3d u = R.transpose() * through;
  const AirState air = calc_air(Atmosphere{}, 10e3);
  const double expected[] = {u.norm(),
                             u.norm() / air.speed_of_sound,
                             0.5 * air.density * u.squaredNorm(),
                             std::atan2(u.z(), u.x()),
                             std::asin(u.y() / u.norm()),
                             u.x(),
                             air.density};
  for (std::size_t k = 0; k < got.size(); ++k)
    EXPECT_NEAR(got[k], expected[k], 1e-9 * (1 + std::abs(expected[k]))) << k;
}

// --- Orbits ----------------------------------------------------------------------------------------------------------

// A satellite at 300 km; one step is 5 s, a thousandth of a revolution.
Model build_orbit(double j2, Start::Origin origin) {
  Model model;
  model.bodies = {box("satellite", 20, 2, 3, 4)};
  model.environment.planet = Planet{.j2 = j2};
  Start start;
  start.latitude = 0.3;
  start.altitude = 300e3;
  start.velocity = {5500, 5500, 0};
  start.inertial = true;
  start.origin = origin;
  return place_start(model, start);
}

struct Integrals {
  double energy;
  Vec3 moment;
};
Integrals calc_integrals(const Planet& planet, const Simulation& s) {
  const PlanPlanet own = compile_planet(planet);
  const OriginMotion origin = calc_origin(own, s.get_time());
  const Vec3 r = origin.r + s.state.bodies[0].p, v = origin.v + s.state.bodies[0].v;
  const double potential = -static_cast<double>(calc_potential(planet, to_eigen(r)));
  return {0.5 * dot(v, v) + potential, cross(r, v)};
}

TEST(Flight, EnergyAndMomentumHoldOverAHundredRevolutions) {
  constexpr double kStep = 5;
  constexpr double kMethod = 2e-8;  // error of Runge–Kutta's fourth order in a hundred revolutions at this step
  for (const double j2 : {0.0, 1.08262982e-3}) {
    const Model model = build_orbit(j2, Start::Origin::kKept);
    Simulation s(model, {.dt = kStep});
    const Integrals before = calc_integrals(*model.environment.planet, s);
    for (int i = 0; i < 100 * 5400 / 5; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    const Integrals after = calc_integrals(*model.environment.planet, s);
    EXPECT_NEAR(after.energy / before.energy, 1, kMethod) << j2;
    EXPECT_NEAR(after.moment.z / before.moment.z, 1, kMethod) << j2;
    if (j2 == 0) {
      EXPECT_LT(norm(after.moment - before.moment), kMethod * norm(before.moment));
    } else {
      EXPECT_GT(norm(after.moment - before.moment), 0.1 * norm(before.moment));  // the node turns
    }
  }
}

TEST(Flight, AFallingOriginSeesTheSameOrbit) {
  const Model kept = build_orbit(1.08262982e-3, Start::Origin::kKept),
              falls = build_orbit(1.08262982e-3, Start::Origin::kFalling);
  Simulation a(kept, {.dt = 1}), b(falls, {.dt = 1});
  for (int i = 0; i < 3000; ++i)
    ASSERT_TRUE(a.advance().status == StepStatus::kOk && b.advance().status == StepStatus::kOk);
  const OriginMotion origin = calc_origin(b.data().environment.planet, b.get_time());
  EXPECT_LT(norm(a.state.bodies[0].p - (origin.r + b.state.bodies[0].p)), 2e-6);  // rounding of 3000 steps at 6.7e6 m
  EXPECT_LT(norm(a.state.bodies[0].v - (origin.v + b.state.bodies[0].v)), 1e-8);
  EXPECT_GT(norm(b.state.bodies[0].p), 1e4);  // J2 moves it away
  EXPECT_LT(norm(a.state.bodies[0].w), 1e-3);
}

// Two spheres at rest beside each other for 10 s, the first of them on a circular orbit. The expected distance is
// integrated in long double from the difference of the two fields.
double integrate_distance(const Planet& planet, Long height, double t) {
  const Long mu = planet.mu, R = Long(planet.radius) + height, n = std::sqrt(mu / (R * R * R));
  const int steps = 1000;
  const Long h = t / Long(steps);
  using Pair = std::array<Long, 4>;  // up and along at the start, and their rates; axes at rest
  const auto flow = [&](Long time, const Pair& y) -> Pair {
    const Long o[2] = {R * std::cos(n * time), R * std::sin(n * time)}, r[2] = {o[0] + y[0], o[1] + y[1]};
    const Long r2 = r[0] * r[0] + r[1] * r[1], there = mu / (r2 * std::sqrt(r2)), here = n * n;
    return {y[2], y[3], (here - there) * o[0] - there * y[0], (here - there) * o[1] - there * y[1]};
  };
  const auto shift = [](const Pair& y, Long by, const Pair& k) {
    return Pair{y[0] + by * k[0], y[1] + by * k[1], y[2] + by * k[2], y[3] + by * k[3]};
  };
  Pair y{-0.5L, 1, 0, 0};
  for (int i = 0; i < steps; ++i) {
    const Pair a = flow(i * h, y), b = flow((i + 0.5L) * h, shift(y, h / 2, a)),
               c = flow((i + 0.5L) * h, shift(y, h / 2, b)), d = flow((i + 1) * h, shift(y, h, c));
    for (std::size_t k = 0; k < 4; ++k) y[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
  }
  return static_cast<double>(std::sqrt(y[0] * y[0] + y[1] * y[1]));
}

TEST(Flight, ClearancesKeepTheirDigitsSixThousandKilometresFromTheCentre) {
  constexpr double kRadius = 0.25, kTime = 10, kStep = 0.01;
  Model pair;
  pair.bodies = {box("a", 20, 2, 3, 4), box("b", 20, 2, 3, 4)};
  pair.bodies[1].p_WB = {1, 0, 0.5};
  for (int i = 0; i < 2; ++i) {
    geometry::Shape ball;
    ball.radius = kRadius;
    pair.surfaces.push_back({.name = std::to_string(i), .body = i, .shapes = {ball}});
  }
  pair.environment.planet = Planet{.flattening = 0, .j2 = 0};
  pair.quantities = {make(Kind::kClearance, 0, 1)};
  Start start;
  start.altitude = 320e3;
  const double radius = pair.environment.planet->radius + start.altitude;
  start.velocity = {0, std::sqrt(pair.environment.planet->mu / radius), 0};
  start.inertial = true;
  const double exact = integrate_distance(*pair.environment.planet, 320e3L, kTime) - 2 * kRadius;
  EXPECT_GT(std::abs(exact - (std::sqrt(1.25) - 2 * kRadius)), 1e-5);
  // At the centre, 1000 roundings of 9e-10 m; at the start, after 77 km, of 1e-11 m.
  for (const auto& [origin, error] : {std::pair(Start::Origin::kFalling, 2e-13), std::pair(Start::Origin::kStart, 1e-9),
                                      std::pair(Start::Origin::kKept, 5e-8)}) {
    start.origin = origin;
    Simulation s(place_start(pair, start), {.dt = kStep});
    for (int i = 0; i < static_cast<int>(kTime / kStep); ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_NEAR(s.workspace.quantities[0], exact, error) << static_cast<int>(origin);
  }
}

// --- Mistakes --------------------------------------------------------------------------------------------------------

TEST(Flight, MistakesNameTheirKeys) {
  const auto expect = [](const char* what, const auto& spoil) {
    Model model = build_pair();
    spoil(model);
    const std::vector<ModelError> errors = validate(model);
    ASSERT_FALSE(errors.empty()) << what;
    EXPECT_NE(errors.front().what.find(what), std::string::npos) << errors.front().what;
  };
  expect("radius is 0", [](Model& m) { m.environment.planet->radius = 0; });
  expect("flattening is 1", [](Model& m) { m.environment.planet->flattening = 1; });
  expect("pole has the length 2", [](Model& m) { m.environment.planet->pole *= 2; });
  expect("two central fields", [](Model& m) { m.gravity.mu = 1; });
  expect("follows no ellipse", [](Model& m) { m.environment.planet->falling = true; });
  expect("altitudes do not rise", [](Model& m) {
    m.environment.atmosphere = Atmosphere{Atmosphere::Kind::kTable, {1, 0}, {1, 1}, {1, 1}};
  });
  expect("a density or pressure is 0", [](Model& m) {
    m.environment.atmosphere = Atmosphere{Atmosphere::Kind::kTable, {0, 1}, {1, 0}, {1, 1}};
  });
  expect("no planet", [](Model& m) { m.environment.planet.reset(); });
  expect("mach is of the air", [](Model& m) {
    m.environment.atmosphere.reset();
    m.quantities = {make(Kind::kMach, 0)};
  });
}

}  // namespace
}  // namespace unlatch::test::flight_test
