// Contacts: the law against integrals and closed forms that are independent of the kernel, balances, events, bounds.
#include "kernel/elements/kinds/contact/contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "kernel/events/limits.h"
#include "tests/support/contact_models.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"
#include "unlatch/energy.h"

namespace unlatch::test::contact_test {
namespace {

struct Logged {
  double time;
  std::string name, subject;
};

// Steps; returns the events that acted.
std::vector<Logged> run(Simulation& s, const Model& model, int ticks) {
  std::vector<Logged> events;
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    EXPECT_EQ(report.status, StepStatus::kOk);
    for (const FiredEvent& fired : report.events) {
      const Event& event = model.events[static_cast<std::size_t>(fired.event)];
      events.push_back({fired.time, event.name, event.subject});
    }
  }
  return events;
}

// ∫ u / (1 + d u) du from 0 to v by Simpson's rule.
double integrate_law(double d, double v) {
  constexpr int kParts = 2000;
  const double h = v / kParts;
  double sum = 0;
  for (int i = 0; i <= kParts; ++i) {
    const double u = i * h;
    sum += (i == 0 || i == kParts ? 1 : (i % 2 == 1 ? 4 : 2)) * u / (1 + d * u);
  }
  return sum * h / 3;
}

// Speed after an impact with v by the law's first integral, equal for approach and separation.
double calc_speed_after(double d, double v) {
  const double taken = integrate_law(d, v);
  double low = 0, high = d > 0 ? std::min(v, (1 - 1e-9) / d) : v;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (integrate_law(d, -middle) < taken ? low : high) = middle;
  }
  return low;
}

class Blow : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(Blow, PartsWithTheSpeedOfTheLawsIntegral) {
  const auto [exponent, damping] = GetParam();
  Model model = build_dropped_ball(0.01);
  model.gravity.uniform.setZero();
  model.bodies[0].v_WB = {0, 0, -2};
  model.contacts[0].exponent = exponent;
  model.contacts[0].stiffness = exponent > 1 ? 4e6 : 1e5;
  model.contacts[0].damping = damping;
  model.contact_substeps = 16;
  Simulation s(model);
  const std::vector<Logged> events = run(s, model, 60);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].name, "touch");
  EXPECT_NEAR(events[0].time, 0.005, 1e-12);
  EXPECT_EQ(events[1].name, "lift");
  const double tolerance =
      exponent > 1 ? 3e-6 : 2e-8;  // n = 1.5: its third derivative grows without bound at the touch
  EXPECT_NEAR(s.state.bodies[0].v.z, calc_speed_after(damping, 2), tolerance);
  const ContactTotals totals = get_contact_totals(s.plan, s.state, 0);
  EXPECT_NEAR(totals.impulse, s.state.bodies[0].v.z + 2, tolerance) << "of 1 kg";
  EXPECT_NEAR(totals.dissipated, 0.5 * (4 - s.state.bodies[0].v.z * s.state.bodies[0].v.z), tolerance * 2);
}
INSTANTIATE_TEST_SUITE_P(Contact, Blow, testing::Combine(testing::Values(1.0, 1.5), testing::Values(0.0, 0.1, 0.6)));

TEST(Contact, ABlowWithTheNamedSpeedHasTheNamedRestitution) {
  for (const double e : {0.999, 0.9, 0.5, 0.2, 0.05}) {
    Model model = build_dropped_ball(0.01);
    model.gravity.uniform.setZero();
    model.bodies[0].v_WB = {0, 0, -2};
    model.contacts[0].restitution = e;
    model.contacts[0].speed = 2;
    model.contact_substeps = 16;
    Simulation s(model);
    run(s, model, 200);
    EXPECT_NEAR(s.state.bodies[0].v.z, e * 2, 1e-6) << "e " << e;
  }
}

TEST(Contact, TheTimeOfTouchIsThatOfTheFall) {
  Model model = build_dropped_ball(0.1);
  Simulation s(model);
  const std::vector<Logged> events = run(s, model, 160);
  ASSERT_GE(events.size(), 1u);
  EXPECT_EQ(events[0].subject, "ball on floor");
  EXPECT_NEAR(events[0].time, std::sqrt(2 * 0.1 / kGravity), 1e-9);
}

TEST(Contact, MomentaAndEnergyAreThoseOfBothBodies) {
  Model model = build_spinning_pair();
  model.contact_substeps = 8;
  Simulation s(model);
  const auto look = [&] {
    EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
    return calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
  };
  const EnergyFlow before = look();
  const auto calc_spin = [&] {  // about W's origin
    Vec3 sum{0, 0, 0};
    for (std::size_t b = 0; b < 2; ++b) {
      const BodyState& body = s.state.bodies[b];
      const Eigen::Vector3d J = model.bodies[b].inertia.diagonal();
      sum += cross(body.p, model.bodies[b].mass * body.v) +
             rotation_matrix(body.q) * Vec3{J.x() * body.w.x, J.y() * body.w.y, J.z() * body.w.z};
    }
    return sum;
  };
  const Vec3 spin = calc_spin();
  const std::vector<Logged> events = run(s, model, 200);
  ASSERT_EQ(events.size(), 2u);
  const EnergyFlow after = look();
  EXPECT_LT(norm(after.momentum - before.momentum), 1e-14 * 10);
  EXPECT_LT(norm(calc_spin() - spin), 1e-9);  // RK4 keeps spin to its error
  EXPECT_GT(get_contact_totals(s.plan, s.state, 0).dissipated, 0.05 * before.kinetic);
  EXPECT_NEAR(after.kinetic + after.strain + after.dissipated, before.kinetic, 1e-6 * before.kinetic);
}

TEST(Contact, ABlockOnAnInclineCreepsBelowTheThresholdAndSlidesAboveIt) {
  constexpr double kFriction = 0.3;
  for (const double slope : {0.29, 0.31}) {
    Model model = build_block_on_feet();
    const double length = std::sqrt(1 + slope * slope);
    model.gravity.uniform = {kGravity * slope / length, 0, -kGravity / length};
    model.contacts[0].friction = kFriction;
    Simulation s(model);
    run(s, model, 2000);
    const double v1 = s.state.bodies[0].v.x;
    run(s, model, 2000);
    const double v2 = s.state.bodies[0].v.x;
    if (slope < kFriction) {
      const double creep = 1e-3 * slope / std::sqrt(kFriction * kFriction - slope * slope);
      EXPECT_NEAR(v2, creep, 1e-6 * creep);
    } else {
      const double sliding = kGravity * (slope - kFriction) / length;  // far above v_s the friction is μ N
      EXPECT_NEAR((v2 - v1) / 2, sliding, 1e-3 * sliding);
    }
  }
}

TEST(Contact, ASlidingBallComesToRollAtFiveSeventhsOfItsSpeed) {
  Model model = build_resting_ball(1e6);
  model.contact_substeps = 16;  // μ N / v_s turns the ball within 0.1 ms
  model.contacts[0].friction = 0.3;
  model.bodies[0].v_WB = {1, 0, 0};
  Simulation s(model);
  run(s, model, 1000);
  const ContactReading contact = calc_contact(s.plan, s.state, 0);
  EXPECT_NEAR(s.state.bodies[0].v.x, 5.0 / 7, 1e-5);
  const double arm = kBallRadius - 0.5 * contact.depth;  // the force acts at the midpoint of the witness points
  EXPECT_NEAR(s.state.bodies[0].v.x, arm * arm / (arm * arm + 0.4 * kBallRadius * kBallRadius), 1e-9);
  EXPECT_NEAR(s.state.bodies[0].w.y * arm, s.state.bodies[0].v.x, 1e-9);
  EXPECT_NEAR(get_contact_totals(s.plan, s.state, 0).dissipated, 1.0 / 7, 1e-5);  // of ½ m v², 2/7
}

// tests/references/tube_reference.py: planar, in x and z.
TEST(Contact, ACapsuleInATubeAgreesWithAnIndependentIntegrationAfterTenBounces) {
  constexpr double kPlace = 1e-8, kTime = 1e-8;  // m and rad; s
  const nlohmann::json reference = load_reference("tube");
  // Each bounce multiplies errors by some three: at 1 ms those of the first touches, 1e-9 s, end at 3e-6 s.
  constexpr double kStep = 1e-4;  // s
  const Model model = build_capsule_in_tube();
  Simulation s(model, {.dt = kStep});
  const std::vector<Logged> events = run(s, model, static_cast<int>(std::lround(reference["t"].get<double>() / kStep)));
  ASSERT_EQ(events.size(), reference["events"].size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].name, reference["events"][i]["name"].get<std::string>()) << i;
    EXPECT_NEAR(events[i].time, reference["events"][i]["t"].get<double>(), kTime) << i;
  }
  const std::vector<double> end = reference["state"];
  const BodyState& body = s.state.bodies[0];
  EXPECT_NEAR(body.p.x, end[0], kPlace);
  EXPECT_NEAR(body.p.z, end[1], kPlace);
  EXPECT_NEAR(2 * std::atan2(body.q.y, body.q.w), end[2], kPlace);
  EXPECT_NEAR(body.v.x, end[3], kPlace);
  EXPECT_NEAR(body.v.z, end[4], kPlace);
  EXPECT_NEAR(body.w.y, end[5], 10 * kPlace);
  EXPECT_NEAR(body.p.y, 0, 1e-12);
}

TEST(Contact, OneThatIsClosedAtTheStartHasNoTouchButALift) {
  Model model = build_resting_ball(1e4);
  model.gravity.uniform.setZero();  // the spring throws it off
  Simulation s(model);
  EXPECT_EQ(s.state.contacts[0].closed, 1);
  const std::vector<Logged> events = run(s, model, 100);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].name, "lift");
  EXPECT_NEAR(events[0].time, std::acos(0.0) / 100, 1e-7);  // a quarter of the period of 100 rad/s
}

TEST(Contact, OneThatIsSwitchedOffIsApartAndTouchesWhenItIsSwitchedOn) {
  Model model = build_resting_ball(1e4);
  model.gravity.uniform.setZero();
  model.contacts[0].on = false;
  Event on;
  on.name = "on";
  on.when = when_time(0.0105);
  Action act;
  act.kind = Action::Kind::kSwitch;
  act.subject = 0;
  act.value = 1;
  on.then = {act};
  model.events.push_back(on);
  Simulation s(model);
  const std::vector<Logged> events = run(s, model, 100);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].name, "on");
  EXPECT_EQ(events[1].name, "touch");
  EXPECT_NEAR(events[1].time, 0.0105, 1e-12);
  EXPECT_EQ(events[2].name, "lift");
  EXPECT_NEAR(events[2].time, 0.0105 + std::acos(0.0) / 100, 1e-7);
}

TEST(Contact, EachPairOfAUnionOfShapesBearsItsPart) {
  Model model = build_block_on_feet();
  Simulation s(model);
  run(s, model, 500);
  int closed = 0;
  for (const ContactState& pair : s.state.contacts) closed += pair.closed != 0;
  EXPECT_EQ(closed, 4);
  EXPECT_NEAR(calc_contact(s.plan, s.state, 0).normal, model.bodies[0].mass * kGravity, 1e-6);
  EXPECT_LT(norm(s.state.bodies[0].w), 1e-9);
}

// Searches of a run that were left open: the latest of each kind.
OpenSearch find_open_search(const Model& model, const PlanOptions& options, int ticks) {
  Simulation s(model, options);
  OpenSearch found;
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    EXPECT_EQ(report.status, StepStatus::kOk);
    if (report.open.unseen > 0) found.contact = report.open.contact;
    if (report.open.unlocated > 0) found.guard = report.open.guard;
  }
  return found;
}

// A surface has one more shape, to which nothing comes near: each of its contacts has two pairs.
Model add_far_shape(Model model) {
  model.surfaces[0].shapes.push_back(build_sphere(0.1, {0, -50, 0}));
  return model;
}

TEST(Contact, AnUnseenTouchIsReportedOfTheContactWhateverPairsItHas) {
  Model model;  // balls that pass a post within one step, each by a hair
  model.surfaces = {{"post", kGround, {build_sphere(0.1)}}};
  for (int k = 0; k < 6; ++k) {
    const std::string name = "ball" + std::to_string(k);
    model.bodies.push_back(box(name, 1, 1, 1, 1));
    model.bodies.back().p_WB = {-0.6 - 0.01 * k, 0.2 + 1e-5, 0};
    model.bodies.back().v_WB = {400, 0, 0};
    model.surfaces.push_back({name, k, {build_sphere(0.1)}});
    model.contacts.push_back(touch("hit" + std::to_string(k), 0, k + 1, 1000));
  }
  const OpenSearch one = find_open_search(model, {}, 3), united = find_open_search(add_far_shape(model), {}, 3);
  EXPECT_GT(one.contact, 0);
  EXPECT_EQ(united.contact, one.contact);
}

TEST(Contact, AnUnlocatedTouchIsReportedOfTheContactWhateverPairsItHas) {
  Model model = build_dropped_ball(0.01);
  model.surfaces.push_back({"above", kGround, {build_sphere(0.1, {0, 0, 50})}});
  model.contacts.insert(model.contacts.begin(), touch("ball above", 2, 1, 1));
  Load thrust;  // it jumps: beside the jump the ball hardly falls
  thrust.name = "thrust";
  thrust.direction = {0, 0, -1};
  thrust.profile.kind = Profile::Kind::kTable;
  thrust.profile.times = {0};
  for (int k = 1; k <= kMostCornerSplits; ++k)  // the step is split at these, and no more at the jump
    thrust.profile.times.push_back(0.0004 * k);
  thrust.profile.values.resize(thrust.profile.times.size());
  thrust.profile.times.insert(thrust.profile.times.end(), {0.004, 0.00401, 0.03});
  thrust.profile.values.insert(thrust.profile.values.end(), {0, 1e6, 1e6});
  model.loads.push_back(thrust);
  model.events.clear();
  const PlanOptions options{.dt = 0.01};
  EXPECT_EQ(find_open_search(model, options, 1).guard, 1);
  model.surfaces[2].shapes.push_back(build_sphere(0.1, {0, -50, 50}));
  EXPECT_EQ(find_open_search(model, options, 1).guard, 1);
}

// Stiffnesses over five decades, hard bodies and soft ones: the number of parts follows from the model alone.
TEST(Contact, AutomaticSubstepsResolveABlowOfAnyStiffness) {
  for (const double exponent : {1.0, 1.5})
    for (const double stiffness : {1e4, 1e5, 1e6, 1e7, 1e8}) {
      Model model = build_dropped_ball(0.01);
      model.gravity.uniform.setZero();
      model.bodies[0].v_WB = {0, 0, -2};
      model.contacts[0].exponent = exponent;
      model.contacts[0].stiffness = exponent > 1 ? 10 * stiffness : stiffness;
      model.contacts[0].damping = 0.1;
      ASSERT_EQ(model.contact_substeps, kAutomaticSubsteps);
      Simulation s(model);
      int most = 0;
      for (int k = 0; k < 80; ++k) {
        const StepReport report = s.advance();
        ASSERT_EQ(report.status, StepStatus::kOk);
        most = std::max(most, report.substeps);
      }
      const double error = std::abs(s.state.bodies[0].v.z - calc_speed_after(0.1, 2));
      EXPECT_LT(error, exponent > 1 ? 1e-4 : 2e-5) << exponent << " " << stiffness << " " << most;
      if (stiffness <= 1e4) {
        EXPECT_LE(most, 16) << "a soft contact needs few parts";
      }
    }
}

TEST(Contact, AutomaticSubstepsLetABodyStick) {
  constexpr double kFriction = 0.4, kSlope = 0.2, kGravity = 9.81;
  Model model = build_dropped_ball(-1e-4);
  model.gravity.uniform = {kSlope * kGravity, 0, -kGravity};
  model.bodies[0].inertia *= 1e9;  // it does not roll
  model.contacts[0].friction = kFriction;
  model.contacts[0].stiffness = 1e5;
  model.contacts[0].damping = 10;
  model.contacts[0].slip_speed = 1e-4;
  Simulation s(model);
  for (int k = 0; k < 300; ++k) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const double creep = 1e-4 * kSlope / std::sqrt(kFriction * kFriction - kSlope * kSlope);
  const double slip = s.state.bodies[0].v.x - s.state.bodies[0].w.y * kBallRadius;  // it rolls slowly all the same
  EXPECT_NEAR(slip, creep, 1e-6 * creep + 1e-9);
}

// A ball of 1 kg slides over the floor, √(k/m)·h = 2: parts of 0.2 would be sixteen.
TEST(Contact, AutomaticSubstepsAreFewWhereABodySlidesAtRestOnAnother) {
  constexpr double kStiffness = 4e6, kRestDepth = kGravity / kStiffness, kFriction = 0.1;
  Model model = build_dropped_ball(-kRestDepth);
  model.bodies[0].v_WB = {3, 0, 0};
  model.bodies[0].inertia *= 1e9;  // it does not roll
  model.contacts[0].stiffness = kStiffness;
  model.contacts[0].damping = 1;
  model.contacts[0].friction = kFriction;
  Simulation s(model);
  for (int k = 0; k < 1000; ++k) {
    const StepReport report = s.advance();
    ASSERT_EQ(report.status, StepStatus::kOk);
    ASSERT_LE(report.substeps, 4) << "at step " << k;
  }
  EXPECT_NEAR(s.state.bodies[0].p.z, kBallRadius - kRestDepth, 1e-4 * kRestDepth);
  EXPECT_NEAR(s.state.bodies[0].v.x, 3 - kFriction * kGravity, 1e-5) << "slip speeds of 1 mm/s and less";
  // A vibration as large as the depth is resolved: a drop onto the floor has parts of 0.3 of 1/ω, of order eight.
  s.state.bodies[0].v.z = -0.01;
  EXPECT_GE(s.advance().substeps, 4);
}

// Balls that circle in a tube: its wall turns the normal, and the depth stays, or grows by what is added outwards.
TEST(Contact, TheDepthsAccelerationIsThatOfTheSurfacesNotOfTheMaterials) {
  constexpr double kTube = 0.5, kDepth = 1e-4, kSpeed = 2, kOutwards = 3;
  Model model = build_dropped_ball(-kDepth);
  geometry::Shape tube{.kind = geometry::ShapeKind::kHollow, .from = {0, 0, -1}, .to = {0, 0, 1}};
  tube.profile = {{.z = 0, .r = kTube}, {.z = 2, .r = kTube}};
  model.surfaces[0].shapes = {tube};
  Simulation s(model);
  const PlanData& plan = get_data(s.plan);
  const double radius = kTube - kBallRadius + kDepth;
  const MovingFrame wall{get_ground<double>(), {{0, 0, 0}, {0, 0, 0}}};
  MovingFrame ball = wall;
  ball.frame.p = {radius, 0, 0};
  ball.frame.v = {0, kSpeed, 0};
  for (const double outwards : {0.0, kOutwards}) {
    ball.acceleration.lin = {outwards - kSpeed * kSpeed / radius, 0, 0};
    const double found = calc_depth_acceleration(plan, plan.contact_pairs[0], wall, ball, 0, 1e-3);
    EXPECT_NEAR(found, outwards, 1e-3 * kSpeed * kSpeed / radius);
  }
}

TEST(Contact, AutomaticSubstepsDependOnTheStateAlone) {
  Model model = build_dropped_ball(0.01);
  model.bodies[0].v_WB = {0.3, 0, -2};
  model.contacts[0].stiffness = 3e6;
  model.contacts[0].friction = 0.3;
  Simulation whole(model);
  int closed = 0;
  for (int k = 0; k < 12; ++k) {
    // Each step from a fresh workspace, as after a checkpoint.
    Simulation fresh(model);
    std::memcpy(fresh.state.get_bytes().data(), whole.state.get_bytes().data(), whole.state.get_bytes().size());
    ASSERT_EQ(whole.advance().status, StepStatus::kOk);
    ASSERT_EQ(fresh.advance().status, StepStatus::kOk);
    ASSERT_EQ(
        std::memcmp(fresh.state.get_bytes().data(), whole.state.get_bytes().data(), whole.state.get_bytes().size()), 0);
    closed += whole.state.contacts[0].closed != 0 ? 1 : 0;
  }
  EXPECT_GT(closed, 0);
}

TEST(Contact, SubstepsBoundTheCostAndRaiseTheAccuracy) {
  double errors[2];
  int i = 0;
  for (const int parts : {4, 32}) {
    Model model = build_dropped_ball(0.01);
    model.gravity.uniform.setZero();
    model.bodies[0].v_WB = {0, 0, -2};
    model.contacts[0].stiffness = 1e6;
    model.contacts[0].damping = 0.1;
    model.contact_substeps = parts;
    Simulation s(model);
    int most = 0;
    for (int k = 0; k < 30; ++k) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk);
      most = std::max(most, report.substeps);
    }
    EXPECT_GE(most, parts);
    EXPECT_LE(most, parts + 2 * 3);  // each event: its try, and two iterations
    errors[i++] = std::abs(s.state.bodies[0].v.z - calc_speed_after(0.1, 2));
  }
  EXPECT_LT(errors[1], 1e-2 * errors[0]);
  EXPECT_LT(errors[1], 1e-6);
}

TEST(Contact, HasTheSameBitsOnEveryInstructionSetAndFromEveryCheckpoint) {
  const Model model = build_heap(6);
  Simulation first(model, {.instruction_set = InstructionSet::kScalar});
  run(first, model, 400);
  for (const InstructionSet set : {InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
    if (!is_supported(set)) continue;
    Simulation s(model, {.instruction_set = set});
    run(s, model, 400);
    EXPECT_EQ(calc_hash(s.state), calc_hash(first.state)) << get_name(set);
  }
  Simulation whole(model), resumed(model);
  run(whole, model, 250);
  const std::span<const std::byte> bytes = whole.state.get_bytes();
  std::memcpy(resumed.state.get_bytes().data(), bytes.data(), bytes.size());
  run(resumed, model, 150);
  EXPECT_EQ(calc_hash(resumed.state), calc_hash(first.state));
}

TEST(Contact, ItsStepsAllocateNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  const Model model = build_heap(6);
  Simulation s(model);
  AllocationCount count;
  for (int i = 0; i < 300; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  EXPECT_EQ(count.get(), 0);
  EXPECT_GT(get_contact_totals(s.plan, s.state, 0).impulse, 0) << "nothing has touched";
}

// A ball passes a thin rail: its distance is √(s² + b²) − R, s = 2 m/s · t, in closed form.
constexpr double kRail = 5e-5;         // m, radius
constexpr double kLocatedPass = 2e-9;  // s: 1e-6 of a step is the tolerance, and the integration is exact

TEST(Contact, OneThatTouchesAndOpensAgainWithinOneStepIsFound) {
  for (const double depth : {3e-5, 1e-5, 1e-6, 1e-7, 1e-8}) {
    const double half = calc_half_chord(kRail, depth);
    ASSERT_LT(2 * half, 1.3e-3) << "below 2 mm, the way of a step";
    for (int phase = 0; phase < 20; ++phase) {
      const double start = 0.01 + 1e-4 * phase + 0.37e-4;
      const Model model = build_passing_ball(kRail, depth, start);
      Simulation s(model);
      const std::vector<Logged> events = run(s, model, 12);
      ASSERT_EQ(events.size(), 2u) << "depth " << depth << ", phase " << phase;
      EXPECT_EQ(events[0].name, "touch");
      EXPECT_EQ(events[1].name, "lift");
      // For a shallow pass the distance determines the time badly: its rounding, 1e-17 m, over the speed of approach.
      const double tolerance = kLocatedPass + 1e-17 / (2 * half / kPassingRadius);
      EXPECT_NEAR(events[0].time, (start - half) / kPassingSpeed, tolerance) << "depth " << depth << ", " << phase;
      EXPECT_NEAR(events[1].time, (start + half) / kPassingSpeed, tolerance) << "depth " << depth << ", " << phase;
      EXPECT_GT(get_contact_totals(s.plan, s.state, 0).impulse, 0);
      EXPECT_GT(s.state.bodies[0].v.y, 0);
    }
  }
}

TEST(Contact, OneThatPassesWithoutATouchHasNone) {
  for (const double gap : {1e-4, 1e-6, 1e-8, 1e-10})
    for (int phase = 0; phase < 20; ++phase) {
      const Model model = build_passing_ball(kRail, -gap, 0.01 + 1e-4 * phase);
      Simulation s(model);
      int tries = 0;
      for (int i = 0; i < 12; ++i) {
        const StepReport report = s.advance();
        ASSERT_EQ(report.status, StepStatus::kOk);
        EXPECT_TRUE(report.events.empty()) << "gap " << gap << ", phase " << phase;
        tries += report.substeps;
      }
      EXPECT_LE(tries, 12 + 9);
      EXPECT_EQ(s.state.bodies[0].v.y, 0);
      EXPECT_NEAR(s.state.bodies[0].p.x, -(0.01 + 1e-4 * phase) + 12e-3 * kPassingSpeed, 1e-15);
    }
}

TEST(Contact, ABallThatFliesThroughARailWithinAStepTouchesIt) {
  Model model = build_passing_ball(kRail, kPassingRadius, 0.0473);
  model.bodies[0].v_WB = {100, 0, 0};  // 10 cm a step
  Simulation s(model);
  const std::vector<Logged> events = run(s, model, 1);
  ASSERT_EQ(events.size(), 2u);
  const double half = calc_half_chord(kRail, kPassingRadius);
  EXPECT_NEAR(events[0].time, (0.0473 - half) / 100, kLocatedPass);
  EXPECT_NEAR(events[1].time, (0.0473 + half) / 100, kLocatedPass);
}

TEST(Contact, TouchesLiftsAndGuardsOfStronglyCurvedDistancesAreLocated) {
  constexpr double kNear = 2e-5;  // m, threshold of the guard
  for (const double depth : {1e-3, 3e-4, 1e-4})
    for (int phase = 0; phase < 20; ++phase) {
      const double start = 0.0504 + 1e-4 * phase;
      Model model = build_passing_ball(kRail, depth, start);
      Event near;
      near.name = "near";
      near.when = when(Condition::Kind::kDistance, 1, 0, kNear);
      near.when.below = true;
      model.events.push_back(near);
      Simulation s(model);
      const std::vector<Logged> events = run(s, model, 60);
      ASSERT_EQ(events.size(), 3u);
      const double half = calc_half_chord(kRail, depth), sum = kPassingRadius + kRail;
      EXPECT_EQ(events[0].name, "near");
      EXPECT_NEAR(events[0].time, (start - std::sqrt((depth + kNear) * (2 * sum - depth + kNear))) / kPassingSpeed,
                  kLocatedPass);
      EXPECT_NEAR(events[1].time, (start - half) / kPassingSpeed, kLocatedPass) << depth << " " << phase;
      EXPECT_NEAR(events[2].time, (start + half) / kPassingSpeed, kLocatedPass) << depth << " " << phase;
    }
}

TEST(Contact, TouchesWithinOneStepActInTheOrderOfTheirTimes) {
  Model model = build_passing_ball(kRail, 1e-6, 0.0109);
  Surface second = model.surfaces[0];  // met 0.4 mm earlier, but with a greater number
  second.name = "second";
  second.shapes[0].from.x = second.shapes[0].to.x = -4e-4;
  model.surfaces.push_back(second);
  model.contacts.push_back(touch("ball on second", 2, 1, 1e-6));
  model.events.clear();
  add_contact_events(model);
  Simulation s(model);
  const std::vector<Logged> events = run(s, model, 12);
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[0].subject, "ball on second");
  const double half = calc_half_chord(kRail, 1e-6);
  EXPECT_NEAR(events[0].time, (0.0105 - half) / kPassingSpeed, kLocatedPass);
  for (std::size_t i = 1; i < events.size(); ++i) EXPECT_GE(events[i].time, events[i - 1].time);
}

TEST(Contact, AConditionOnADistanceIsLocatedAndASensorReadsIt) {
  Model model = build_dropped_ball(0.1);
  model.contacts.clear();
  model.events.clear();
  Event near;
  near.name = "near";
  near.when = when(Condition::Kind::kDistance, 1, 0, 0.05);
  near.when.below = true;
  model.events.push_back(near);
  Sensor sensor;
  sensor.name = "height";
  sensor.kind = Sensor::Kind::kDistance;
  sensor.subject = 1;
  sensor.other = 0;
  model.sensors.push_back(sensor);
  Simulation s(model);
  const std::vector<Logged> events = run(s, model, 110);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_NEAR(events[0].time, std::sqrt(2 * 0.05 / kGravity), 1e-9);
  EXPECT_NEAR(s.workspace.sensors[0], 0.1 - 0.5 * kGravity * 0.11 * 0.11, 1e-12);
}

TEST(Contact, ASensorThatIsLeftUnreadChangesNoStateAndNoOtherSensor) {
  Model model = build_dropped_ball(0.1);
  for (const auto& [name, kind] : {std::pair{"unread", Sensor::Kind::kDistance},
                                   {"read", Sensor::Kind::kDistance},
                                   {"gyro", Sensor::Kind::kRate}}) {
    Sensor sensor;
    sensor.name = name;
    sensor.kind = kind;
    if (kind == Sensor::Kind::kDistance) sensor.subject = 1, sensor.other = 0;
    model.sensors.push_back(sensor);
  }
  Simulation all(model), some(model);
  const int unread[] = {0};
  some.workspace.leave_unread(some.plan, unread);
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(all.advance().status, StepStatus::kOk);
    ASSERT_EQ(some.advance().status, StepStatus::kOk);
    ASSERT_EQ(calc_hash(some.state), calc_hash(all.state)) << i;
    for (std::size_t k = 1; k < all.workspace.sensors.size(); ++k)
      ASSERT_EQ(some.workspace.sensors[k], all.workspace.sensors[k]) << i;
  }
  EXPECT_EQ(some.workspace.sensors[0], 0);
  EXPECT_NE(all.workspace.sensors[0], 0);
  EXPECT_NE(some.workspace.sensors[1], 0);
}

// It slides 0.3 mm above a long bar, so fast that it goes ten times as far in a step; a bar with two feet, which turns.
TEST(Contact, ABodyThatSlidesAlongABarTouchesItWhereItFallsOntoIt) {
  constexpr double kPlay = 3e-4, kSpeed = 3, kTurn = 0.05;  // m, m/s, rad/s
  for (const double turn : {0.0, kTurn}) {
    Model model = build_dropped_ball(kPlay);
    geometry::Shape bar;
    bar.kind = geometry::ShapeKind::kBox;
    bar.size = {4, 0.1, 0.1};
    bar.from = {0, 0, -0.05};
    model.surfaces[0].shapes = {bar};
    constexpr double kHalf = 0.15;  // m, from its middle to each foot
    model.surfaces[1].shapes = {build_sphere(kBallRadius, {-kHalf, 0, 0}), build_sphere(kBallRadius, {kHalf, 0, 0})};
    model.bodies[0].v_WB = {kSpeed, 0, 0};
    model.bodies[0].w_WB_B = {0, turn, 0};  // the fore foot goes down
    Simulation s(model);
    std::vector<Logged> events = run(s, model, 12);
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(events[0].name, "touch");
    double t = 1e-3;  // s, by Newton's method: g t²/2 + h sin(ω t) = play
    for (int i = 0; i < 50; ++i)
      t -= (0.5 * kGravity * t * t + kHalf * std::sin(turn * t) - kPlay) /
           (kGravity * t + kHalf * turn * std::cos(turn * t));
    constexpr double kLocatedTouch = 1e-9;  // s
    EXPECT_NEAR(events[0].time, t, kLocatedTouch) << turn;
  }
}

TEST(Contact, MistakesSayWhereWhatAndHowToMendThem) {
  struct Bad {
    const char* name;
    void (*spoil)(Model&);
    const char *where, *what;
  };
  const Bad cases[] = {
      {"stiffness", [](Model& m) { m.contacts[0].stiffness = 0; }, "contact 'ball on floor'", "stiffness is 0"},
      {"exponent", [](Model& m) { m.contacts[0].exponent = 2; }, "contact 'ball on floor'", "exponent is 2"},
      {"both", [](Model& m) { m.contacts[0].damping = 1, m.contacts[0].restitution = 0.5, m.contacts[0].speed = 1; },
       "contact 'ball on floor'", "both a damping and a restitution"},
      {"plastic", [](Model& m) { m.contacts[0].restitution = 0, m.contacts[0].speed = 1; }, "contact 'ball on floor'",
       "restitution is 0"},
      {"itself", [](Model& m) { m.surfaces[1].body = kGround; }, "contact 'ball on floor'", "one body carries both"},
      {"unknown", [](Model& m) { m.contacts[0].base = 7; }, "contact 'ball on floor'", "do not exist"},
      {"volume", [](Model& m) { m.surfaces[1].shapes[0].radius = 0; }, "surface 'ball', shape 1", "radius is 0"},
      {"empty", [](Model& m) { m.surfaces[1].shapes.clear(); }, "surface 'ball'", "there are none"},
      {"body", [](Model& m) { m.surfaces[1].body = 3; }, "surface 'ball'", "does not exist"},
      {"planes", [](Model& m) { m.surfaces[1].shapes = m.surfaces[0].shapes; }, "contact 'ball on floor'",
       "have no distance"},
      {"parts", [](Model& m) { m.contact_substeps = 65; }, "model", "contact_substeps is 65"},
  };
  EXPECT_TRUE(validate(build_dropped_ball(0.1)).empty());
  for (const Bad& bad : cases) {
    Model model = build_dropped_ball(0.1);
    bad.spoil(model);
    bool found = false;
    for (const ModelError& e : validate(model))
      found = found || (e.where == bad.where && e.what.find(bad.what) != std::string::npos && !e.mend.empty());
    EXPECT_TRUE(found) << bad.name;
  }
}

}  // namespace
}  // namespace unlatch::test::contact_test
