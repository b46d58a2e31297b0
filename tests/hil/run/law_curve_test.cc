// Extremes of expressions within long steps, against closed forms.
#include <cmath>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::law_curve_test {
namespace {

constexpr double kExact = 1e-8;     // m or 1, where the motion is exact: golden section to 1e-8 of 1/64 of the step
constexpr double kLocated = 1e-6;   // s
constexpr double kSpeed = 0.7;      // m/s
constexpr double kCrossing = 0.61;  // s, between the ticks at 0.6 and 0.65 s

// A ball that goes along x with a constant speed, through 0 at kCrossing, and along y with a constant acceleration.
AnalysedRun fly(const std::string& expression, const std::string& limit) {
  return AnalysedRun(R"(unlatch: 1
name: pass
step: {dt: 50 ms, until: 1.2}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], position: [-0.427, 0.3, 0], velocity: [0.7, -1, 0]}
gravity: {uniform: [0, 1.6, 0]}
quantities:
  x: {position: {body: ball, component: x}}
  y: {position: {body: ball, component: y}}
  e: {expression: ")" +
                     expression +
                     R"("}
events:
  - {name: early, when: {time: 0.2}}
  - {name: late, when: {time: 0.4}}
requirements:
  - {id: r, quantity: e, )" +
                     limit + "}\n");
}

double get_y(double time) { return 0.3 - time + 0.8 * time * time; }

// A signal that is raised within a step, near its end: a polynomial through its knots would go far beyond 0 and 1.
AnalysedRun raise(const std::string& quantity, const std::string& limit) {
  return AnalysedRun(R"(unlatch: 1
name: raise
step: {dt: 10 ms, until: 1}
bodies:
  b: {mass: 10, inertia: [1, 1, 1], velocity: [1, 0, 0]}
signals: [s]
quantities:
  q: {)" + quantity + R"(}
  sig: {signal: s}
events:
  - {name: e, when: {time: 0.4199}, then: [{raise: s}]}
requirements:
  - {id: r, quantity: q, )" +
                     limit + "}\n");
}

TEST(LawCurve, ASignalRaisedWithinAStepIsZeroOrOne) {
  EXPECT_EQ(raise("signal: s", "at_most: 1").judge("r").value, 1);
  EXPECT_EQ(raise("signal: s", "at_least: 0").judge("r").value, 0);
  EXPECT_EQ(raise("expression: 3 * sig", "at_most: 3").judge("r").value, 3);
  EXPECT_EQ(raise("expression: 3 * sig", "at_least: 0").judge("r").value, 0);
}

TEST(LawCurve, TheTimeSinceAnEventIsNeverNegative) {
  EXPECT_GE(raise("since: e", "at_least: 0").judge("r").value, 0);
  EXPECT_NEAR(raise("since: e", "at_most: 1").judge("r").value, 1 - 0.4199, 1e-12);
}

TEST(LawCurve, ASizeThatComesToZeroWithinAStepIsZero) {
  const hil::Verdict least = fly("abs(x) / (1 m)", "at_least: 0").judge("r");
  EXPECT_NEAR(least.value, 0, kExact);
  EXPECT_NEAR(least.time, kCrossing, kLocated);
}

TEST(LawCurve, TheGreaterOfTwoIsLeastWhereTheyMeet) {
  // x = y: 0.8 t² − 1.7 t + 0.727 = 0
  const double time = (1.7 - std::sqrt(1.7 * 1.7 - 4 * 0.8 * 0.727)) / 1.6;
  const hil::Verdict least = fly("max(x, y) / (1 m)", "at_least: -1").judge("r");
  EXPECT_NEAR(least.value, get_y(time), kExact);
  EXPECT_NEAR(least.time, time, kLocated);
}

TEST(LawCurve, ADipShorterThanAStepIsFound) {
  // 14 ms wide at its half
  const hil::Verdict least = fly("1 - exp(-(x / (6 mm))^2)", "at_least: 0").judge("r");
  EXPECT_NEAR(least.value, 0, kExact);
  EXPECT_NEAR(least.time, kCrossing, kLocated);
}

TEST(LawCurve, APeakOfASmoothExpressionIsLocated) {
  // y² is greatest at the start, and between them least where y vanishes: (1 ± √0.04) / 1.6
  const hil::Verdict least = fly("(y / (1 m))^2", "at_least: 0").judge("r");
  EXPECT_NEAR(least.value, 0, kExact);
  const hil::Verdict most = fly("-(y / (1 m))^2 - 1", "at_most: 0").judge("r");
  EXPECT_NEAR(most.value, -1, kExact);
}

// A ball that goes along x through 0 at 0.61 s, and a signal that is raised in the same step, before or behind.
hil::Verdict pass_beside_a_signal(const std::string& time) {
  return AnalysedRun(R"(unlatch: 1
name: beside
step: {dt: 50 ms, until: 1.2}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], position: [-0.427, 0, 0], velocity: [0.7, 0, 0]}
signals: [s]
quantities:
  x: {position: {body: ball, component: x}}
  sig: {signal: s}
  e: {expression: "abs(x) / (1 m) + 0 * sig"}
events:
  - {name: raised, when: {time: )" +
                     time + R"(}, then: [{raise: s}]}
requirements:
  - {id: r, quantity: e, at_least: 0}
)")
      .judge("r");
}

TEST(LawCurve, IntervalsBesideAnEventThatChangesWhatItReadsAreSearched) {
  for (const std::string time : {"0.603", "0.617", "0.57", "0.64", "0.66"}) {
    const hil::Verdict least = pass_beside_a_signal(time);
    EXPECT_NEAR(least.value, 0, kExact) << time;
    EXPECT_NEAR(least.time, kCrossing, kLocated) << time;
  }
}

// A body whose longitude goes from half a turn to minus half a turn at some 1.525 s, within a step.
TEST(LawCurve, AnAngleIsSearchedUpToTheEndOfItsRangeAndBehindIt) {
  const auto turn = [](const std::string& expression, const std::string& limit) {
    return AnalysedRun(R"(unlatch: 1
name: turn
step: {dt: 50 ms, until: 3}
environment: {planet: {mu: 0, j2: 0}}
bodies:
  b: {mass: 1, inertia: [1, 1, 1], position: [-7000 km, 3050 km, 0], velocity: [0, -2000 km/s, 0]}
quantities:
  l: {longitude: b}
  e: {expression: ")" + expression +
                       R"("}
requirements:
  - {id: r, quantity: e, )" +
                       limit + "}\n");
  };
  const hil::Verdict most = turn("l", "at_most: 4").judge("r");
  EXPECT_LT(most.value, M_PI + 1e-9);
  const hil::Verdict dip = turn("abs(abs(l) - 3.138)", "at_least: 0").judge("r");
  EXPECT_NEAR(dip.value, 0, 1e-6);
}

// Two accelerations by growing sines of 0.88 and 0.69 rad a step: each period has a new extreme, more than steps are
// taken again.
TEST(LawCurve, AnExtremeOfWhichNoStepIsTakenAgainSaysHowFarItIsOff) {
  const auto judge = [](const std::string& dt, const std::string& law) {
    return AnalysedRun(R"TEXT(unlatch: 1
name: long
step: {dt: )TEXT" + dt +
                       R"TEXT(, until: 4 s}
bodies:
  c: {mass: 1, inertia: [1, 1, 1]}
elements:
  g: {type: force, body: c, direction: [1, 0, 0], profile: {expression: "1 N * (1 + time / (1 s)) * sin(55 * time / (1 s))"}}
  h: {type: force, body: c, direction: [0, 1, 0], profile: {expression: "1 N * (1 + time / (2 s)) * sin(43 * time / (1 s) + 0.7)"}}
quantities:
  ax: {acceleration: {body: c, component: x}}
  ay: {acceleration: {body: c, component: y}}
requirements:
  - {id: r, expression: ')TEXT" +
                       law + R"TEXT(', at_most: 1000}
)TEXT")
        .judge("r");
  };
  for (const std::string law : {"ax * ay", "-ax * ay", "abs(ax) + abs(ay)", "ax^2 * ay", "ax / (4 m/s^2 + ay)"}) {
    const hil::Verdict coarse = judge("16 ms", law), fine = judge("1 ms", law);
    EXPECT_NEAR(coarse.value, fine.value, std::max(coarse.uncertainty, 3e-4 * std::abs(fine.value))) << law;
  }
}

TEST(LawCurve, NeitherKnotsNorDipsBesideItsIntervalCount) {
  const AnalysedRun run = fly("abs(x) / (1 m)", "from: early, to: late, at_least: 0");
  EXPECT_NEAR(run.judge("r").value, kSpeed * (kCrossing - 0.4), kExact);
  const hil::Verdict peak = fly("abs(x) / (1 m)", "from: early, to: late, at_most: 1").judge("r");
  EXPECT_NEAR(peak.value, kSpeed * (kCrossing - 0.2), kExact);
}

// The size of an acceleration has all but a corner where one of its two sines vanishes: least 0.01 m/s2, beside 4 at
// most.
TEST(LawCurve, WhatAnExpressionMakesOfTheSizeOfAVectorThatAllButVanishesIsRightOrSaysHowFarItIsOff) {
  const auto judge = [](const std::string& dt, const std::string& law) {
    return AnalysedRun(R"(unlatch: 1
name: sizes
step: {dt: )" + dt +
                       R"(, until: 400 ms}
bodies:
  a: {mass: 1 kg, inertia: [1, 1, 1]}
elements:
  x: {type: force, body: a, frame: world, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 4 N, frequency: 37 rad/s, phase: 0.2}]}}
  y: {type: force, body: a, frame: world, direction: [0, 1, 0], profile: {harmonic: [{amplitude: 0.01 N, frequency: 37 rad/s, phase: 1.7707963}]}}
quantities:
  q: {acceleration: {body: a}}
requirements:
  - {id: r, expression: ')" +
                       law +
                       R"(', at_least: -1}
)")
        .judge("r");
  };
  for (const std::string dt : {"10 ms", "5 ms", "2 ms"})
    for (const auto& [law, truth] : {std::pair<std::string, double>{"2 * q / (1 m/s2)", 0.02},
                                     {"max(q / (1 m/s2), 0)", 0.01},
                                     {"q / (1 m/s2 + q)", 0.01 / 1.01}}) {
      const hil::Verdict verdict = judge(dt, law);
      EXPECT_NEAR(verdict.value, truth, std::max(verdict.uncertainty, 1e-3 * truth)) << dt << " " << law;
      EXPECT_LT(verdict.value, 1.5 * truth) << dt << " " << law;
    }
}

}  // namespace
}  // namespace unlatch::test::law_curve_test
