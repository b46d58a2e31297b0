// Forces of the air: random coefficients against the formula written out with Eigen, moments carried to the centre of
// mass, powers, and what a body at rest in the air feels.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/energy.h"
#include "unlatch/readings.h"

namespace unlatch::test::aerodynamics_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPlace = 1e-9;      // relative: the velocity through the air is a difference of velocities of 500 m/s
constexpr double kRounding = 1e-11;  // of sums of some ten numbers, relative to the largest

Vector3d to_eigen(const Vec3& v) { return {v.x, v.y, v.z}; }
Vector3d draw(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

// A body at 10 km over a planet without gravity, in wind.
Model build_flyer() {
  Model model;
  model.bodies = {box("flyer", 12, 3, 5, 6)};
  Planet planet{.mu = 0, .j2 = 0};
  model.environment.planet = planet;
  model.environment.atmosphere = Atmosphere{};
  model.environment.wind = Wind{{0}, {{5, -10, 1}}};
  return model;
}

Start draw_start(Random& random) {
  Start start;
  start.body = 0;
  start.latitude = random.uniform(-1, 1);
  start.longitude = random.uniform(-3, 3);
  start.altitude = 10e3;
  start.velocity = draw(random, 300);
  start.euler = draw(random, 1);
  start.rate = draw(random, 2);
  start.origin = Start::Origin::kStart;
  return start;
}

Matrix3d from_euler(const Vector3d& e) {
  return (Eigen::AngleAxisd(e.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(e.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(e.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

// Coefficients with all rates, a third of them by laws. `constant[i]`, `derivative[i][k]` are their sums.
struct Coefficients {
  Eigen::Matrix<double, 7, 1> constant = Eigen::Matrix<double, 7, 1>::Zero();
  Eigen::Matrix<double, 7, 3> derivative = Eigen::Matrix<double, 7, 3>::Zero();
};
Coefficients draw_terms(Random& random, Model& model, Aerodynamics& air) {
  Coefficients out;
  for (int i = 0; i < 40; ++i) {
    const int of = random.below(7), rate = random.below(4) - 1;
    const double value = random.uniform(-1, 1);
    AeroTerm term{static_cast<AeroTerm::Of>(of), rate, value, kNone};
    if (random.chance(0.3)) {
      Law law;
      law.name = "law" + std::to_string(model.laws.size());
      law.steps = {{LawStep::Kind::kConstant, 0, value - 0.25}};
      law.offset = 0.25;
      term.law = static_cast<int>(model.laws.size());
      term.value = 99;  // does not count
      model.laws.push_back(law);
    }
    air.terms.push_back(term);
    if (rate < 0)
      out.constant[of] += value;
    else
      out.derivative(of, rate) += value;
  }
  return out;
}

TEST(Aerodynamics, ForceAndMomentAreThoseOfTheFormula) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    Model model = build_flyer();
    Aerodynamics air{.name = "air", .body = 0, .area = random.uniform(0.1, 3), .terms = {}};
    air.lengths = Vector3d(random.uniform(0.5, 2), random.uniform(0.5, 2), random.uniform(0.5, 2));
    air.point = draw(random, 1);
    const Coefficients c = draw_terms(random, model, air);
    model.aerodynamics.push_back(air);
    const Start start = draw_start(random);
    Simulation s(place_start(model, start));
    ASSERT_EQ(evaluate_state(s), kNone);

    const AirState state = calc_air(Atmosphere{}, 10e3);
    const Matrix3d R = from_euler(*start.euler);  // to north, east, down
    const Vector3d u = R.transpose() * (start.velocity - Vector3d(5, -10, 1));
    const double V = u.norm(), q = 0.5 * state.density * V * V, rate = model.environment.planet->rate;
    const Vector3d turn(rate * std::cos(start.latitude), 0, -rate * std::sin(start.latitude));
    const Vector3d w = start.rate - R.transpose() * turn;
    const Eigen::Matrix<double, 7, 1> sum = c.constant + c.derivative * w.cwiseProduct(air.lengths) / (2 * V);
    const Vector3d force = q * air.area * (sum.head<3>() - sum[6] * u / V);
    const Vector3d moment =
        q * air.area * air.lengths.cwiseProduct(Vector3d(sum.segment<3>(3))) + air.point.cross(force);

    const Body placed = place_start(model, start).bodies[0];
    const Matrix3d body = placed.q_WB.toRotationMatrix();
    const Spatial a = s.evaluation().get_acceleration(0);
    const Matrix3d J = model.bodies[0].inertia;
    const Vector3d expected = J.inverse() * (moment - start.rate.cross(J * start.rate));
    EXPECT_LT((body.transpose() * to_eigen(a.lin) - force / 12).norm(), kPlace * (1 + force.norm())) << "seed 1, " << i;
    EXPECT_LT((body.transpose() * to_eigen(a.ang) - expected).norm(), kPlace * (1 + expected.norm()))
        << "seed 1, " << i;

    const EnergyFlow flow = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
    const double power = (body * force).dot(placed.v_WB) + moment.dot(start.rate);
    EXPECT_NEAR(flow.power[static_cast<std::size_t>(PowerSource::kLoads)], power,
                kRounding * (1e3 + force.norm() * placed.v_WB.norm()));
  }
}

// The origin of a body with a mass law is its structure's, not the centre of mass.
TEST(Aerodynamics, MomentsAreCarriedToTheCentreOfMass) {
  Model model = build_flyer();
  const Vector3d centre(0.4, -0.1, 0.2);
  MassLaw law;
  law.knots = {{0, 12, centre, model.bodies[0].inertia}, {1, 12, centre, model.bodies[0].inertia}};
  model.aerodynamics.push_back({.name = "air", .body = 0, .area = 2, .point = {1, 0.2, 0.3}, .terms = {}});
  model.aerodynamics[0].terms = {{AeroTerm::Of::kX, kNone, -0.3, kNone}, {AeroTerm::Of::kZ, kNone, -1.2, kNone}};
  Start start;
  start.altitude = 10e3;
  start.velocity = {250, 0, 30};
  start.origin = Start::Origin::kStart;
  Model shifted = model;
  shifted.bodies[0].law = law;
  model.aerodynamics[0].point -= centre;
  Simulation about_centre(place_start(model, start)), about_origin(place_start(shifted, start));
  ASSERT_EQ(evaluate_state(about_centre), kNone);
  ASSERT_EQ(evaluate_state(about_origin), kNone);
  const Spatial a = about_centre.evaluation().get_acceleration(0), b = about_origin.evaluation().get_acceleration(0);
  EXPECT_LT(norm(a.ang - b.ang), 1e-9 * norm(a.ang));
  EXPECT_GT(norm(a.ang), 1);
}

TEST(Aerodynamics, ABodyAtRestInTheAirFeelsNothing) {
  Random random(3);
  Model model = build_flyer();
  Aerodynamics air{.name = "air", .body = 0, .area = 1, .terms = {}};
  draw_terms(random, model, air);
  model.aerodynamics.push_back(air);
  Start start;
  start.altitude = 10e3;
  start.velocity = {5, -10, 1};  // with the wind
  start.euler = Vector3d(0, 0, 0);
  start.turns = Start::Turns::kPlanet;
  start.rate = {1, 2, 3};
  start.origin = Start::Origin::kStart;
  Simulation s(place_start(model, start));
  ASSERT_EQ(evaluate_state(s), kNone);
  const Spatial a = s.evaluation().get_acceleration(0);
  EXPECT_LT(norm(a.lin), 1e-8);
  EXPECT_TRUE(std::isfinite(norm(a.ang)));
}

TEST(Aerodynamics, ASwitchScalesIt) {
  Model model = build_flyer();
  model.aerodynamics.push_back({.name = "air", .body = 0, .area = 1, .terms = {}});
  model.aerodynamics[0].terms = {{AeroTerm::Of::kDrag, kNone, 0.5, kNone}};
  model.aerodynamics[0].on = false;
  Start start;
  start.altitude = 10e3;
  start.velocity = {250, 0, 30};
  Simulation s(place_start(model, start));
  ASSERT_EQ(evaluate_state(s), kNone);
  EXPECT_EQ(norm(s.evaluation().get_acceleration(0).lin), 0);
  EXPECT_EQ(describe_element(model, 0).kind, std::string("aerodynamics"));
}

TEST(Aerodynamics, MistakesNameTheirKeys) {
  const auto expect = [](const char* what, const auto& spoil) {
    Model model = build_flyer();
    model.aerodynamics.push_back({.name = "air", .body = 0, .area = 1, .terms = {}});
    spoil(model, model.aerodynamics[0]);
    const std::vector<ModelError> errors = validate(model);
    ASSERT_FALSE(errors.empty()) << what;
    EXPECT_NE(errors.front().what.find(what), std::string::npos) << errors.front().what;
  };
  expect("area is 0", [](Model&, Aerodynamics& a) { a.area = 0; });
  expect("lengths is -1", [](Model&, Aerodynamics& a) { a.lengths.y() = -1; });
  expect("no air", [](Model& m, Aerodynamics&) { m.environment = {}; });
  expect("acts on no body", [](Model&, Aerodynamics& a) { a.body = 4; });
  expect("law of a coefficient does not exist", [](Model&, Aerodynamics& a) {
    a.terms = {{AeroTerm::Of::kX, kNone, 0, 3}};
  });
  expect("no rate", [](Model&, Aerodynamics& a) { a.terms = {{AeroTerm::Of::kX, 3, 0, kNone}}; });
}

}  // namespace
}  // namespace unlatch::test::aerodynamics_test
