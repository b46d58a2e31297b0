// The environment: places on the planet against GeographicLib where it is installed, the air against the published
// standard, gravity against the gradient of its potential, orbits against their integrals, starts against what was
// asked for.
#include "unlatch/environment.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "kernel/environment/environment.h"
#include "kernel/quantities/quantities.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/quantities.h"

#ifdef UNLATCH_GEOGRAPHIC
#include <GeographicLib/Geocentric.hpp>
#endif

namespace unlatch::test {
namespace {

using Eigen::Vector3d;
using Kind = Quantity::Kind;
using Long = long double;

constexpr double kDegree = std::numbers::pi / 180;

Vector3d to_eigen(const Vec3& v) { return {v.x, v.y, v.z}; }

Vector3d draw_direction(Random& random) {
  const double z = random.uniform(-1, 1), turn = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double across = std::sqrt(1 - z * z);
  return {across * std::cos(turn), across * std::sin(turn), z};
}

Eigen::Matrix3d draw_rotation(Random& random) {
  return Eigen::AngleAxisd(random.uniform(0, 3), draw_direction(random)).toRotationMatrix();
}

// --- Places ----------------------------------------------------------------------------------------------------------

#ifdef UNLATCH_GEOGRAPHIC
TEST(Environment, PlacesAgreeWithGeographicLib) {
  constexpr double kAngle = 1e-15;   // rad: two ulp of the largest latitude
  constexpr double kLength = 4e-15;  // of the distance from the centre
  const double ranges[][2] = {{-5e6, -1e6}, {-1e6, -1e4}, {-1e4, 1e5}, {1e5, 1e6}, {1e6, 1e8}, {1e8, 1e11}};
  Random random(1);
  for (const double flattening : {1 / 298.257223563, 1 / 9.8, 0.0}) {
    Planet planet;
    planet.flattening = flattening;
    const GeographicLib::Geocentric oracle(planet.radius, flattening);
    for (const auto& [low, high] : ranges)
      for (int i = 0; i < 20000; ++i) {
        if (flattening > 0.1 && low < 0) break;  // its evolute is as large as a third of it
        const double latitude = std::asin(random.uniform(-1, 1)), longitude = random.uniform(-179, 179) * kDegree,
                     altitude = random.uniform(low, high);
        Vector3d at;
        oracle.Forward(latitude / kDegree, longitude / kDegree, altitude, at.x(), at.y(), at.z());
        const GeodeticPoint point = calc_geodetic(planet, at);
        double expected[3];
        oracle.Reverse(at.x(), at.y(), at.z(), expected[0], expected[1], expected[2]);
        ASSERT_NEAR(point.latitude, expected[0] * kDegree, kAngle) << altitude;
        ASSERT_NEAR(point.longitude, expected[1] * kDegree, kAngle);
        ASSERT_NEAR(point.altitude, expected[2], kLength * at.norm()) << latitude;
        ASSERT_LT((calc_point(planet, {latitude, longitude, altitude}) - at).norm(), kLength * at.norm());
      }
  }
}
#endif

TEST(Environment, PolesAndCentreHavePlaces) {
  const Planet planet;
  const double b = planet.radius * (1 - planet.flattening);
  const GeodeticPoint pole = calc_geodetic(planet, {0, 0, -(b + 100)});
  EXPECT_DOUBLE_EQ(pole.latitude, -std::numbers::pi / 2);
  EXPECT_NEAR(pole.altitude, 100, 1e-8);
  EXPECT_NEAR(calc_geodetic(planet, {0, planet.radius + 7, 0}).altitude, 7, 1e-8);
  EXPECT_TRUE(std::isfinite(calc_geodetic(planet, {0, 0, 0}).altitude));
}

// --- Air -------------------------------------------------------------------------------------------------------------

// US Standard Atmosphere 1976 (NOAA-S/T 76-1562), table I: geometric altitude, m; K, Pa, kg/m³, m/s.
struct Published {
  double altitude, temperature, pressure, density, sound;
};
constexpr Published kStandard[] = {
    {-5000, 320.676, 1.7776e5, 1.9311, 358.986},    {0, 288.150, 1.01325e5, 1.2250, 340.294},
    {1000, 281.651, 8.9876e4, 1.1117, 336.435},     {5000, 255.676, 5.4048e4, 7.3643e-1, 320.545},
    {10000, 223.252, 2.6500e4, 4.1351e-1, 299.532}, {15000, 216.650, 1.2112e4, 1.9476e-1, 295.069},
    {20000, 216.650, 5.5293e3, 8.8910e-2, 295.069}, {25000, 221.552, 2.5492e3, 4.0084e-2, 298.389},
    {30000, 226.509, 1.1970e3, 1.8410e-2, 301.709}, {40000, 250.350, 2.8714e2, 3.9957e-3, 317.189},
    {50000, 270.650, 7.9779e1, 1.0269e-3, 329.799}, {60000, 247.021, 2.1959e1, 3.0968e-4, 315.07},
    {70000, 219.585, 5.2209, 8.2829e-5, 297.06},    {80000, 198.639, 1.0525, 1.8458e-5, 282.54}};

TEST(Environment, AirIsThatOfTheStandardToItsDigits) {
  constexpr double kFifthDigit = 6e-5, kKelvin = 6e-4,
                   kSound = 6e-3;  // half of the last digit, and the table's rounding
  for (const Published& row : kStandard) {
    const AirState air = calc_air(Atmosphere{}, row.altitude);
    EXPECT_NEAR(air.temperature, row.temperature, kKelvin) << row.altitude;
    EXPECT_NEAR(air.pressure / row.pressure, 1, kFifthDigit) << row.altitude;
    EXPECT_NEAR(air.density / row.density, 1, kFifthDigit) << row.altitude;
    EXPECT_NEAR(air.speed_of_sound, row.sound, kSound) << row.altitude;
  }
  const double upper[][3] = {
      {100e3, 3.2011e-2, 5.604e-7}, {200e3, 8.4736e-5, 2.541e-10}, {1000e3, 7.5138e-9, 3.561e-15}};
  for (const auto& [altitude, pressure, density] : upper) {
    EXPECT_NEAR(calc_air(Atmosphere{}, altitude).pressure / pressure, 1, 1e-12) << altitude;
    EXPECT_NEAR(calc_air(Atmosphere{}, altitude).density / density, 1, 1e-12) << altitude;
  }
}

TEST(Environment, AirHasNoJumpsAndFallsWithTheAltitude) {
  constexpr double kStep = 10;  // m
  AirState below = calc_air(Atmosphere{}, -6000);
  for (double z = -6000 + kStep; z < 1.2e6; z += kStep) {
    const AirState air = calc_air(Atmosphere{}, z);
    if (z > -5000) {
      ASSERT_LT(air.density, below.density) << z;
      ASSERT_LT(air.pressure, below.pressure) << z;
    }
    ASSERT_GT(air.density, 0.99 * below.density) << z;  // a scale height is above 4 km
    ASSERT_LT(std::abs(air.temperature - below.temperature), 0.3) << z;
    below = air;
  }
}

TEST(Environment, TablesOfAirGoThroughTheirRowsAndReproduceExponentials) {
  Atmosphere table;
  table.kind = Atmosphere::Kind::kTable;
  for (const double z : {0.0, 1e3, 4e3, 5e3, 9e3, 20e3}) {
    table.altitudes.push_back(z);
    table.densities.push_back(1.2 * std::exp(-z / 7000));
    table.pressures.push_back(1e5 * std::exp(-z / 7000));
  }
  for (double z = 0; z < 40e3; z += 137) {
    EXPECT_NEAR(calc_air(table, z).density / (1.2 * std::exp(-z / 7000)), 1, 1e-13) << z;
    EXPECT_NEAR(calc_air(table, z).pressure / (1e5 * std::exp(-z / 7000)), 1, 1e-13) << z;
  }
  EXPECT_EQ(calc_air(table, -500).density, calc_air(table, 0).density);
}

TEST(Environment, WindIsLinearBetweenItsAltitudes) {
  const WindKnot wind[] = {{1000, {1, 2, 3}}, {3000, {3, 0, -1}}};
  const auto expect = [&](double z, const Vector3d& v) {
    EXPECT_LT((to_eigen(calc_wind(wind, z)) - v).norm(), 1e-14) << z;
  };
  expect(0, {1, 2, 3});
  expect(1500, {1.5, 1.5, 2});
  expect(5000, {3, 0, -1});
}

// --- Gravity ---------------------------------------------------------------------------------------------------------

// −potential, long double so that differences of it keep their digits.
Long calc_potential(const Planet& planet, const Vector3d& at) {
  const Long x = at.x(), y = at.y(), z = at.z(), r = std::sqrt(x * x + y * y + z * z);
  const Vector3d& n = planet.pole;
  const Long s = (x * Long(n.x()) + y * Long(n.y()) + z * Long(n.z())) / r, a = Long(planet.radius) / r;
  return Long(planet.mu) / r * (1 - Long(planet.j2) * a * a * (3 * s * s - 1) / 2);
}

Planet tilt(double j2) {
  Planet planet;
  planet.j2 = j2;
  planet.pole = Vector3d(1, 2, -2) / 3;
  return planet;
}

TEST(Environment, GravityIsTheGradientOfItsPotential) {
  constexpr double kDifference = 2e-9;  // m/s²: rounding of the difference quotient
  Random random(2);
  for (const double j2 : {0.0, 1.0e-3, 0.2}) {
    const Planet planet = tilt(j2);
    const PlanPlanet own = compile_planet(planet);
    for (int i = 0; i < 200; ++i) {
      const Vector3d at = 6.5e6 * random.uniform(1, 3) * draw_direction(random);
      const Vec3 g = calc_planet_gravity(own, 0, {at.x(), at.y(), at.z()});
      for (int k = 0; k < 3; ++k) {
        const Vector3d h = 64 * Vector3d::Unit(k);
        const Long slope = (8 * (calc_potential(planet, at + h) - calc_potential(planet, at - h)) -
                            (calc_potential(planet, at + 2 * h) - calc_potential(planet, at - 2 * h))) /
                           (12 * 64);
        ASSERT_NEAR(static_cast<double>(slope), to_eigen(g)[k], kDifference);
      }
    }
  }
}

// Six masses on the axes: the sum of r × m g against the torque of their inertia.
TEST(Environment, TheGradientTorqueIsThatOfTheWeightsOfItsParts) {
  constexpr double kArm = 40, kMass = 10;
  constexpr double kNextOrder = 3e-5;  // arm / radius, of the torque: the third derivative
  Random random(3);
  for (const double j2 : {0.0, 1.0e-3, 0.2}) {
    const PlanPlanet planet = compile_planet(tilt(j2));
    for (int i = 0; i < 100; ++i) {
      const Vector3d at = 7e6 * draw_direction(random);
      const Eigen::Matrix3d R = draw_rotation(random);
      const Vector3d arms = Vector3d(1, 0.5, 0.2) * kArm;
      Vector3d sum = Vector3d::Zero();
      Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
      for (int k = 0; k < 6; ++k) {
        const Vector3d r = (k < 3 ? 1 : -1) * arms[k % 3] * R.col(k % 3), p = at + r;
        sum += kMass * r.cross(to_eigen(calc_planet_gravity(planet, 0, {p.x(), p.y(), p.z()}) -
                                        calc_planet_gravity(planet, 0, {at.x(), at.y(), at.z()})));
        J += kMass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
      }
      const Vec3 torque = calc_gradient_torque(planet, 0, {at.x(), at.y(), at.z()},
                                               {J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2)});
      const double scale = 3 * planet.mu / std::pow(at.norm(), 3) * J.norm();
      ASSERT_LT((to_eigen(torque) - sum).norm(), kNextOrder * scale) << "seed 3, " << i;
    }
  }
}

Planet fall(double eccentric) {
  Planet planet;
  planet.j2 = 0;
  planet.falling = true;
  planet.centre = {-6.7e6, 1e5, 2e5};
  const double speed = std::sqrt(planet.mu / planet.centre.norm() * (1 + eccentric));
  planet.velocity = speed * Vector3d(0.1, 0.6, -0.8).normalized();
  return planet;
}

TEST(Environment, TheFallingOriginKeepsItsEnergyAndMomentumAndReturns) {
  constexpr double kRounding = 1e-13;
  constexpr double kDifference = 1e-3;  // m/s: h² r''' / 6 near the lowest point
  for (const double eccentric : {-0.5, 0.0, 0.2, 0.7}) {
    const PlanPlanet planet = compile_planet(fall(eccentric));
    const Vec3 moment = cross(planet.origin, planet.velocity);
    const double energy = 0.5 * dot(planet.velocity, planet.velocity) - planet.mu / norm(planet.origin);
    const double period = 2 * std::numbers::pi / planet.mean_motion;
    for (int i = 0; i <= 300; ++i) {
      const OriginMotion now = calc_origin(planet, 0.0137 * i * period);
      ASSERT_NEAR((0.5 * dot(now.v, now.v) - planet.mu / norm(now.r)) / energy, 1, kRounding);
      ASSERT_LT(norm(cross(now.r, now.v) - moment), kRounding * norm(moment));
    }
    const OriginMotion back = calc_origin(planet, 7 * period);
    EXPECT_LT(norm(back.r - planet.origin), 1e-6);
    const double h = 0.25;  // s: rates are those of places
    const Vec3 rate = (1 / (2 * h)) * (calc_origin(planet, 500 + h).r - calc_origin(planet, 500 - h).r);
    EXPECT_LT(norm(rate - calc_origin(planet, 500).v), kDifference);
  }
}

// Against the difference of the two fields in long double.
TEST(Environment, TheFieldBesideAFallingOriginLosesNoDigits) {
  constexpr double kRelative = 2e-15;
  Random random(4);
  const PlanPlanet planet = compile_planet(fall(0.2));
  for (const double distance : {1e-3, 1.0, 1e3, 1e5, 3e6}) {
    for (int i = 0; i < 100; ++i) {
      const double t = random.uniform(0, 6000);
      const Vec3 o = calc_origin(planet, t).r;
      const Vector3d p = distance * draw_direction(random);
      const Long r[] = {Long(o.x) + p.x(), Long(o.y) + p.y(), Long(o.z) + p.z()};
      const Long o3 = std::pow(Long(o.x) * o.x + Long(o.y) * o.y + Long(o.z) * o.z, 1.5L);
      const Long r3 = std::pow(r[0] * r[0] + r[1] * r[1] + r[2] * r[2], 1.5L);
      // −μ (r / r³ − o / o³), by parts: r / r³ − o / o³ = p / r³ + o (1 / r³ − 1 / o³)
      const Long between = 1 / r3 - 1 / o3, mu = planet.mu;
      const Vector3d expected(static_cast<double>(-mu * (Long(p.x()) / r3 + o.x * between)),
                              static_cast<double>(-mu * (Long(p.y()) / r3 + o.y * between)),
                              static_cast<double>(-mu * (Long(p.z()) / r3 + o.z * between)));
      const double lost = 1e-19 * norm(o) / distance;  // digits that long double loses in `between`
      const Vec3 g = calc_planet_gravity(planet, t, {p.x(), p.y(), p.z()});
      ASSERT_LT((to_eigen(g) - expected).norm(), (kRelative + 10 * lost) * expected.norm()) << distance;
    }
  }
}

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

TEST(Environment, AStartIsWhereItWasAskedForInAllFrames) {
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
TEST(Environment, AnAssemblyMovesToItsStartAsOne) {
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

TEST(Environment, AirAsABodyMeetsItFollowsFromItsVelocityAndTheWind) {
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

TEST(Environment, EnergyAndMomentumHoldOverAHundredRevolutions) {
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

TEST(Environment, AFallingOriginSeesTheSameOrbit) {
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

TEST(Environment, ClearancesKeepTheirDigitsSixThousandKilometresFromTheCentre) {
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

TEST(Environment, MistakesNameTheirKeys) {
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
}  // namespace unlatch::test
