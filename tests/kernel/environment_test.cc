// The environment: places on the planet against GeographicLib where it is installed, the air against the published
// standard, gravity against the gradient of its potential.
#include "unlatch/model/environment.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "kernel/environment/environment.h"
#include "tests/kernel/flight_support.h"

#ifdef UNLATCH_GEOGRAPHIC
#include <GeographicLib/Geocentric.hpp>
#endif

namespace unlatch::test::environment_test {
namespace {

using Eigen::Vector3d;
using Long = long double;

constexpr double kDegree = std::numbers::pi / 180;

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
      const Vec3 g = calc_planet_gravity(own, own.origin, {at.x(), at.y(), at.z()});
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
        sum += kMass * r.cross(to_eigen(calc_planet_gravity(planet, planet.origin, {p.x(), p.y(), p.z()}) -
                                        calc_planet_gravity(planet, planet.origin, {at.x(), at.y(), at.z()})));
        J += kMass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
      }
      const Vec3 torque = calc_gradient_torque(planet, planet.origin, {at.x(), at.y(), at.z()},
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

// Against Kepler's equation in long double, bisected, from any place of ellipses up to nearly a line: places and
// velocities by the same f and g functions.
TEST(Environment, TheFallingOriginIsWhereKeplersEquationHasIt) {
  constexpr double kRounding = 1e-15;  // of the way in angle since t = 0, and of a place
  Random random(11);
  for (const double e : {0.0, 1e-9, 1e-3, 0.01, 0.2, 0.7, 0.8, 0.9, 0.97, 0.99, 0.9999}) {
    for (int i = 0; i < 1000; ++i) {
      PlanPlanet planet = compile_planet(fall(0.2));
      const double start = random.uniform(-4, 4), period = 2 * std::numbers::pi / planet.mean_motion;
      planet.e_sine = e * std::sin(start);
      planet.e_cosine = e * std::cos(start);
      planet.distance = planet.semi_major * (1 - planet.e_cosine);
      const double t = i % 2 == 0 ? random.uniform(-0.01, 0.01) * period : random.uniform(0, 10) * period;
      const Long p = planet.e_sine, q = planet.e_cosine, n = planet.mean_motion, a = planet.semi_major, M = n * t;
      Long low = M - 2 * e, high = M + 2 * e;
      for (int k = 0; k < 80; ++k) {
        const Long middle = (low + high) / 2;
        (middle - M + p * (1 - std::cos(middle)) - q * std::sin(middle) > 0 ? high : low) = middle;
      }
      const Long E = (low + high) / 2, sine = std::sin(E), half = std::sin(E / 2), versine = 2 * half * half;
      const Long r = a * (1 + p * sine - q * std::cos(E)), r0 = planet.distance;
      const Long f = 1 - a / r0 * versine, g = (M - E + sine) / n;
      const Long f_rate = -n * a * (a / (r * r0)) * sine, g_rate = 1 - a / r * versine;
      const OriginMotion now = calc_origin(planet, t);
      // An error of the angle moves E by that over r / a, and f and g by what they change with E.
      const double angle = kRounding * (2 + static_cast<double>(std::abs(M))), slope = static_cast<double>(r / a);
      const double far =
          static_cast<double>(a / r0) * norm(planet.origin) + static_cast<double>(1 / n) * norm(planet.velocity);
      const Vector3d origin = to_eigen(planet.origin), velocity = to_eigen(planet.velocity);
      const Vector3d place = static_cast<double>(f) * origin + static_cast<double>(g) * velocity;
      const Vector3d speed = static_cast<double>(f_rate) * origin + static_cast<double>(g_rate) * velocity;
      ASSERT_LT((to_eigen(now.r) - place).norm(), angle / slope * far)
          << e << " from " << start << " rad, " << t << " s";
      ASSERT_LT((to_eigen(now.v) - speed).norm(), angle / (slope * slope * slope) * far * planet.mean_motion)
          << e << " from " << start << " rad, " << t << " s";
    }
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
      const Vec3 g = calc_planet_gravity(planet, o, {p.x(), p.y(), p.z()});
      ASSERT_LT((to_eigen(g) - expected).norm(), (kRelative + 10 * lost) * expected.norm()) << distance;
    }
  }
}

}  // namespace
}  // namespace unlatch::test::environment_test
