// Hostile numbers. For any model, a step does bounded work and ends in a status: the new state is finite, or the old
// one is unchanged (tests/support/survival.h). Where the kernel promises no invalid operation, floating-point traps are
// on: one ends the test. Hostile events: hostile_events_test.cc.
#include <gtest/gtest.h>

#include <iostream>
#include <limits>

#include "tests/support/linkages.h"
#include "tests/support/random.h"
#include "tests/support/random_model.h"
#include "tests/support/reference_models.h"
#include "tests/support/survival.h"

namespace unlatch::test::hostile_test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDenormal = std::numeric_limits<double>::denorm_min();

// --- Traps ----------------------------------------------------------------------------------------------------------

TEST(Traps, CatchAnInvalidOperation) {
  EXPECT_DEATH(
      {
        const Traps traps;
        volatile double zero = 0;
        volatile double none = zero / zero;
        (void)none;
      },
      "");
}

TEST(Hostile, GoodModelsRaiseNoFloatingPointException) {
  constexpr int kTicks = 1500;  // the boosters' events are in the first 1000
  for (const Model& model : {build_soyuz(load_reference("soyuz_nominal")), build_solar(load_reference("solar_elastic")),
                             build_tree3(load_reference("tree3")), build_tree20(load_reference("tree20"))}) {
    SCOPED_TRACE(model.name);
    for (const InstructionSet set :
         {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
      if (!is_supported(set)) continue;
      PlanOptions options;
      options.instruction_set = set;
      Simulation s(model, options);
      const Traps traps;
      EXPECT_EQ(survive(s, kTicks).status, StepStatus::kOk);
    }
  }
}

// Bodies that are eliminated side by side share their loops over rows and degrees of freedom: places that a body does
// not use are masked, after a division by its pivot of zero. That infinity is not used, but it raises a flag, so
// divisions by zero are not trapped here.
TEST(Hostile, RandomModelsRaiseNoFloatingPointException) {
  constexpr std::uint64_t kFirstSeed = 9000, kModels = 40;
  std::cout << "seeds from " << kFirstSeed << '\n';
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kModels; ++seed) {
    SCOPED_TRACE(seed);
    Simulation s(build_random_model(seed));
    const Traps traps(FE_INVALID | FE_OVERFLOW);
    EXPECT_EQ(survive(s, 20).status, StepStatus::kOk);
  }
}

// --- Sizes ----------------------------------------------------------------------------------------------------------

TEST(Hostile, MassRatiosOf1e8Step) {
  constexpr std::uint64_t kFirstSeed = 9100, kModels = 60;
  std::cout << "seeds from " << kFirstSeed << '\n';
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kModels; ++seed) {
    SCOPED_TRACE(seed);
    RandomModelOptions options;
    options.mass_ratio = 1e8;
    EXPECT_EQ(survive(build_random_model(seed, options), 50).status, StepStatus::kOk);
  }
}

// A chain of alternating very light and very heavy bodies.
TEST(Hostile, AChainOfHeavyAndLightLinksSteps) {
  Model model;
  model.gravity.uniform = {0, -9.81, 0};
  for (int k = 0; k < 12; ++k) {
    const double mass = k % 2 == 0 ? 1e4 : 1e-4;
    Body link = box("link" + std::to_string(k), mass, mass * 0.01, mass * 0.1, mass * 0.1);
    link.p_WB = {k + 0.5, 0, 0};
    model.bodies.push_back(link);
    model.joints.push_back(build_joint(k - 1, k, {k == 0 ? 0.0 : 0.5, 0, 0}, {-0.5, 0, 0}, {{"hinge", kRevoluteRows}}));
  }
  Simulation s(model);
  const Traps traps;
  EXPECT_EQ(survive(s, 1000).status, StepStatus::kOk);
}

// Non-finite values that appear only in a sensor.
TEST(Hostile, ASensorThatOverflowsIsRefused) {
  Model model;
  model.bodies = {box("top", 1, 1, 2, 3)};
  model.bodies[0].w_WB_B = {0, 0, 1e10};
  Sensor tip;
  tip.name = "tip";
  tip.kind = Sensor::Kind::kAcceleration;
  tip.point = {1e300, 0, 0};
  EXPECT_EQ(survive(model, 3).status, StepStatus::kOk);
  model.sensors = {tip};
  const Survival survival = survive(model, 3);
  EXPECT_EQ(survival.status, StepStatus::kNotFinite);
  EXPECT_EQ(survival.steps, 0);
}

// Far too stiff for the explicit step: a good step, or the last good state.
TEST(Hostile, StiffnessOf1e12IsIntegratedOrRefused) {
  for (const double stiffness : {1e6, 1e9, 1e12, 1e300}) {
    for (const double dt : {1e-6, 1e-3, 1.0}) {
      SCOPED_TRACE(std::to_string(stiffness) + " N/m, step " + std::to_string(dt) + " s");
      Model model;
      model.bodies = {box("a", 1, 1, 1, 1), box("b", 1e-3, 1e-6, 1e-6, 1e-6)};
      model.bodies[1].p_WB = {1, 0, 0};
      model.point_springs.push_back(build_spring(0, 1, stiffness, 1, 0.9));
      model.joints.push_back(build_joint(0, 1, {0.5, 0, 0}, {-0.5, 0, 0}, {{"ball", kPointRows}}));
      JointSpring torsion;
      torsion.name = "torsion";
      torsion.stiffness = stiffness;
      torsion.rest = 0.1;
      model.joint_springs.push_back(torsion);
      PlanOptions options;
      options.dt = dt;
      survive(model, 300, options);
    }
  }
}

TEST(Hostile, DustAndPlanetsDenormalSpeedsAndForcesStep) {
  Model model;
  model.bodies = {box("dust", 1e-60, 1e-60, 1e-60, 1e-60), box("rock", 1e60, 1e60, 1e60, 1e60)};
  model.bodies[0].v_WB = {kDenormal, -kDenormal, 1e-310};
  model.bodies[0].w_WB_B = {1e-310, kDenormal, 0};
  model.bodies[1].p_WB = {1, 0, 0};
  model.joints.push_back(build_joint(1, 0, {-1, 0, 0}, {0, 0, 0}, {{"ball", kPointRows}, {"free", 0}}));
  Load load;
  load.name = "breath";
  load.direction = {kDenormal, 0, 0};
  load.profile.value = kDenormal;
  model.loads.push_back(load);
  survive(model, 100);
  model.joints[0].mode = 1;
  EXPECT_EQ(survive(model, 100).status, StepStatus::kOk);
}

TEST(Hostile, HugePlacesAndSpeedsStepOrAreRefused) {
  for (const double size : {1e12, 1e100, 1e154, 1e300}) {
    SCOPED_TRACE(size);
    Model model = build_pendulum(false, 1);
    for (Body& body : model.bodies) {
      body.p_WB += Eigen::Vector3d(size, 0, 0);
      body.v_WB += Eigen::Vector3d(0, size, 0);
    }
    survive(model, 20);
    model = build_pendulum(true, size);
    survive(model, 20);
  }
}

// --- Time -----------------------------------------------------------------------------------------------------------

TEST(Hostile, AHugeTimeSteps) {
  Model model = build_pendulum(true, 1);
  model.gravity.uniform = {0, -9.81, 0};
  model.events.push_back({"late", "", when_time(1e12), 0.5, {act_set_mode(0, 1)}, false});
  model.events.push_back({"swing", "", when(Condition::Kind::kSpeed, 0, kRotZ, 0), 0, {}, true});
  for (const std::int64_t tick : {std::int64_t{1'000'000'000'000'000}, std::int64_t{1} << 53, std::int64_t{1} << 60}) {
    SCOPED_TRACE(tick);
    Simulation s(model);
    s.state.header->tick = tick;
    EXPECT_EQ(survive(s, 2000).status, StepStatus::kOk);
  }
}

TEST(Hostile, TinyAndHugeStepsEndInAStatus) {
  for (const double dt : {1e-300, 1e-12, 1e3, 1e200}) {
    SCOPED_TRACE(dt);
    Model model = build_pendulum(true, 1);
    model.gravity.uniform = {0, -9.81, 0};
    model.events.push_back({"swing", "", when(Condition::Kind::kSpeed, 0, kRotZ, 0), 0, {}, true});
    PlanOptions options;
    options.dt = dt;
    const PlanResult result = compile_plan(model, options);
    if (!result.plan) {
      EXPECT_FALSE(result.errors.empty());
      continue;
    }
    survive(model, 100, options);
  }
}

// --- Nothing --------------------------------------------------------------------------------------------------------

TEST(Hostile, WithoutGravityAndThrustNothingChangesItsSpeed) {
  Model model = build_pendulum(false, 0);
  model.joints[0].mode = 2;  // free
  model.channels.push_back({"throttle", 0, 0, 1, 0, "1"});
  Load engine;
  engine.name = "engine";
  engine.profile.value = 1e9;
  engine.channel = 0;
  model.loads.push_back(engine);
  for (Body& body : model.bodies) body.v_WB = {1, 2, 3};
  Simulation s(model);
  const Traps traps;
  EXPECT_EQ(survive(s, 1000).status, StepStatus::kOk);
  for (const BodyState& body : s.state.bodies) {
    EXPECT_EQ(body.v.x, 1);
    EXPECT_EQ(body.v.y, 2);
    EXPECT_EQ(body.v.z, 3);
    EXPECT_EQ(body.w.x, 0);
  }
}

// --- Geometry -------------------------------------------------------------------------------------------------------

// A follower bent by 90° and more about the cross's second axis, at rest or turning through it; and a cross with
// coincident axes.
TEST(Hostile, AUniversalJointPassesItsGimbal) {
  using Eigen::Vector3d;
  Model model;
  model.gravity.uniform = {0, 0, -9.81};
  model.bodies = {box("a", 10, 1, 2, 2.5), box("b", 1, 0.1, 0.2, 0.25)};
  Joint joint = build_joint(0, 1, {1, 0, 0}, {-1, 0, 0}, {{"universal", kPointRows | row_bit(kRotZ)}});
  joint.universal = true;
  joint.follower_axes = Eigen::Matrix3d::Identity();
  model.joints.push_back(joint);
  const auto turn_to = [&model](const Eigen::Quaterniond& q) {
    model.bodies[1].q_WB = q;
    model.bodies[1].p_WB = Vector3d(1, 0, 0) + q * Vector3d(1, 0, 0);
  };
  const Eigen::Quaterniond about_x(Eigen::AngleAxisd(0.3, Vector3d::UnitX()));
  for (const double angle : {M_PI / 2, M_PI / 2 - 1e-12, M_PI / 2 - 1e-4, M_PI - 1e-9}) {
    for (const double turning : {0.0, 1.0, 100.0}) {
      SCOPED_TRACE(std::to_string(angle) + " rad, " + std::to_string(turning) + " rad/s");
      turn_to(about_x * Eigen::AngleAxisd(angle, Vector3d::UnitY()));
      Simulation s(model);
      s.state.bodies[1].w.y = turning;  // the row allows it, but the points do not: the first projection distributes it
      EXPECT_EQ(survive(s, 300).status, StepStatus::kOk);
    }
  }
  turn_to(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ())));
  const PlanResult result = compile_plan(model, {});
  EXPECT_FALSE(result.plan) << "two axes of turning that coincide";
}

// All rods on one line: the next instant the linkage may fold in either direction, and its rows are dependent.
TEST(Hostile, AStretchedFourBarEndsInAStatus) {
  using Eigen::Vector3d;
  const std::vector<Vector3d> axes(4, Vector3d::UnitZ());
  for (const double gap : {0.0, 1e-12, 1e-6}) {
    for (const Vector3d& gravity : {Vector3d(0, 0, 0), Vector3d(0, -9.81, 0), Vector3d(3, -9.81, 1)}) {
      SCOPED_TRACE(gap);
      Simulation s(build_linkage({{0, 0, 0}, {1, gap, 0}, {2, -gap, 0}, {3, 0, 0}}, axes, gravity));
      survive(s, 500);
      for (BodyState& body : s.state.bodies) body.v = {0.3, 1, 0};  // a velocity that no hinge allows
      survive(s, 500);
    }
  }
}

// Coincident loops: every rod twice, all hinges at the same two points.
TEST(Hostile, AlignedLoopsEndInAStatus) {
  using Eigen::Vector3d;
  Model model;
  model.gravity.uniform = {0, -9.81, 0};
  for (int k = 0; k < 6; ++k) {
    model.bodies.push_back(build_rod("rod" + std::to_string(k), Vector3d(0, 0, 0), Vector3d(1, 0, 0)));
    model.joints.push_back(build_hinge(model, kGround, k, Vector3d(0, 0, 0), Vector3d::UnitZ()));
    if (k > 0) model.joints.push_back(build_hinge(model, k - 1, k, Vector3d(1, 0, 0), Vector3d::UnitZ()));
  }
  EXPECT_EQ(survive(model, 500).status, StepStatus::kOk);
  model.joints.back().axes = Eigen::AngleAxisd(0.5, Vector3d::UnitX()).toRotationMatrix() * model.joints.back().axes;
  survive(model, 500);  // one axis askew: nothing can move any more
}

TEST(Hostile, SpringsWithoutLengthAndPlanesWithoutNormalStep) {
  Model model;
  model.bodies = {box("a", 1, 1, 1, 1), box("b", 1, 1, 1, 1)};
  model.point_springs.push_back(build_spring(0, 1, 10, 1, 0.5));
  model.point_springs.back().push_only = true;
  model.point_springs.push_back(build_spring(kGround, 0, 10, 1, 0));
  PlaneTorsion torsion;
  torsion.name = "torsion";
  torsion.base = 0;
  torsion.follower = 1;
  torsion.axis_follower = Eigen::Vector3d::UnitZ();  // along the plane's own normal
  torsion.stiffness = 5;
  torsion.damping = 1;
  model.plane_torsions.push_back(torsion);
  EXPECT_EQ(survive(model, 1000).status, StepStatus::kOk);
}

TEST(Hostile, AFallThroughTheCentreOfGravityEndsInAStatus) {
  for (const double start : {0.0, 1e-200, 1.0}) {
    SCOPED_TRACE(start);
    Model model;
    model.bodies = {box("probe", 1, 1, 1, 1)};
    model.bodies[0].p_WB = {start, 0, 0};
    model.gravity.mu = 4e14;
    survive(model, 100);
  }
}

// Groups of lanes have empty places, which must not be evaluated at the centre of such a field.
TEST(Hostile, SystemsInOrbitDoNotMindTheCentreOfGravity) {
  constexpr std::uint64_t kFirstSeed = 700, kModels = 200;
  std::cout << "seeds from " << kFirstSeed << '\n';
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kModels; ++seed) {
    SCOPED_TRACE(seed);
    RandomModelOptions options;
    options.bodies = 2 + static_cast<int>(seed % 20);
    options.grounded_chance = 0;
    Model model = build_random_model(seed, options);
    model.gravity = {};
    model.gravity.mu = 3.986e14;
    for (Body& body : model.bodies) body.p_WB.x() += 7e6;
    EXPECT_EQ(survive(model, 50).status, StepStatus::kOk);
  }
}

TEST(Hostile, EmptyLanesKeepAwayFromAnyCentreOfGravity) {
  constexpr std::uint64_t kFirstSeed = 700, kModels = 20;
  std::cout << "seeds from " << kFirstSeed << '\n';
  for (const double x : {-1.0, 0.5, 7e6, 2e16, 1e100})
    for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kModels; ++seed) {
      SCOPED_TRACE(std::to_string(seed) + ", centre at " + std::to_string(x));
      RandomModelOptions options;
      options.bodies = 2 + static_cast<int>(seed % 20);
      options.grounded_chance = 0;
      Model model = build_random_model(seed, options);
      model.gravity = {};
      model.gravity.mu = x < 1e10 ? 1.0 : 4e14;
      model.gravity.centre = {x, 0, 0};
      for (Body& body : model.bodies) body.p_WB.y() += 1e6;
      EXPECT_EQ(survive(model, 5).status, StepStatus::kOk);
    }
}

// --- All of it ------------------------------------------------------------------------------------------------------

// Random systems with a few absurd numbers: validate() refuses them, or they step or stop.
TEST(Hostile, RandomModelsWithAbsurdNumbersEndInAStatus) {
  constexpr std::uint64_t kFirstSeed = 9200, kModels = 400;
  std::cout << "seeds from " << kFirstSeed << '\n';
  constexpr double kAbsurd[] = {0, -0.0, kDenormal, 1e-300, 1e-30, 1e30, 1e150, 1e300, -1e300, kInf, kNaN};
  int refused = 0, stopped = 0, stepped = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kModels; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    RandomModelOptions options;
    options.bodies = 1 + random.below(8);
    Model model = build_random_model(seed, options);
    const auto draw = [&] { return kAbsurd[random.below(std::size(kAbsurd))]; };
    const auto draw_body = [&] { return static_cast<std::size_t>(random.below(options.bodies)); };
    if (random.chance(0.3)) model.bodies[draw_body()].mass = draw();
    if (random.chance(0.3)) model.bodies[draw_body()].inertia *= draw();
    if (random.chance(0.3)) model.gravity.uniform.z() = draw();
    if (!compile_plan(model, {}).plan) {
      ++refused;
      continue;
    }
    Simulation s(model);
    BodyState& body = s.state.bodies[draw_body()];
    double* const numbers[] = {&body.p.x, &body.v.y, &body.w.z, &body.q.x};
    const double number = draw();  // a state's numbers are finite at the start
    if (std::isfinite(number)) *numbers[random.below(std::size(numbers))] = number;
    ++(survive(s, 10).status == StepStatus::kOk ? stepped : stopped);
  }
  std::cout << refused << " refused, " << stopped << " stopped, " << stepped << " stepped\n";
  EXPECT_GT(refused, 20);
  EXPECT_GT(stopped, 20);
  EXPECT_GT(stepped, 20);
}

}  // namespace
}  // namespace unlatch::test::hostile_test
