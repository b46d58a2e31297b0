// Cords wound on drums: their paths and forces against polygons, numerical differentiation, closed forms of the yo-yo
// and of a mass that winds up on a pole.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "kernel/dynamics/balance.h"
#include "kernel/elements/kinds/one_sided/cord_path.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/elementary.h"
#include "unlatch/energy.h"
#include "unlatch/readings.h"

namespace unlatch::test::cords_test {
namespace {

Drum make_drum(double radius, bool left, std::optional<double> wound) {
  Drum drum;
  drum.radius = radius;
  drum.left = left;
  drum.wound = wound;
  return drum;
}

OneSided make_cord(const std::string& name, int follower, const Drum& drum, double stiffness) {
  OneSided f;
  f.name = name;
  f.kind = OneSided::Kind::kCord;
  f.pulls = true;
  f.base = 0;
  f.follower = follower;
  f.drum = drum;
  f.stiffness = stiffness;
  return f;
}

struct Seen {
  std::string name, subject;
  double time;
};

std::vector<Seen> run(Simulation& s, const Model& model, int ticks) {
  const Model whole = complete_events(model);
  std::vector<Seen> seen;
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    EXPECT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& e : report.events) {
      const Event& event = whole.events[static_cast<std::size_t>(e.event)];
      seen.push_back({event.name, event.subject, e.time});
    }
  }
  return seen;
}

double find(const std::vector<Seen>& seen, const std::string& name, const std::string& subject) {
  for (const Seen& event : seen)
    if (event.name == name && event.subject == subject) return event.time;
  return -1;
}

// --- Path ------------------------------------------------------------------------------------------------------------

// Length of a thread around a prism with `corners` sides on the circle, from the corner at angle 0 to the end at (rho,
// bearing): over corners until the end is visible past the next one.
double measure_polygon(double radius, double rho, double bearing, int corners) {
  const double step = 2 * M_PI / corners, side = bearing < 0 ? -1 : 1;
  const double ex = rho * std::cos(bearing), ey = rho * std::sin(bearing);
  const auto corner = [&](int k) {
    return std::pair(radius * std::cos(side * step * k), radius * std::sin(side * step * k));
  };
  double length = 0;
  int k = 0;
  for (; std::abs(bearing) - step * k > 0; ++k) {
    const auto [x, y] = corner(k);
    const auto [u, v] = corner(k + 1);
    // The end lies on the outer side of the line through this edge, and within half a turn: it is visible past the
    // edge.
    const double outside = side * ((u - x) * (ey - y) - (v - y) * (ex - x));
    if (std::abs(bearing) - step * k < M_PI && outside <= 0) break;
    length += std::hypot(u - x, v - y);
  }
  const auto [x, y] = corner(k);
  return length + std::hypot(ex - x, ey - y);
}

TEST(Cords, ThePathIsThatOfAThreadRoundAFinePrism) {
  constexpr int kCorners = 20000;
  std::mt19937 numbers(1);
  std::uniform_real_distribution<double> bearings(-20, 20), radii(0.1, 2), beyond(0, 3);
  const CordDrum drum{{0, 0, 0}, kIdentity3, 1, 0};
  int straight = 0;
  for (int i = 0; i < 200; ++i) {
    CordDrum own = drum;
    own.radius = radii(numbers);
    const double rho = own.radius + beyond(numbers);
    const double bearing = i % 4 == 0 ? 0.06 * bearings(numbers) : bearings(numbers);
    const Vec3 end{rho * std::cos(bearing), rho * std::sin(bearing), 0};
    const CordPath path = calc_cord_path(own, kIdentity3, end, bearing + 1);
    const double expected = measure_polygon(own.radius, rho, bearing, kCorners);
    EXPECT_NEAR(path.length, expected, 1e-6 * expected) << "seed 1, case " << i;  // (2π/20000)²/6, and a corner
    EXPECT_NEAR(path.bearing, bearing, 1e-13);
    straight += path.winding <= 0;
    // Out of the plane the drum and the tangent plane unroll: the path is a straight line there.
    const CordPath lifted = calc_cord_path(own, kIdentity3, {end.x, end.y, 0.7}, bearing);
    EXPECT_NEAR(lifted.length, std::hypot(path.length, 0.7), 1e-12);
  }
  EXPECT_GT(straight, 10);
  EXPECT_LT(straight, 100);
}

// The wrench on both bodies is the gradient of the cord's stored energy, over the six degrees of freedom of each.
TEST(Cords, TheForceIsTheGradientOfTheStoredEnergy) {
  std::mt19937 numbers(2);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto vector = [&] { return Eigen::Vector3d(any(numbers), any(numbers), any(numbers)); };
  int straight = 0;
  for (int i = 0; i < 300; ++i) {
    Model model;
    model.bodies = {box("drum", 3, 1, 2, 2.5), box("end", 2, 1, 1.5, 2)};
    for (Body& body : model.bodies) {
      body.q_WB = Eigen::Quaterniond(any(numbers), any(numbers), any(numbers), any(numbers)).normalized();
      body.p_WB = vector();
    }
    model.bodies[1].p_WB += 3 * vector();
    Drum drum = make_drum(0.3, i % 2 == 0, i % 3 == 0 ? 0 : 8 * std::abs(any(numbers)));
    drum.axis = vector().normalized();
    drum.centre = 0.3 * vector();
    OneSided f = make_cord("cord", 1, drum, 1000);
    f.point_follower = 0.2 * vector();
    model.one_sided = {f};
    if (!validate(model).empty()) continue;  // the end is inside
    CordDrum placed = place_drum(model, f);
    if (i % 3 == 0) {  // moved beyond the tangent, and some of them back onto the drum's other side
      const double swing = 2.5 * std::abs(any(numbers));
      Mat3& axes = placed.axes;
      axes = {std::cos(swing) * axes.x + std::sin(swing) * axes.y, std::cos(swing) * axes.y - std::sin(swing) * axes.x,
              axes.z};
      placed.bearing -= swing;
    }
    const auto get_vec = [](const Eigen::Vector3d& v) { return Vec3{v.x(), v.y(), v.z()}; };
    const auto get_mat = [&](const Eigen::Quaterniond& q) {
      const Eigen::Matrix3d m = q.toRotationMatrix();
      return Mat3{get_vec(m.col(0)), get_vec(m.col(1)), get_vec(m.col(2))};
    };
    const auto measure = [&](const Model& at) {
      const Body &a = at.bodies[0], &b = at.bodies[1];
      return calc_cord_path(placed, get_mat(a.q_WB), get_vec(b.p_WB + b.q_WB * f.point_follower - a.p_WB),
                            placed.bearing);
    };
    const CordPath path = measure(model);
    straight += path.winding < 0;
    // Wrench per newton of tension: −direction at the end on the follower, the opposite at the same place on the base.
    const auto get_eigen = [](const Vec3& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
    const Eigen::Vector3d force = get_eigen(path.direction);
    const Eigen::Vector3d end = model.bodies[1].p_WB + model.bodies[1].q_WB * f.point_follower;
    constexpr double kStep = 1e-5;
    for (const int body : {0, 1}) {
      const double sign = body == 0 ? -1 : 1;
      const Eigen::Vector3d moment = (end - model.bodies[static_cast<std::size_t>(body)].p_WB).cross(force);
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d axis = Eigen::Vector3d::Unit(k);
        double lengths[2][2];
        for (const int side : {0, 1}) {
          const double by = side == 0 ? -kStep : kStep;
          Model moved = model, turned = model;
          moved.bodies[static_cast<std::size_t>(body)].p_WB += by * axis;
          Body& own = turned.bodies[static_cast<std::size_t>(body)];
          own.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(by, axis)) * Eigen::Quaterniond(own.q_WB);
          lengths[0][side] = measure(moved).length;
          lengths[1][side] = measure(turned).length;
        }
        EXPECT_NEAR((lengths[0][1] - lengths[0][0]) / (2 * kStep), sign * force[k], 2e-8) << "seed 2, case " << i;
        EXPECT_NEAR((lengths[1][1] - lengths[1][0]) / (2 * kStep), sign * moment[k], 5e-8) << "seed 2, case " << i;
      }
    }
  }
  EXPECT_GT(straight, 20);
}

// Checks the same for the step: accelerations from rest, of bodies without other forces.
TEST(Cords, TheStepAppliesThatForceToBothBodies) {
  Model model;
  model.bodies = {box("drum", 3, 1, 1, 1), box("end", 2, 1, 1, 1)};
  model.bodies[0].p_WB = {0.3, -0.2, 0.1};
  model.bodies[1].p_WB = {1.5, 0.7, 0.4};
  Drum drum = make_drum(0.4, true, 7.5);
  drum.axis = Eigen::Vector3d(0.2, -0.3, 1).normalized();
  drum.centre = {0.1, 0.05, 0};
  OneSided f = make_cord("cord", 1, drum, 1000);
  f.point_follower = {0.1, 0.2, -0.1};
  f.limit = calc_start(model, f) - 0.02;
  model.one_sided = {f};
  Simulation s(model);
  ASSERT_EQ(evaluate_state(s), kNone);
  const CordPath path = calc_cord_path(place_drum(model, f), kIdentity3, {1.3, 1.1, 0.2}, 7.5);
  EXPECT_GT(path.winding, 2 * M_PI);
  const Vec3 force = -(20.0 * path.direction), end{1.6, 0.9, 0.3};
  Vec3 force_sum{0, 0, 0}, moment_sum{0, 0, 0};
  for (const int body : {0, 1}) {
    const double mass = body == 0 ? 3 : 2, sign = body == 0 ? -1 : 1;
    const Eigen::Vector3d& p = model.bodies[static_cast<std::size_t>(body)].p_WB;
    const Vec3 moment = cross(end - Vec3{p.x(), p.y(), p.z()}, force);
    const Spatial a = s.evaluation().get_acceleration(body);
    EXPECT_LT(norm(mass * a.lin - sign * force), 1e-9);
    EXPECT_LT(norm(a.ang - sign * moment), 1e-9);
    force_sum += mass * a.lin;
    moment_sum += a.ang + mass * cross(Vec3{p.x(), p.y(), p.z()}, a.lin);
  }
  EXPECT_LT(norm(force_sum), 1e-14);
  EXPECT_LT(norm(moment_sum), 1e-13);
}

// If the end comes inside the drum, the moment about the axis stays, and the length is continuous.
TEST(Cords, InsideTheDrumTheMomentAboutItsAxisStays) {
  const CordDrum drum{{0, 0, 0}, kIdentity3, 0.5, 0};
  const CordPath out = calc_cord_path(drum, kIdentity3, {0.5 * std::cos(2.0), 0.5 * std::sin(2.0), 0}, 2);
  const CordPath in = calc_cord_path(drum, kIdentity3, {0.2 * std::cos(2.0), 0.2 * std::sin(2.0), 0}, 2);
  EXPECT_NEAR(out.length, 1, 1e-7);
  EXPECT_NEAR(in.length, 1, 1e-12);
  EXPECT_NEAR(norm(in.direction) * 0.2, 0.5, 1e-12);
  const CordPath middle = calc_cord_path(drum, kIdentity3, {0, 0, 0}, 2);
  EXPECT_EQ(norm(middle.direction), 0);
  EXPECT_EQ(middle.bearing, 2);
}

// --- A mass on a cord round a fixed pole -----------------------------------------------------------------------------

// Inextensible, the cord does no work: the speed v stays, and its straight part grows by d(s²)/dt = 2 R v.
Model build_pole(double stiffness, double wound, double straight, double speed) {
  Model model;
  model.bodies = {box("ball", 1, 1e-3, 1e-3, 1e-3)};
  constexpr double kRadius = 0.25;
  model.bodies[0].p_WB = {kRadius, straight, 0};  // on the tangent of a right-handed cord
  model.bodies[0].v_WB = {-speed, 0, 0};          // winds it up, outwards for speed < 0
  OneSided f = make_cord("cord", 0, make_drum(kRadius, false, wound), stiffness);
  f.base = kGround;
  f.damping = 0.2 * std::sqrt(stiffness);
  model.one_sided = {f};
  return model;
}

TEST(Cords, AMassUnwindsFromAPoleAndIsCountedOverTurns) {
  double errors[2];
  for (const int i : {0, 1}) {
    const double stiffness = i == 0 ? 4e5 : 16e5;
    const Model model = build_pole(stiffness, 20, 0.3, -2);
    Simulation s(model, {.dt = 1e-4});
    const double start = calc_start(model, model.one_sided[0]);
    EXPECT_NEAR(start, 0.25 * 20 + 0.3, 1e-12);
    run(s, model, 60000);  // 6 s
    const OneSidedReading now = calc_one_sided(s.plan, s.workspace, 0);
    const double straight = std::sqrt(0.3 * 0.3 + 2 * 0.25 * 2 * 6), wound = (start - straight) / 0.25;
    EXPECT_GT(20 - wound, 2 * M_PI) << "more than a turn has come off";
    EXPECT_GT(wound, 4 * M_PI - 6);
    errors[i] = std::abs(now.wound - wound);
    EXPECT_NEAR(now.on_drum, 0.25 * now.wound, 1e-12);
    EXPECT_EQ(now.bearing, s.state.bearings[0]);
    EXPECT_GT(now.force, 0);
    EXPECT_NEAR(norm(s.state.bodies[0].v), 2, 3e-4 / (1 + 3 * i));
  }
  EXPECT_LT(errors[1], 5e-4);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.4) << "its error is that of the stretch: " << errors[0] << ", " << errors[1];
}

TEST(Cords, AMassWindsUpOnAPole) {
  const Model model = build_pole(16e5, 1, 2, 2);
  Simulation s(model, {.dt = 1e-4});
  run(s, model, 30000);  // 3 s: s² = 4 − 2 · 0.25 · 2 · 3
  const OneSidedReading now = calc_one_sided(s.plan, s.workspace, 0);
  EXPECT_NEAR(now.wound, 1 + (2 - 1) / 0.25, 2e-3);
  EXPECT_NEAR(norm(s.state.bodies[0].v), 2, 1e-3);
}

// --- Yo-yo -----------------------------------------------------------------------------------------------------------

constexpr double kInertia = 16, kTip = 0.8, kRadius = 0.4, kSpin = 4 * M_PI;

// Two masses on opposite sides of a drum that spins about z, on its surface, cords wound against the spin.
Model build_yoyo(double length, double stiffness, double damping) {
  Model model;
  model.bodies = {box("drum", 180, 13, 14, kInertia), box("a", kTip, 1e-3, 1e-3, 1e-3),
                  box("b", kTip, 1e-3, 1e-3, 1e-3)};
  for (Body& body : model.bodies) body.w_WB_B = {0, 0, kSpin};
  for (const int i : {1, 2}) {
    Body& tip = model.bodies[static_cast<std::size_t>(i)];
    const double side = i == 1 ? 1 : -1;
    tip.p_WB = {side * kRadius, 0, 0};
    tip.v_WB = {0, side * kSpin * kRadius, 0};
    OneSided cord = make_cord(tip.name, i, make_drum(kRadius, true, {}), stiffness);
    cord.limit = length;
    cord.damping = damping;
    model.one_sided.push_back(cord);
  }
  return model;
}

// Releases the cords when `kind` falls to 0.
void add_releases(Model& model, Condition::Kind kind) {
  for (const int i : {0, 1}) {
    Event release{"release", model.one_sided[static_cast<std::size_t>(i)].name, when(kind, i, 0, 0), 0, {}, false};
    release.when.below = true;
    Action off;
    off.kind = Action::Kind::kSwitch;
    off.subject = i;
    release.then = {off};
    model.events.push_back(release);
  }
}

double run_yoyo(double length, double stiffness, double dt, Condition::Kind kind, double* released = nullptr) {
  Model model = build_yoyo(length, stiffness, 0.3 * std::sqrt(stiffness * kTip));
  add_releases(model, kind);
  Simulation s(model, {.dt = dt});
  const std::vector<Seen> seen = run(s, model, static_cast<int>(std::lround(1.2 / dt)));
  const double a = find(seen, "release", "a"), b = find(seen, "release", "b");
  EXPECT_GT(a, 0);
  EXPECT_NEAR(a, b, 1e-9);
  if (released) *released = a;
  EXPECT_NEAR(norm(s.state.bodies[0].p), 0, 1e-12);
  return s.state.bodies[0].w.z;
}

// Conservation of H = (I + 2mR²) w0 and of the energy, with the straight part s = R φ and the unwinding rate φ' = w0:
// w/w0 = (c − φ²)/(c + φ²), c = 1 + I/(2mR²). Elastic cords approach it as 1/k.
TEST(Cords, AYoYoComesToTheClosedFormAsItsCordsBecomeStiff) {
  const double c = 1 + kInertia / (2 * kTip * kRadius * kRadius);
  for (const double length : {2.0, std::sqrt(kRadius * kRadius + kInertia / (2 * kTip)), 4.0}) {
    const double square = length * length / (kRadius * kRadius), expected = kSpin * (c - square) / (c + square);
    double errors[2], released = 0;
    for (const int i : {0, 1})
      errors[i] = std::abs(
          run_yoyo(length, i == 0 ? 2e5 : 8e5, i == 0 ? 2e-4 : 1e-4, Condition::Kind::kWound, &released) - expected);
    EXPECT_LT(errors[1], 1e-3 * kSpin) << length;
    EXPECT_LT(errors[1], 0.35 * errors[0]) << length << ": " << errors[0] << ", " << errors[1];
    EXPECT_NEAR(released, length / kRadius / kSpin, 2e-3);
  }
}

// Then the cords swing about their anchors; along the radius H = nm (R + l) V + I w, and V is the masses' speed.
// Without remaining spin, (R + l)² = R² + I/(2m).
TEST(Cords, ReleasedAlongTheRadiusTheirStopNeedsShorterCords) {
  const double length = std::sqrt(kRadius * kRadius + kInertia / (2 * kTip)) - kRadius;
  double errors[2], released = 0;
  for (const int i : {0, 1})
    errors[i] =
        std::abs(run_yoyo(length, i == 0 ? 2e5 : 8e5, i == 0 ? 2e-4 : 1e-4, Condition::Kind::kBearing, &released));
  EXPECT_LT(errors[1], 1e-3 * kSpin);
  EXPECT_LT(errors[1], 0.35 * errors[0]) << errors[0] << ", " << errors[1];
  EXPECT_GT(released, length / kRadius / kSpin + 0.01) << "after the tangent";
}

// Without release: past the radius the cords wind up in the other direction. The pulls have no sum and no moment, see
// above; the error of the angular momentum and of the energy is the integrator's, of its order.
TEST(Cords, MomentumAndEnergyAreKeptToTheIntegrator) {
  double momentum[2] = {}, energy[2] = {};
  for (const int finer : {0, 1}) {
    const Model model = build_yoyo(2.5, 2e4, 0);
    Simulation s(model, {.dt = finer == 0 ? 5e-4 : 2.5e-4});
    ASSERT_EQ(evaluate_state(s), kNone);
    const Balance start = calc_balance(s.data(), s.state, s.evaluation());
    const EnergyFlow before = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
    double least = 0, wound = 0;
    for (int i = 0; i < (finer == 0 ? 2400 : 4800); ++i) {
      ASSERT_EQ(s.advance().status, StepStatus::kOk);
      const Balance now = calc_balance(s.data(), s.state, s.evaluation());
      const EnergyFlow flow = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
      EXPECT_LT(norm(now.momentum), 1e-12);
      momentum[finer] = std::max(momentum[finer], norm(now.angular_momentum - start.angular_momentum));
      energy[finer] = std::max(energy[finer], std::abs(flow.kinetic + flow.strain - before.kinetic - before.strain));
      least = std::min(least, s.state.bearings[0]);
      if (s.state.bearings[0] < 0) wound = std::max(wound, calc_one_sided(s.plan, s.workspace, 0).wound);
    }
    EXPECT_LT(momentum[finer], 2e-11 * start.angular_momentum.z);
    EXPECT_LT(energy[finer], 1e-7 * before.kinetic);
    EXPECT_LT(least, -2);
    EXPECT_GT(wound, 0.5) << "it has wound up the other way";
  }
  EXPECT_LT(momentum[1], momentum[0] / 12) << momentum[0] << ", " << momentum[1];
  EXPECT_LT(energy[1], energy[0] / 12) << energy[0] << ", " << energy[1];
}

// --- State -----------------------------------------------------------------------------------------------------------

TEST(Cords, TheCountOfTurnsIsInTheStateAlone) {
  const Model model = build_yoyo(3, 2e4, 10);
  Simulation first(model), second(model);
  run(first, model, 200);
  std::memcpy(second.state.get_bytes().data(), first.state.get_bytes().data(), first.state.get_bytes().size());
  ASSERT_EQ(calc_hash(first.state), calc_hash(second.state));
  run(first, model, 100);
  run(second, model, 100);
  EXPECT_EQ(calc_hash(first.state), calc_hash(second.state));
  const double bearing = first.state.bearings[0];
  first.state.bearings[0] = bearing + 2 * M_PI;
  EXPECT_NE(calc_hash(first.state), calc_hash(second.state));
}

TEST(Cords, HeldMassesMakeNoEvents) {
  Model model = build_yoyo(3, 2e4, 10);
  for (const int i : {1, 2}) {
    Joint joint;
    joint.name = "latch" + std::to_string(i);
    joint.base = 0;
    joint.follower = i;
    joint.point_base = {i == 1 ? kRadius : -kRadius, 0, 0};
    joint.modes = {{"held", kWeldRows}};
    model.joints.push_back(joint);
    model.one_sided[static_cast<std::size_t>(i - 1)].drum->wound = 3 / kRadius + 0.001;  // stretched a little
  }
  Simulation s(model);
  EXPECT_TRUE(run(s, model, 500).empty());
  EXPECT_NEAR(calc_one_sided(s.plan, s.workspace, 0).force, 2e4 * 0.001 * kRadius, 1e-6);
}

// --- Mistakes --------------------------------------------------------------------------------------------------------

TEST(Cords, MistakesAreNamed) {
  const auto check = [](const std::function<void(OneSided&)>& spoil) {
    Model model = build_yoyo(3, 2e4, 10);
    spoil(model.one_sided[0]);
    std::string text;
    for (const ModelError& error : validate(model)) text += error.key + ": " + error.what + "\n";
    return text;
  };
  EXPECT_EQ(check([](OneSided&) {}), "");
  EXPECT_NE(check([](OneSided& f) { f.drum->radius = 0; }).find("radius: radius is 0"), std::string::npos);
  EXPECT_NE(check([](OneSided& f) { f.drum->radius = 0.5; }).find("its end is inside its drum"), std::string::npos);
  EXPECT_NE(check([](OneSided& f) { f.drum->axis = {0, 0, 0}; }).find("axis"), std::string::npos);
  EXPECT_NE(check([](OneSided& f) { f.drum->wound = -1; }).find("wound: wound is -1"), std::string::npos);
  EXPECT_NE(check([](OneSided& f) { f.limit.reset(); }).find("neither its length nor"), std::string::npos);
  EXPECT_NE(check([](OneSided& f) { f.drum->radius = 0.2, f.limit = 0.3; }).find("from the drum"), std::string::npos);
  EXPECT_NE(check([](OneSided& f) { f.guide = Eigen::Vector3d::UnitX(); }).find("no cord between"), std::string::npos);
  EXPECT_NE(check([](OneSided& f) { f.stiffness = 0; }).find("stiffness is 0"), std::string::npos);
  EXPECT_EQ(check([](OneSided& f) { f.drum->wound = 2, f.limit.reset(); }), "");
}

}  // namespace
}  // namespace unlatch::test::cords_test
