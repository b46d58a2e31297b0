// Clearances over a run: located inside steps, signed, equal with and without skipped pieces.
#include <cmath>
#include <stdexcept>

#include "hil/run/motion/extreme.h"
#include "tests/hil/run/analysed_run.h"
#include "tests/support/random.h"

namespace unlatch::test::clearance_history_test {
namespace {

constexpr double kExact = 1e-9;    // m, shapes of some metres
constexpr double kLocated = 1e-6;  // s

// A cylinder along x and a tumbling cone that passes it at 5 m/s.
const char* const kPassing = R"(unlatch: 1
name: passing
step: {dt: 1 ms, until: 2}
bodies:
  still: {mass: 1, inertia: [1, 1, 1], shape: [{cylinder: {from: [-2, 0, 0], to: [2, 0, 0], radius: 0.5}}]}
  moving:
    mass: 1
    inertia: [1, 2, 2.5]
    position: [-5, 1.5, 0.3]
    velocity: [5, 0, 0.1]
    rate: [0.5, 3, 2]
    shape: [{cone: {from: [-0.5, 0, 0], to: [0.8, 0, 0], radius: 0.3}}, {sphere: {centre: [0, 0.6, 0], radius: 0.1}}]
clearance: all
)";

// Two events may be as close to each other as times can be distinguished.
TEST(Smallest, IsLocatedBetweenKnotsThatAreRoundingsOfTimeApart) {
  constexpr double kMiddle = 0.8589;  // s
  for (double width = 1e-15; width < 1e-5; width *= 3) {
    const auto function = [&](double time) { return (time - kMiddle) * (time - kMiddle) / (width * width) - 1; };
    const double times[3] = {kMiddle - 2 * width, kMiddle + 0.1 * width, kMiddle + 2 * width};
    int calls = 0;
    const auto counted = [&](double time) {
      EXPECT_LT(++calls, 100) << width;
      if (calls > 200) throw std::runtime_error("the search does not end");
      return function(time);
    };
    hil::Smallest smallest;
    smallest.add(times[0], function(times[0]), times[1], function(times[1]), true, counted);
    smallest.add(times[1], function(times[1]), times[2], function(times[2]), false, counted);
    EXPECT_NEAR(smallest.get_time(), kMiddle, std::max(1e-7 * width, 2e-15)) << width;
  }
}

// Searches every knot and a dense grid between the knots around the smallest.
TEST(Least, AsksAFunctionThatFallsOrRisesAtItsLowerEndAlone) {
  for (const double slope : {-1.0, 1.0}) {
    int asked = 0;
    const auto line = [&](double time) {
      ++asked;
      return slope * time;
    };
    hil::Least least;
    least.look_into(0, 0, 1, slope, 0, line);
    EXPECT_EQ(asked, 1) << slope;
    EXPECT_FALSE(least.has_value()) << slope;
  }
  // A dip is found whichever end is lower.
  for (const double bottom : {0.3, 0.7}) {
    const auto dip = [&](double time) { return (time - bottom) * (time - bottom); };
    hil::Least least;
    least.look_into(0, dip(0), 1, dip(1), 0, dip);
    ASSERT_TRUE(least.has_value()) << bottom;
    EXPECT_NEAR(least.get_time(), bottom, 1e-7);
  }
}

TEST(ClearanceHistory, IsTheSmallestOfADenseSearch) {
  const AnalysedRun run(kPassing);
  const hil::Clearance& found = run.analysis.clearances().at(0);
  const hil::ClearanceMonitor monitor(run.scenario.clearance, run.scenario.shapes);
  const auto calc = [&](const State& state) {
    return monitor.calc(0, hil::to_placement(state.bodies[0]), hil::to_placement(state.bodies[1])).least.distance;
  };
  double smallest = std::numeric_limits<double>::infinity(), at = 0;
  const auto simulation = hil::build_simulation(run.scenario);
  for (int tick = 0; tick <= 2000; ++tick) {
    if (const double value = calc(simulation->state()); value < smallest) smallest = value, at = simulation->get_time();
    simulation->step();
  }
  EXPECT_LE(found.smallest, smallest + kExact);
  EXPECT_GT(found.smallest, smallest - 1e-4);  // between two knots it falls by no more
  EXPECT_NEAR(found.time, at, 1e-3);
  EXPECT_NEAR(found.now, calc(run.simulation->state()), kExact);
  EXPECT_FALSE(found.touch.has_value());
}

// At half and at a quarter of the step the minimum is the same: it does not depend on the places of the knots.
TEST(ClearanceHistory, DoesNotDependOnTheStep) {
  const AnalysedRun run(kPassing);
  for (const char* const step : {"dt: 0.5 ms", "dt: 0.25 ms"}) {
    std::string text = kPassing;
    text.replace(text.find("dt: 1 ms"), 8, step);
    const AnalysedRun finer(text);
    EXPECT_NEAR(finer.analysis.clearances()[0].smallest, run.analysis.clearances()[0].smallest, kExact);
    EXPECT_NEAR(finer.analysis.clearances()[0].time, run.analysis.clearances()[0].time, 1e-5);
  }
}

// Two balls of 0.1 m that meet head on at 1 m/s, pass through one another and separate.
const char* const kThrough = R"(unlatch: 1
name: through
step: {dt: 1 ms, until: 2}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 1, inertia: [1, 1, 1], position: [1.0003, 0.05, 0], velocity: [-1, 0, 0], shape: [{sphere: {radius: 0.1}}]}
clearance: all
)";

TEST(ClearanceHistory, OfAnOverlapIsItsGreatestDepthAndTheTouchIsLocated) {
  const AnalysedRun run(kThrough);
  const hil::Clearance& found = run.analysis.clearances().at(0);
  EXPECT_NEAR(found.smallest, -0.15, kExact);
  EXPECT_NEAR(found.time, 1.0003, kLocated);
  ASSERT_TRUE(found.touch.has_value());
  EXPECT_NEAR(*found.touch, 1.0003 - std::sqrt(0.2 * 0.2 - 0.05 * 0.05), kLocated);
  const hil::PairDistance at = run.analysis.calc_witnesses(0);
  EXPECT_NEAR(norm(at.least.on_a - Vec3{0, 0.1, 0}), 0, 1e-5);
  EXPECT_NEAR(norm(at.least.on_b - Vec3{0, -0.05, 0}), 0, 1e-5);
}

// A bullet of 0.2 mm whose path through a ball lies within one step: no knot is inside.
TEST(ClearanceHistory, ATouchWithinOneStepIsFound) {
  const AnalysedRun run(R"(unlatch: 1
name: bullet
step: {dt: 1 ms, until: 0.02}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 1, inertia: [1, 1, 1], position: [5.25, 0, 0], velocity: [-500, 0, 0], shape: [{sphere: {radius: 0.0001}}]}
clearance: all
)");
  const hil::Clearance& found = run.analysis.clearances().at(0);
  EXPECT_NEAR(found.smallest, -0.1001, 1e-5);
  EXPECT_NEAR(found.time, 0.0105, kLocated);
  ASSERT_TRUE(found.touch.has_value());
  EXPECT_NEAR(*found.touch, (5.25 - 0.1001) / 500, kLocated);
}

// A sphere of 5 mm at 10 m/s passes a sphere of 10 mm within one step, and comes ever nearer to a rod: the values at
// the ticks fall steadily.
const char* const kPassesWithinAStep = R"(unlatch: 1
name: passes
step: {dt: 10 ms, until: 0.04}
ground:
  shape:
    - {sphere: {centre: [0.05, 0, 0], radius: 0.01}}
    - {capsule: {from: [0.1, 0.03, 0], to: [0.5, 0.015, 0], radius: 0.002}}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], velocity: [10, 0, 0], shape: [{sphere: {radius: 0.005}}]}
)";

TEST(ClearanceHistory, AGroupIsSearchedWithinStepsWhoseEndsDoNotShowItsDip) {
  const AnalysedRun run(std::string(kPassesWithinAStep) + "clearance: all\n");
  const hil::Clearance& found = run.analysis.clearances().at(0);
  EXPECT_NEAR(found.smallest, -0.015, kExact);
  EXPECT_NEAR(found.time, 0.005, kLocated);
  ASSERT_TRUE(found.touch.has_value());
  EXPECT_NEAR(*found.touch, (0.05 - 0.015) / 10, kLocated);
}

// A ball that flies along a plate 200 times as fast as it comes down to it: within the step in which they touch it
// moves by twice its size.
TEST(ClearanceHistory, OfShapesThatSlideAlongEachOtherTheTouchIsLocated) {
  const AnalysedRun run(R"(unlatch: 1
name: sliding
step: {dt: 10 ms, until: 0.06}
ground: {shape: [{box: {centre: [0, 0, -0.5], size: [8, 4, 1]}}]}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], position: [-1, 0, 0.1045], velocity: [20, 0, -0.1], shape: [{sphere: {radius: 0.1}}]}
clearance: all
)");
  const hil::Clearance& found = run.analysis.clearances().at(0);
  ASSERT_TRUE(found.touch.has_value());
  EXPECT_NEAR(*found.touch, 0.0045 / 0.1, kLocated);
}

// Groups of three shapes that fly past each other at a constant velocity: the smallest distance at steps in which the
// bodies move by more than their size is that at steps a hundredth as long.
TEST(ClearanceHistory, OfGroupsAtLongStepsIsThatAtShortOnes) {
  constexpr std::uint64_t kSeed = 61;
  Random random(kSeed);
  const auto draw = [&](double limit) { return std::to_string(limit * (2 * random.uniform() - 1)); };
  int within = 0;
  for (int run = 0; run < 60; ++run) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", run " + std::to_string(run));
    std::string bodies = "bodies:\n";
    for (const char* const name : {"a", "b"}) {
      const double side = name[0] == 'a' ? 0 : 2;
      bodies += std::string("  ") + name + ": {mass: 1, inertia: [1, 1, 1], position: [" + std::to_string(-side) +
                ", " + draw(0.3) + ", " + draw(0.3) + "], velocity: [" + std::to_string(4 * side) + ", " + draw(1) +
                ", " + draw(1) + "], shape: [";
      for (int k = 0; k < 3; ++k) {
        const std::string at = "[" + draw(1) + ", " + draw(0.5) + ", " + draw(0.5) + "]";
        bodies += k == 1 ? "{box: {centre: " + at + ", size: [0.1, 0.2, 0.05]}}, "
                         : "{sphere: {centre: " + at + ", radius: 0.05}}" + (k == 0 ? ", " : "");
      }
      bodies += "]}\n";
    }
    const auto fly = [&](const char* dt) {
      return AnalysedRun("unlatch: 1\nname: pass\nclearance: all\nstep: {dt: " + std::string(dt) + ", until: 0.5}\n" +
                         bodies)
          .analysis.clearances()
          .at(0);
    };
    const hil::Clearance coarse = fly("50 ms"), fine = fly("0.5 ms");
    EXPECT_NEAR(coarse.smallest, fine.smallest, kExact);
    within += std::abs(std::remainder(fine.time, 0.05)) > 1e-3;
  }
  EXPECT_GT(within, 40) << "of 60: the smallest is seldom at a tick";
}

// An event that waits for that distance does not act, and the run is unresolved; at a step that shows the instant it
// acts.
TEST(ClearanceHistory, ADistanceThatNoTickShowsToAnEventIsReported) {
  const std::string near =
      std::string(kPassesWithinAStep) +
      "events: [{name: near, when: {clearance: {between: [ball, ground]}, below: 1 mm}, then: []}]\n";
  const auto count = [](const AnalysedRun& run) {
    return std::ranges::count(run.analysis.accuracy().get(), "search", &hil::RunNotice::name);
  };
  const AnalysedRun coarse(near);
  EXPECT_TRUE(coarse.analysis.timeline.empty());
  ASSERT_EQ(count(coarse), 1);
  EXPECT_NE(coarse.analysis.accuracy().get().at(0).text.find("fell to -0.015 m within a step, at 0.005000 s"),
            std::string::npos)
      << coarse.analysis.accuracy().get().at(0).text;
  EXPECT_NE(coarse.analysis.accuracy().describe_unresolved(), "");
  std::string fine = near;
  fine.replace(fine.find("dt: 10 ms"), 9, "dt: 1 ms");
  const AnalysedRun run(fine);
  EXPECT_EQ(run.analysis.timeline.size(), 1u);
  EXPECT_EQ(count(run), 0);
}

// Five bodies of random shapes that tumble past one another, with all ten pairs watched. Half of the runs accelerate.
std::string draw_swarm(Random& random) {
  const auto draw = [&](double limit) { return std::to_string(limit * (2 * random.uniform() - 1)); };
  const auto draw_three = [&](double limit) {
    return "[" + draw(limit) + ", " + draw(limit) + ", " + draw(limit) + "]";
  };
  const char* const shapes[] = {
      "cylinder: {from: [-0.5, 0, 0], to: [0.5, 0, 0], radius: 0.2}", "box: {size: [0.5, 0.3, 0.7]}",
      "cone: {from: [0, 0, -0.3], to: [0, 0, 0.6], radius: 0.3}", "sphere: {centre: [0.4, 0, 0], radius: 0.2}",
      "capsule: {from: [0, -0.4, 0], to: [0, 0.4, 0.2], radius: 0.1}"};
  std::string text = "unlatch: 1\nname: swarm\nstep: {dt: 2 ms, until: 0.5}\nclearance: all\n";
  if (random.uniform() < 0.5) text += "gravity: {uniform: [0, 0, -9.81]}\n";
  text += "bodies:\n";
  for (int b = 0; b < 5; ++b)
    text += "  b" + std::to_string(b) + ": {mass: 1, inertia: [0.5, 0.6, 0.7], position: " + draw_three(1.5) +
            ", velocity: " + draw_three(4) + ", rate: " + draw_three(b == 0 ? 0 : 8) + ", shape: [{" +
            shapes[random.below(5)] + "}, {" + shapes[random.below(5)] + "}]}\n";
  return text;
}

TEST(ClearanceHistory, HasTheSameBitsWhetherPiecesAreSkippedOrNot) {
  constexpr std::uint64_t kSeed = 26;
  Random random(kSeed);
  int with_minimum = 0;
  for (int run = 0; run < 40; ++run) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", run " + std::to_string(run));
    const hil::Scenario scenario = hil::load_scenario_text(draw_swarm(random), "swarm.yaml");
    const auto simulation = hil::build_simulation(scenario);
    simulation->keep_motion();
    hil::ClearanceHistory some(scenario), all(scenario, hil::Skipping::kOff);
    const auto for_both = [&](const auto& act) { act(some), act(all); };
    hil::MotionWindow window;
    for_both([&](auto& history) { history.begin(0, simulation->state().bodies); });
    for (int tick = 1; tick <= 250; ++tick) {
      ASSERT_EQ(simulation->step().status, StepStatus::kOk);
      const std::span<const MotionKnot> knots = simulation->get_motion();
      window.move_on(knots[0], knots[1]);
      for_both([&](auto& history) { history.add(window); });
      if (tick == 100) for_both([&](auto& history) { history.release(simulation->get_time(), {0, 1}, {2, 3, 4}); });
      if (tick == 200) for_both([&](auto& history) { history.join({1, 2}); });
    }
    for (std::size_t i = 0; i < some.get().size(); ++i) {
      const hil::Clearance &a = some.get()[i], &b = all.get()[i];
      EXPECT_EQ(a.smallest, b.smallest);
      EXPECT_EQ(a.time, b.time);
      EXPECT_EQ(a.touch, b.touch);
      EXPECT_EQ(a.now, b.now);
      EXPECT_EQ(a.rate, b.rate);
      EXPECT_EQ(a.tie.from, b.tie.from);
      EXPECT_EQ(a.tie.to, b.tie.to);
      EXPECT_EQ(a.tie.count, b.tie.count);
      ASSERT_EQ(a.after_release.has_value(), b.after_release.has_value());
      if (a.after_release) {
        EXPECT_EQ(a.after_release->smallest, b.after_release->smallest);
        EXPECT_EQ(a.after_release->time, b.after_release->time);
      }
      with_minimum += a.time > 0 && a.time < 0.5;
    }
  }
  EXPECT_GT(with_minimum, 100) << "of 400: the others end or begin with their smallest";
}

// A nozzle that leaves a skirt: the distance to the wall from inside, without the mated faces.
TEST(ClearanceHistory, ANozzleLeavesItsSkirt) {
  const AnalysedRun run(R"(unlatch: 1
name: interstage
step: {dt: 1 ms, until: 2}
bodies:
  lower:
    mass: 1
    inertia: [1, 1, 1]
    shape: [{name: skirt, hollow_cylinder: {from: [0, 0, 0], to: [2, 0, 0], radius: 1}}]
  upper:
    mass: 1
    inertia: [1, 1, 1]
    velocity: [2, 0.2, 0]
    shape:
      - {name: nozzle, cylinder: {from: [0.5, 0, 0], to: [1.5, 0, 0], radius: 0.6}}
      - {name: tank, cylinder: {from: [2, 0, 0], to: [4, 0, 0], radius: 1}}
clearance:
  - {between: [lower, upper], except: [[lower.skirt, upper.tank]]}
  - [lower.skirt, upper.nozzle]
  - [lower, upper.tank]
)");
  const std::vector<hil::Clearance>& found = run.analysis.clearances();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[1].name_b, "upper.nozzle");
  // The nozzle's end passes the skirt's at 0.75 s, drifting by 0.2 m/s. Then the distance of the two rims is
  // hypot(2 t − 1.5, 0.4 − 0.2 t), least at 3.08 / 4.04 s.
  const double at = 3.08 / 4.04;
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_NEAR(found[i].smallest, std::hypot(2 * at - 1.5, 0.4 - 0.2 * at), kExact);
    EXPECT_NEAR(found[i].time, at, kLocated);
  }
  EXPECT_NEAR(found[2].smallest, 0, kExact);
}

}  // namespace
}  // namespace unlatch::test::clearance_history_test
