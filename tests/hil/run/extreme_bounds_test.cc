// Extremes of what is known at knots alone: bounds of them, and verdicts that the step does not resolve.
#include "hil/run/extremes/extreme_bounds.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <string>

#include "hil/run/analysis/extreme_verdict.h"
#include "hil/run/findings/findings.h"
#include "hil/scenario/requirements_check.h"
#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::extreme_bounds_test {
namespace {

using ::testing::HasSubstr;

// Bounds of a function at knots, `spacing` apart from `first` on.
hil::ExtremeBounds bound(const std::function<double(double)>& function, double first, double spacing, int knots) {
  hil::ExtremeBounds bounds;
  for (int i = 0; i < knots; ++i) {
    const double time = first + i * spacing;
    bounds.add({time, function(time), i == 0});
  }
  bounds.finish();
  return bounds;
}

// The step that a verdict proposes.
std::string find_proposed_step(const std::string& text) {
  const std::string before = "a step of ";
  const std::size_t from = text.find(before) + before.size();
  return text.substr(from, text.find(" s ", from) - from) + " s";
}

constexpr int kPhases = 40;

TEST(ExtremeBounds, OfSinesAreAboutTheirExtremesAndNarrowWhereTheStepResolvesThem) {
  for (const double angle : {0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 2.6})
    for (int phase = 0; phase < kPhases; ++phase) {
      const auto sine = [](double t) { return std::sin(t) + 0.3; };
      const hil::ExtremeBounds bounds = bound(sine, phase * 0.1571, angle, static_cast<int>(4 + 15 / angle));
      const double room = 2e-6 * std::pow(angle, 4);  // parts of intervals at which it is looked
      EXPECT_LE(bounds.get_low().least, -0.7 + room) << angle << " " << phase;
      EXPECT_GE(bounds.get_low().most, -0.7 - room) << angle << " " << phase;
      EXPECT_LE(bounds.get_high().least, -1.3 + room) << angle << " " << phase;
      EXPECT_GE(bounds.get_high().most, -1.3 - room) << angle << " " << phase;
      if (angle <= 0.4) {
        EXPECT_LT(bounds.get_low().most - bounds.get_low().least, 0.1 * std::pow(angle, 5)) << angle << " " << phase;
      }
    }
}

TEST(ExtremeBounds, OfDipsShorterThanAStepAreAboutTheirDepth) {
  const std::function<double(double)> dips[] = {
      [](double t) { return std::sqrt(t * t + 0.04); },             // all but a corner
      [](double t) { return std::sqrt(t * t + 1); },                // as long as a step
      [](double t) { return 2 - std::exp(-t * t / (1.5 * 1.5)); },  // a pulse, three steps long
      [](double t) { return std::abs(t); },
  };
  for (const auto& dip : dips)
    for (int phase = 0; phase < kPhases; ++phase) {
      const hil::ExtremeBounds bounds = bound(dip, -10 - phase / static_cast<double>(kPhases), 1, 21);
      const double room = dip(0) == 0 ? 0.0625 : 1e-9;  // of a corner: half a part of a step
      EXPECT_LE(bounds.get_low().least, dip(0) + room) << phase;
      EXPECT_GE(bounds.get_low().most, dip(0) - 1e-9) << phase;
    }
}

TEST(ExtremeBounds, OfPolynomialsAndOfWhatRestsAreOneValue) {
  const auto cubic = [](double t) { return (t - 1.3) * (t - 1.3) * (0.2 * t + 1) - 5; };
  const hil::ExtremeBounds bounds = bound(cubic, 0, 0.25, 16);
  EXPECT_NEAR(bounds.get_low().least, -5, 1e-8);  // the vertex of a parabola through parts of an interval
  EXPECT_NEAR(bounds.get_low().most, bounds.get_low().least, 1e-14 * 5);
  const hil::ExtremeBounds rest = bound([](double) { return 0.1; }, 0, 0.25, 16);
  EXPECT_EQ(rest.get_low().least, 0.1);
  EXPECT_EQ(rest.get_low().most, 0.1);
  EXPECT_EQ(rest.get_high().least, -0.1);
}

// Where a smooth run of knots begins or ends, the extreme may be in its first or last interval.
TEST(ExtremeBounds, OfTheFirstAndLastIntervalOfARunAreFoundFromOneSide) {
  for (const double top : {0.13, 0.21, 2.87, 2.79}) {
    const auto pulse = [top](double t) { return std::exp(-(t - top) * (t - top) / 0.18); };
    const hil::ExtremeBounds bounds = bound(pulse, 0, 0.25, 13);
    EXPECT_LE(bounds.get_high().least, -1 + 1e-6) << top;
    EXPECT_GE(bounds.get_high().most, -1 - 1e-6) << top;
  }
}

// Two balls that pass half a metre apart: 0.3 m between them.
std::string pass(const std::string& dt, const std::string& limit, int speed) {
  return "unlatch: 1\nname: pass\nstep: {dt: " + dt + R"(, until: 1 s}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
)" +
         ("  b: {mass: 1, inertia: [1, 1, 1], position: [" + std::to_string(-0.406 * speed) + ", 0.5, 0], velocity: [" +
          std::to_string(speed) + ", 0, 0], shape: [{sphere: {radius: 0.1}}]}") +
         R"(
elements:
  s: {type: spring, between: [a, b], stiffness: 0}
requirements:
  - {id: direct, clearance: [a, b], at_least: 0.29}
  - {id: quantity, quantity: {clearance: {between: [a, b]}}, at_least: )" +
         limit + R"(}
  - {id: length, length: s, at_least: 0.53}
)";
}

// Half a metre apart, while a step is 1 m long, and its finer ones an eighth of that.
TEST(Verdicts, OnADistanceThatIsLeastWithinAStepAreThoseOfFinerSteps) {
  for (const std::string limit : {"0.33", "0.01", "0.299"}) {
    const AnalysedRun run(pass("10 ms", limit, 100));
    for (const std::string id : {"quantity", "length"}) {
      const hil::Verdict verdict = run.judge(id);
      EXPECT_TRUE(verdict.is_resolved()) << verdict.unresolved;
      EXPECT_NEAR(verdict.value, id == "length" ? 0.5 : 0.3, 1e-4);
    }
    EXPECT_EQ(run.judge("quantity").is_met(), limit != "0.33");
  }
}

TEST(Verdicts, OnADistanceThatTheStepDoesNotResolveAreUnresolvedAndTheProposedStepSuffices) {
  for (const std::string limit : {"0.33", "0.01", "0.299"}) {
    const AnalysedRun run(pass("10 ms", limit, 2000));
    EXPECT_TRUE(run.judge("direct").is_met());
    const hil::Verdict coarse = run.judge("quantity");
    EXPECT_FALSE(coarse.is_resolved());
    EXPECT_FALSE(coarse.is_met());
    EXPECT_GT(coarse.uncertainty, std::abs(coarse.value - 0.3));
    EXPECT_THAT(coarse.unresolved, HasSubstr("its extreme between steps, at 0.40"));
    const hil::Verdict fine = AnalysedRun(pass(find_proposed_step(coarse.unresolved), limit, 2000)).judge("quantity");
    EXPECT_TRUE(fine.is_resolved()) << fine.unresolved;
    EXPECT_NEAR(fine.value, 0.3, 0.003);
    EXPECT_EQ(fine.is_met(), limit != "0.33");
  }
  EXPECT_FALSE(AnalysedRun(pass("10 ms", "0.33", 2000)).judge("length").is_resolved());
}

// A block that a sine pushes, and one that it pushes in vain.
std::string shake(const std::string& dt, double frequency) {
  return "unlatch: 1\nname: shake\nstep: {dt: " + dt + R"(, until: 1 s}
bodies:
  b: {mass: 10, inertia: [1, 1, 1]}
  c: {mass: 10, inertia: [1, 1, 1], position: [9, 0, 0]}
joints:
  j: {between: [ground, b], modes: {h: {kind: weld}}}
elements:
  f: {type: force, body: b, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 1000, frequency: )" +
         std::to_string(frequency) + R"(, phase: 0.3}]}}
  g: {type: force, body: c, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 1000, frequency: )" +
         std::to_string(frequency) + R"(, phase: 0.3}]}}
requirements:
  - {id: row, reaction: {joint: j, row: x}, at_most: 1200}
  - {id: size, acceleration: {body: c}, take: peak, at_most: 120}
  - {id: speed, velocity: {body: c, component: x}, at_most: 1000}
)";
}

TEST(Verdicts, OnForcesByASineAreRightToAPercentOrUnresolved) {
  for (const double angle : {0.1, 0.3, 0.5, 0.7, 1.0, 1.3, 1.5, 2.0, 2.5, 3.0, 3.3, 5.0, 6.2831, 6.4, 12.6, 25.19557}) {
    const AnalysedRun run(shake("10 ms", 100 * angle));
    for (const std::string id : {"row", "size"}) {
      const hil::Verdict verdict = run.judge(id);
      const double truth = id == "row" ? 1000 : 100;
      EXPECT_TRUE(!verdict.is_resolved() || std::abs(verdict.value / truth - 1) < 0.01)
          << angle << " " << verdict.value;
      EXPECT_TRUE(verdict.is_resolved() || angle > 0.25) << angle << verdict.unresolved;
    }
  }
}

// A whole number of periods in four fifths of a step or more may look constant to it.
TEST(Verdicts, OnWhatASineFasterThanTheStepPushesAreUnresolvedAndTheProposedStepSuffices) {
  for (const double angle : {1.05, 3.2, 6.2831853, 12.5663706, 25.19557, 40.0}) {
    const AnalysedRun run(shake("10 ms", 100 * angle));
    const hil::Verdict speed = run.judge("speed");
    EXPECT_FALSE(speed.is_resolved()) << angle << " " << speed.value;
    std::string text;
    for (const hil::RunNotice& notice : run.analysis.accuracy().get())
      if (notice.name == "profile") text = notice.text;
    EXPECT_THAT(text, HasSubstr("a step of ")) << angle;
    bool found = false;
    for (const hil::Finding& finding : hil::list_findings(run.scenario, *run.simulation))
      found = found || finding.text.find("its sine of") != std::string::npos;
    EXPECT_TRUE(found) << angle;
    const AnalysedRun fine(shake(find_proposed_step(text), 100 * angle));
    EXPECT_TRUE(fine.judge("speed").is_resolved()) << angle << fine.judge("speed").unresolved;
    // 100 m/s² over the frequency, about what it begins with
    EXPECT_NEAR(fine.judge("speed").value, (1 + std::cos(0.3)) / angle, 2e-3 / angle) << angle;
  }
}

// It turns about z by 10 rad/s: half a turn at 0.314 s, a whole one at 0.628 s, both within steps.
TEST(Verdicts, OnTheAngleOfAnAttitudeSeeHalfATurnAndNone) {
  const AnalysedRun run(R"(unlatch: 1
name: turn
step: {dt: 10 ms, until: 1 s}
bodies:
  s: {mass: 10, inertia: [1, 1, 1], rate: [0, 0, 10]}
events:
  - {name: late, when: {time: 0.1}}
requirements:
  - {id: most, attitude: {body: s}, at_most: 179.9 deg}
  - {id: least, attitude: {body: s}, from: late, at_least: 0.2 deg}
)");
  EXPECT_NEAR(run.judge("most").value, M_PI, 1e-3);
  EXPECT_TRUE(run.judge("most").is_resolved()) << run.judge("most").unresolved;
  EXPECT_FALSE(run.judge("most").is_met());
  EXPECT_NEAR(run.judge("least").value, 0, 1e-3);
  EXPECT_FALSE(run.judge("least").is_met());
}

// The expression's corner is in the step in which the distance is least; the motion, and what else is read off it, goes
// on smoothly there.
TEST(ExtremeBounds, AnExpressionWithACornerChangesNoOtherRequirement) {
  const auto judge = [](const std::string& rest) {
    return AnalysedRun(R"(unlatch: 1
name: pass
step: {dt: 10 ms, until: 1 s}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 1, inertia: [1, 1, 1], position: [-10.062, 0.25, 0], velocity: [20, 0, 0], shape: [{sphere: {radius: 0.1}}]}
sensors: {d: {type: distance, between: [a, b]}}
quantities: {x: {position: {body: b, component: x}}}
requirements:
  - {id: d, sensor: {name: d}, at_least: 0.052}
)" + rest)
        .judge("d");
  };
  const hil::Verdict alone = judge("");
  EXPECT_NEAR(alone.value, 0.05, 1e-4);
  for (const char* const law : {"abs(x)", "max(abs(x), 1 mm)", "1 m^2/(0.1 m + abs(x))", "if_less(x, 0 m, 1 m, 2 m)"}) {
    const hil::Verdict beside = judge("  - {id: e, expression: '" + std::string(law) + "', at_least: -1}\n");
    EXPECT_EQ(beside.value, alone.value) << law;
    EXPECT_EQ(beside.uncertainty, alone.uncertainty) << law;
    EXPECT_EQ(beside.unresolved, alone.unresolved) << law;
  }
}

// 5 m/s² where 1000 are allowed: no verdict is in danger, and the value is right all the same, or says how far it is
// off.
TEST(Verdicts, OnValuesFarFromTheirLimitsAreRightOrSayHowFarTheyAreOff) {
  for (const double angle : {0.2, 0.4, 0.6, 0.7, 0.8, 0.9}) {
    const AnalysedRun run(R"(unlatch: 1
name: far
step: {dt: 10 ms, until: 0.5 s}
bodies:
  c: {mass: 10, inertia: [1, 1, 1]}
elements:
  f: {type: force, body: c, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 50, frequency: )" +
                          std::to_string(100 * angle) + R"(, phase: 0.3}]}}
quantities:
  a: {acceleration: {body: c, component: x}}
requirements:
  - {id: value, quantity: a, at_most: 1000}
  - {id: size, acceleration: {body: c}, take: peak, at_most: 1000}
  - {id: product, expression: '2 * a', at_most: 2000}
  - {id: corner, expression: 'abs(a)', at_most: 1000}
)");
    for (const std::string id : {"value", "size", "product", "corner"}) {
      const hil::Verdict verdict = run.judge(id);
      const double truth = id == "product" ? 10 : 5;
      EXPECT_TRUE(verdict.is_met()) << verdict.unresolved;
      EXPECT_NEAR(verdict.value, truth, std::max(verdict.uncertainty, 1e-3 * truth)) << angle << " " << id;
      EXPECT_NEAR(verdict.value, truth, 1e-3 * truth) << angle << " " << id;
    }
  }
}

// A force that is gone behind the event; the step is taken again for what follows.
TEST(Verdicts, FromOrToAnEventLeaveOutTheOtherSideOfIt) {
  const AnalysedRun run(R"(unlatch: 1
name: behind
step: {dt: 16 ms, until: 128 ms}
bodies:
  c: {mass: 1, inertia: [1, 1, 1]}
elements:
  g: {type: force, body: c, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 0.7501, frequency: 47.7, phase: 5.9}]}}
  h: {type: force, body: c, direction: [0, 1, 0], profile: 3 N}
events:
  - {name: ends, when: {time: 39.031 ms}, then: [{switch: {element: h, to: false}}]}
quantities:
  ax: {acceleration: {body: c, component: x}}
  ay: {acceleration: {body: c, component: y}}
requirements:
  - {id: size, acceleration: {body: c}, from: ends, at_most: 1}
  - {id: law, expression: 'sqrt(ax^2 + ay^2)', from: ends, at_most: 1}
  - {id: before, expression: 'ay - 10 * ax', to: ends, take: minimum, at_least: -5}
)");
  for (const std::string id : {"size", "law", "before"}) {
    const hil::Verdict verdict = run.judge(id);
    EXPECT_NEAR(verdict.value, id == "before" ? 3 - 7.501 * std::sin(47.7 * 0.039031 + 5.9) : 0.7501, 1e-3) << id;
    EXPECT_TRUE(verdict.is_met()) << id << verdict.unresolved;
  }
}

// The load crosses zero between a corner and the end of the run, within one step: no knot is near, and the square of
// the size is no more than the half of what it is at the ends.
TEST(Verdicts, OnALoadThatVanishesBetweenTwoKnotsAloneAreThoseOfAFinerStep) {
  const AnalysedRun run(R"(unlatch: 1
name: corners
step: {dt: 16 ms, until: 96 ms}
bodies:
  d: {mass: 1, inertia: [1, 1, 1]}
joints:
  j: {between: [ground, d], modes: {h: {kind: weld}}}
tables:
  load: {axes: {when: {of: time, at: [0, 20.84 ms, 36.795 ms, 41.67 ms, 71.74 ms, 85.16 ms, 96.96 ms]}}, values: [-0.011, 0.828, 0.125, 0.876, 0.24, 0.839, -0.789], unit: N}
elements:
  p: {type: force, body: d, direction: [0, 1, 0], profile: {expression: "load"}}
events:
  - {name: late, when: {time: 66.126 ms}}
requirements:
  - {id: least, reaction: {joint: j, row: force}, from: late, take: minimum, at_least: 0.1 N}
)");
  const hil::Verdict least = run.judge("least");
  EXPECT_NEAR(least.value, 0, 1e-3);
  EXPECT_FALSE(least.is_met());
}

// Runs of a few steps, with 0.7 to 0.95 rad in each.
TEST(Verdicts, OnAnExtremeInTheFirstStepOfARunAreRight) {
  const std::string forces = R"(
  g: {type: force, body: c, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 2.819, frequency: 51.4004, phase: 4.289}]}}
  h: {type: force, body: c, direction: [0, 1, 0], profile: {harmonic: [{amplitude: 2.756, frequency: 56.687, phase: 4.906}]}}
)";
  const AnalysedRun run(R"(unlatch: 1
name: first
step: {dt: 16 ms, until: 32 ms}
bodies:
  c: {mass: 1, inertia: [1, 1, 1]}
events:
  - {name: late, when: {time: 22.471 ms}}
elements:)" + forces + R"(requirements:
  - {id: size, acceleration: {body: c}, at_most: 3.74}
)");
  const hil::Verdict size = run.judge("size");
  EXPECT_NEAR(size.value, 3.74962, 1e-3);
  EXPECT_FALSE(size.is_met());
}

TEST(Verdicts, OnReactionsInARunOfFewKnotsAreRightAndPeaksWithinTheirBounds) {
  const AnalysedRun run(R"(unlatch: 1
name: few
step: {dt: 16 ms, until: 64 ms}
bodies:
  d: {mass: 1, inertia: [1, 1, 1]}
joints:
  j: {between: [ground, d], modes: {h: {kind: weld}}}
elements:
  f: {type: force, body: d, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 2.741, frequency: 57.4873, phase: 3.387}]}}
  i: {type: force, body: d, direction: [0, 0, 1], profile: 1 N}
events:
  - {name: ends, when: {time: 44.142 ms}, then: [{switch: {element: i, to: false}}]}
requirements:
  - {id: row, reaction: {joint: j, row: x}, at_most: 2.72}
)");
  const hil::Verdict row = run.judge("row");
  EXPECT_NEAR(row.value, 2.741, 1e-3);
  EXPECT_FALSE(row.is_met());
  const hil::PeakReaction peak = run.analysis.get_peak(0, kX);
  EXPECT_NEAR(std::abs(peak.value), 2.741, std::max(peak.uncertainty, 1e-3 * 2.741));
}

// The force comes and goes between ticks; nothing that it pushes is accelerated.
TEST(Verdicts, OnALoadThatIsSwitchedOntoSomethingHeldHaveTheForceOfEitherSide) {
  for (const std::string dt : {"20 ms", "10 ms", "3 ms"}) {
    const AnalysedRun run(R"(unlatch: 1
name: switch
step: {dt: )" + dt + R"(, until: 0.6 s}
bodies:
  b: {mass: 10, inertia: [1, 1, 1]}
joints:
  j: {between: [ground, b], modes: {h: {kind: weld}}}
elements:
  f: {type: force, body: b, direction: [1, 0, 0], profile: 50 N, enabled: false}
events:
  - {name: go, when: {time: 0.1234 s}, then: [{switch: {element: f, to: true}}]}
  - {name: stop, when: {time: 0.4321 s}, then: [{switch: {element: f, to: false}}]}
quantities:
  load: {force: f}
requirements:
  - {id: row, reaction: {joint: j, row: x}, at_most: 51 N}
  - {id: size, reaction: {joint: j, row: force}, at_most: 51 N}
  - {id: load, quantity: load, range: [-1 N, 51 N]}
  - {id: law, expression: '2 * load', at_most: 101 N}
)");
    for (const std::string id : {"row", "size", "load", "law"}) {
      const hil::Verdict verdict = run.judge(id);
      EXPECT_TRUE(verdict.is_met()) << dt << " " << id << " " << verdict.value << " " << verdict.unresolved;
      if (id != "load") {
        EXPECT_NEAR(verdict.value, id == "law" ? 100 : 50, 1e-9) << dt << " " << id;
      }
      EXPECT_FALSE(verdict.is_uncertain());
    }
    EXPECT_NEAR(std::abs(run.analysis.get_peak(0, kX).value), 50, 1e-9) << dt;
  }
}

// A pendulum of 1 m and 10 kg that swings by 60°: at its ends it pulls with m g cos 60°.
TEST(Verdicts, OnTheLeastReactionOfAPendulumAreRightAtALongStep) {
  const AnalysedRun run(R"(unlatch: 1
name: pendulum
step: {dt: 20 ms, until: 4 s}
gravity: {uniform: [0, -9.81, 0]}
bodies:
  b: {mass: 10, inertia: [1e-6, 1e-6, 1e-6], position: [0.8660254037844386, -0.5, 0]}
joints:
  j: {between: [ground, b], point: [0, 0, 0], follower_point: [-0.8660254037844386, 0.5, 0], modes: {h: {kind: revolute, axis: z}}}
events:
  - {name: late, when: {time: 0.1 s}}
requirements:
  - {id: least, reaction: {joint: j, row: force}, take: minimum, from: late, at_least: 40 N}
  - {id: most, reaction: {joint: j, row: force}, at_most: 200 N}
)");
  const hil::Verdict least = run.judge("least"), most = run.judge("most");
  EXPECT_TRUE(least.is_met()) << least.unresolved;
  EXPECT_NEAR(least.value, 49.05, 0.01);
  EXPECT_TRUE(most.is_met()) << most.unresolved;
  EXPECT_NEAR(most.value, 196.2, 0.02);
}

// A cord pulls its ends together, so that its force along its length is never above 0.
TEST(Verdicts, OnTheForceOfACordAreOfItsSignAndALimitThatCannotBeMissedIsNamed) {
  const AnalysedRun run(R"(unlatch: 1
name: cord
step: {dt: 5 ms, until: 1 s}
bodies:
  a: {mass: 1, inertia: [1, 1, 1]}
  b: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0], velocity: [2, 0, 0]}
elements:
  c: {type: cord, between: [a, b], length: 2 m, stiffness: 200}
requirements:
  - {id: signed, force: c, at_most: 8 N}
  - {id: size, force: c, take: peak, at_most: 8 N}
  - {id: lower, force: c, at_least: -8 N}
)");
  EXPECT_NEAR(run.judge("signed").value, 0, 1e-12);
  EXPECT_NEAR(run.judge("size").value, 20, 1e-3);
  EXPECT_NEAR(run.judge("lower").value, -20, 1e-3);
  const std::vector<hil::RequirementProblem> trivial = hil::find_trivial(run.scenario);
  ASSERT_EQ(trivial.size(), 1u);
  EXPECT_EQ(trivial[0].requirement, 0u);
  EXPECT_THAT(trivial[0].what, HasSubstr("the force of 'c'"));
}

// With a new command at each tick nothing goes on smoothly beyond a step.
TEST(Verdicts, BetweenNewCommandsAreThoseOfFinerStepsOrSayThatTheyAreOfTicks) {
  const std::string text = R"(unlatch: 1
name: commands
step: {dt: 10 ms, until: 4 s}
bodies:
  b: {mass: 10, inertia: [1, 1, 1]}
joints:
  j: {between: [ground, b], modes: {h: {kind: weld}}}
channels:
  c: {initial: 1, range: [0, 2]}
elements:
  f: {type: force, body: b, direction: [1, 0, 0], channel: c, profile: {harmonic: [{amplitude: 50, frequency: 60, phase: 0.3}]}}
requirements:
  - {id: row, reaction: {joint: j, row: x}, at_most: 1000}
)";
  const hil::Scenario scenario = hil::load_scenario_text(text, "run.yaml");
  const std::unique_ptr<hil::Simulation> simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  analysis.update(StepReport{});
  double truth = 0;
  for (int tick = 0; tick < 40; ++tick) {
    const double scale = 1 + 0.01 * tick;
    simulation->set_channel(0, scale);
    analysis.update(simulation->step());
    for (int i = 0; i <= 1000; ++i)
      truth = std::max(truth, -50 * scale * std::sin(60 * (tick + 1e-3 * i) * 0.01 + 0.3));
  }
  const hil::Verdict verdict = analysis.judge().front();
  EXPECT_NEAR(verdict.value, truth, 1e-3 * truth);
  EXPECT_FALSE(verdict.is_uncertain());
}

// 4.9 N at a tick; between it and the next, with new commands at both, up to `possible` if it changes there as
// elsewhere.
hil::Verdict judge_between_ticks(double possible, hil::Requirement::Take take, double sign) {
  hil::Requirement requirement;
  requirement.take = take;
  requirement.unit = "N";
  (sign > 0 ? requirement.most : requirement.least) = sign * 5;
  const hil::ExtremeBounds::Bound none{.least = 0, .most = 0, .value = 0};
  const hil::ExtremeBounds::Bound seen{.least = -4.9, .most = -4.9, .value = -4.9, .unsearched = -possible};
  const hil::FoundExtremes found{sign > 0 ? 0 : -4.9, sign > 0 ? 4.9 : 0, sign > 0 ? none : seen,
                                 sign > 0 ? seen : none, hil::SmoothPart::kItself};
  hil::Verdict verdict;
  verdict.evaluated = true;
  verdict.value = (take == hil::Requirement::Take::kPeak ? 1 : sign) * 4.9;
  verdict.limit = sign * 5;
  verdict.margin = 0.1;
  hil::judge_extreme(requirement, found, 0.001, verdict);
  return verdict;
}

TEST(ExtremeBounds, AValueOfTicksAloneIsUnresolvedWhereTheLimitIsWithinWhatItMayBeBetweenThem) {
  using Take = hil::Requirement::Take;
  for (const auto& [take, sign] : {std::pair{Take::kMaximum, 1}, {Take::kMinimum, -1}, {Take::kPeak, 1}}) {
    const hil::Verdict near = judge_between_ticks(5.2, take, sign), far = judge_between_ticks(4.95, take, sign);
    EXPECT_TRUE(near.at_ticks && far.at_ticks);
    EXPECT_TRUE(far.is_resolved()) << far.unresolved;
    EXPECT_THAT(near.unresolved, HasSubstr("as sampled at ticks and events: "));
    EXPECT_THAT(near.unresolved, HasSubstr("5.2 N between two of them"));
    EXPECT_NEAR(std::stod(find_proposed_step(near.unresolved)), 0.001 / 3, 0.01 * 0.001 / 3);
  }
}

}  // namespace
}  // namespace unlatch::test::extreme_bounds_test
