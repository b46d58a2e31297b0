// Requirements of every kind, met and missed, against closed forms.
#include <cmath>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::requirements_test {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kLocated = 1e-6;  // s: minima and peaks are located inside the step
constexpr double kExact = 1e-9;    // relative, if the motion itself is exact to rounding

// Two balls that pass each other: the distance of their surfaces is smallest, 0.25 m, at 0.6172839 s.
const char* const kPass = R"(unlatch: 1
name: pass
step: {dt: 1 ms, until: 1.5}
bodies:
  still: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.25}}]}
  moving: {mass: 1, inertia: [1, 1, 1], position: [-1.2345678, 1, 0], velocity: [2, 0, 0], rate: [0, 0, 1], shape: [{sphere: {radius: 0.5}}]}
events:
  - {name: early, when: {time: 0.2005}}
  - {name: late, when: {time: 0.4005}}
  - {name: never, when: {time: 9}}
  - {name: gone, when: {time: 0.1}, enabled: false}
requirements:
)";

AnalysedRun pass(const std::string& requirements) { return AnalysedRun(kPass + requirements); }

// An arm swings as a (1 - cos w t) with w² = 160 N m / 3 kg m²: its pull at the hinge is greatest in the middle,
// between two ticks.
TEST(PeakReactions, AreLocatedInsideTheStep) {
  const AnalysedRun run(R"(unlatch: 1
name: swing
step: {dt: 1 ms, until: 0.4}
bodies:
  arm: {mass: 2, inertia: [1, 1, 1], position: [cos(0.3), -sin(0.3), 0], attitude: {rotate: [[z, -0.3]]}}
joints:
  hinge: {between: [ground, arm], point: [0, 0, 0], follower_point: [-1, 0, 0], modes: {hinge: {kind: revolute, axis: z}}}
elements:
  spring: {type: joint_spring, joint: hinge, axis: rot_z, stiffness: 160, rest: 0.3}
)");
  const double omega = std::sqrt(160.0 / 3), middle = 0.5 * std::acos(-1.0) / omega;
  const hil::PeakReaction peak = run.analysis.get_peak(0, kX);
  EXPECT_NEAR(peak.time, middle, 1e-6);
  EXPECT_NEAR(peak.value, -2 * 0.09 * omega * omega, 1e-8);
  EXPECT_EQ(run.analysis.get_peak(0, kRotZ).value, 0);  // the hinge does not hold it
}

TEST(Requirements, SmallestClearanceIsLocatedInsideTheStep) {
  const AnalysedRun run = pass(
      "  - {id: kept, clearance: [still, moving], at_least: 0.2}\n"
      "  - {id: broken, clearance: [moving, still], at_least: 0.3}\n");
  const hil::Verdict kept = run.judge("kept"), broken = run.judge("broken");
  EXPECT_NEAR(kept.value, 0.25, kExact);
  EXPECT_NEAR(kept.time, 0.6172839, kLocated);
  EXPECT_NEAR(kept.margin, 0.05, kExact);
  EXPECT_TRUE(kept.is_met());
  EXPECT_NEAR(broken.margin, -0.05, kExact);
  EXPECT_EQ(broken.limit, 0.3);
  EXPECT_FALSE(broken.is_met());
  EXPECT_NEAR(run.analysis.clearances()[0].smallest, 0.25, kExact);
  EXPECT_NEAR(run.analysis.clearances()[0].time, 0.6172839, kLocated);
}

// If a watched pair is far from its smallest distance, most steps are skipped; the values on request are correct all
// the same.
TEST(Requirements, SmallestClearanceIsRightInTheLastStepAndWhenAskedInARun) {
  const std::string kept = "  - {id: kept, clearance: [still, moving], at_least: 0.2}\n";
  std::string ends = kPass + kept;
  ends.replace(ends.find("until: 1.5"), 10, "until: 0.618");  // the smallest is within its last step
  const hil::Verdict last = AnalysedRun(ends).judge("kept");
  EXPECT_NEAR(last.value, 0.25, kExact);
  EXPECT_NEAR(last.time, 0.6172839, kLocated);
  const AnalysedRun run = pass(kept);
  EXPECT_NEAR(run.analysis.get_requirement_now(0), std::hypot(-1.2345678 + 2 * 1.5, 1) - 0.75, kExact);
}

TEST(Requirements, IntervalBetweenTwoEventsLeavesOutTheRest) {
  const AnalysedRun run = pass(
      "  - {id: before, clearance: [still, moving], from: early, to: late, at_least: 0.3}\n"
      "  - {id: last, clearance: [still, moving], take: final, at_least: 0.3}\n"
      "  - {id: greatest, clearance: [still, moving], take: maximum, from: early, to: late, at_most: 0.6}\n");
  const auto distance = [](double t) { return std::hypot(2 * t - 1.2345678, 1.0) - 0.75; };
  EXPECT_NEAR(run.judge("before").value, distance(0.4005), kExact);
  EXPECT_NEAR(run.judge("before").time, 0.4005, kExact);
  EXPECT_NEAR(run.judge("last").value, distance(1.5), kExact);
  EXPECT_NEAR(run.judge("greatest").value, distance(0.2005), kExact);
}

TEST(Requirements, RelativeMotionHasSizeAndComponents) {
  const AnalysedRun run = pass(
      "  - {id: speed, velocity: {body: moving, relative_to: still}, at: late, at_most: 1 m/s}\n"
      "  - {id: away, position: {body: moving, relative_to: still, along: [3, 0, 0]}, at: late, range: [-1, 1]}\n"
      "  - {id: turned, velocity: {body: still, relative_to: moving, along: [1, 0, 0]}, take: final, at_least: 0}\n"
      "  - {id: nearest, position: {body: moving}, at_least: 1}\n");
  EXPECT_NEAR(run.judge("speed").value, 2, kExact);
  EXPECT_FALSE(run.judge("speed").is_met());
  EXPECT_NEAR(run.judge("away").value, 2 * 0.4005 - 1.2345678, kExact);
  EXPECT_TRUE(run.judge("away").is_met());
  EXPECT_NEAR(run.judge("turned").value, -2 * std::cos(1.5),
              kExact);  // axes of the moving body, which turns at 1 rad/s
  EXPECT_NEAR(run.judge("nearest").time, 0.6172839, kLocated);
}

TEST(Requirements, RatesAndAnglesBetweenBodies) {
  const AnalysedRun run = pass(
      "  - {id: rate, rate: {body: moving, relative_to: still}, at: early, at_most: 50 deg/s}\n"
      "  - {id: across, rate: {body: moving, about: [1, 0, 0]}, at: early, at_most: 0.1}\n"
      "  - {id: axes, axes: {body: moving, axis: [1, 0, 0], other: [0, 1, 0]}, at_least: 5 deg}\n");
  EXPECT_NEAR(run.judge("rate").value, 1, kExact);
  EXPECT_FALSE(run.judge("rate").is_met());
  EXPECT_NEAR(run.judge("across").value, 0, kExact);
  EXPECT_NEAR(run.judge("axes").value, kPi / 2 - 1.5, kExact);  // after 1.5 rad
}

TEST(Requirements, TimesAndOrderOfEvents) {
  const AnalysedRun run = pass(
      "  - {id: when, time: {event: late}, range: [0.4, 0.5]}\n"
      "  - {id: between, time: {event: late, after: early}, at_most: 0.1}\n"
      "  - {id: order, order: [early, late], at_least: 0}\n"
      "  - {id: reverse, order: [late, early], at_least: 0}\n");
  EXPECT_NEAR(run.judge("when").value, 0.4005, kExact);
  EXPECT_NEAR(run.judge("when").margin, 0.0005, kExact);
  EXPECT_TRUE(run.judge("when").is_met());
  EXPECT_NEAR(run.judge("between").margin, -0.1, kExact);
  EXPECT_NEAR(run.judge("order").value, 0.2, kExact);
  EXPECT_TRUE(run.judge("order").is_met());
  EXPECT_FALSE(run.judge("reverse").is_met());
}

TEST(Requirements, AnEventThatNeverCameIsNotMet) {
  const AnalysedRun run = pass(
      "  - {id: at, clearance: [still, moving], at: never, at_least: 0}\n"
      "  - {id: to, clearance: [still, moving], to: never, at_least: 0}\n"
      "  - {id: time, time: {event: never}, at_most: 10}\n"
      "  - {id: out, time: {event: gone}, at_most: 10}\n"
      "  - {id: reversed, clearance: [still, moving], from: late, to: early, at_least: 0}\n");
  for (const char* id : {"at", "to", "time", "out", "reversed"}) {
    EXPECT_FALSE(run.judge(id).evaluated) << id;
    EXPECT_FALSE(run.judge(id).is_met()) << id;
    EXPECT_FALSE(run.judge(id).why.empty()) << id;
  }
  EXPECT_EQ(run.judge("time").why, "event 'never' did not occur");
  EXPECT_EQ(run.judge("out").why, "event 'gone' is left out");
}

// A body that a joint holds against a force 10 sin(3 t + 0.2) N, at an arm of 2 m; the joint lets go at 1.00037 s.
const char* const kHeld = R"(unlatch: 1
name: held
step: {dt: 1 ms, until: 1.5}
bodies:
  body: {mass: 2, inertia: [1, 1, 1]}
joints:
  clamp: {between: [ground, body], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
elements:
  shake: {type: force, body: body, point: [0, 2, 0], frame: world, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 10, frequency: 3, phase: 0.2}]}}
sensors:
  load: {type: reaction, joint: clamp}
  felt: {type: specific_force, body: body}
events:
  - {name: release, when: {time: 1.00037}, then: [{set_mode: {joint: clamp, mode: free}}]}
requirements:
)";

TEST(Requirements, PeakReactionIsLocatedAndIsThatBeforeARelease) {
  const AnalysedRun run(std::string(kHeld) +
                        "  - {id: peak, reaction: {joint: clamp, row: x}, at_most: 9}\n"
                        "  - {id: force, reaction: {joint: clamp, row: force}, at_most: 20}\n"
                        "  - {id: moment, reaction: {joint: clamp, row: moment}, at_most: 20.5}\n"
                        "  - {id: signed, reaction: {joint: clamp, row: x}, take: minimum, at_least: -5}\n"
                        "  - {id: released, reaction: {joint: clamp, row: force}, at: release, at_most: 1}\n"
                        "  - {id: sensed, sensor: {name: load, value: x}, take: peak, at_most: 9}\n");
  const double top = (kPi / 2 - 0.2) / 3;
  for (const char* id : {"peak", "force", "sensed"}) {
    EXPECT_NEAR(run.judge(id).value, 10, kExact) << id;
    EXPECT_NEAR(run.judge(id).time, top, kLocated) << id;
  }
  EXPECT_FALSE(run.judge("peak").is_met());
  EXPECT_TRUE(run.judge("force").is_met());
  EXPECT_NEAR(run.judge("moment").value, 20, kExact);
  EXPECT_NEAR(run.judge("signed").value, -10, kExact);
  EXPECT_NEAR(run.judge("released").value, std::abs(10 * std::sin(3 * 1.00037 + 0.2)), kExact);
}

TEST(Requirements, SensorsAreThoseOfTheInstant) {
  const AnalysedRun run(std::string(kHeld) +
                        "  - {id: still, sensor: {name: felt}, to: release, at_most: 0.1}\n"
                        "  - {id: shaken, sensor: {name: felt}, from: release, at_most: 1 m/s2}\n");
  EXPECT_NEAR(run.judge("still").value, 0, kExact);
  // From the release on the force moves the mass alone. It grows up to the end of the run.
  const double end = std::abs(10 * std::sin(3 * 1.5 + 0.2)) / 2;
  EXPECT_NEAR(run.judge("shaken").value, std::max(end, 5.0 * std::abs(std::sin(3 * 1.00037 + 0.2))), 1e-6);
  EXPECT_FALSE(run.judge("shaken").is_met());
}

// A wheel that turns ever faster, 1 rad/s², measured every 10 ms, 0.5 rad/s too high and 20 ms late: at t the received
// rate is 0.5 + the rate at the sample before last, 0.5 + floor(100 t)/100 - 0.02.
const char* const kMeasured = R"(unlatch: 1
name: measured
step: {dt: 1 ms, until: 1}
bodies:
  wheel: {mass: 1, inertia: [1, 1, 1]}
elements:
  motor: {type: torque, body: wheel, frame: world, direction: [0, 0, 1], profile: 1 N m}
sensors:
  gyro: {type: rate, body: wheel, errors: {bias: 0.5 rad/s, delay: 20 ms}}
events:
  - {name: half, when: {time: 0.5055}}
timing: {groups: {slow: {period: 10 ms, sensors: [gyro]}}}
requirements:
  - {id: truth, sensor: {name: gyro, value: z}, take: final, at_most: 1 rad/s}
  - {id: last, sensor: {name: gyro, value: z, received: true}, take: final, at_most: 1 rad/s}
  - {id: half, sensor: {name: gyro, value: z, received: true}, at: half, at_most: 1 rad/s}
  - {id: before, sensor: {name: gyro, value: z, received: true}, from: half, take: minimum, at_least: 1 rad/s}
  - {id: greatest, sensor: {name: gyro, value: z, received: true}, at_most: 1.4 rad/s}
)";

TEST(Requirements, SensorsAsReceivedHaveTheirErrorsAndHoldFromSampleToSample) {
  const AnalysedRun run(kMeasured);
  EXPECT_NEAR(run.judge("truth").value, 1, kExact);
  EXPECT_NEAR(run.judge("last").value, 1.48, kExact);
  EXPECT_NEAR(run.judge("half").value, 0.98, kExact);
  EXPECT_NEAR(run.judge("before").value, 0.98, kExact);
  EXPECT_FALSE(run.judge("before").is_met());
  EXPECT_NEAR(run.judge("greatest").value, 1.48, kExact);
  EXPECT_EQ(run.judge("greatest").time, 1);
  EXPECT_FALSE(run.judge("greatest").is_met());
}

// What a session recorded as received otherwise counts instead.
TEST(Requirements, SensorsAsReceivedAreThoseThatARecordingHas) {
  const AnalysedRun run(kMeasured);
  const hil::Scenario& scenario = run.scenario;
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  analysis.update(StepReport{});
  const hil::LogReceived stuck{2, 7.0};
  analysis.update(simulation->step(), {&stuck, 1});
  EXPECT_EQ(analysis.judge().back().value, 7.0);
}

// A wheel on an axle, at 4 rad/s; it brakes at 1 rad/s² about its axle.
const char* const kWheel = R"(unlatch: 1
name: wheel
step: {dt: 1 ms, until: 5}
bodies:
  wheel: {mass: 2, inertia: [1, 1, 1], rate: [0, 0, 4]}
joints:
  axle: {between: [ground, wheel], modes: {turns: {kind: revolute, axis: z}}}
elements:
  brake: {type: torque, body: wheel, frame: world, direction: [0, 0, 1], profile: -1 N m}
events:
  - {name: half, when: {time: 2.0003}}
requirements:
  - {id: turns, angle: {joint: axle, axis: z}, at_most: 8}
  - {id: half, angle: {joint: axle, axis: z}, at: half, at_least: 360 deg}
  - {id: slows, speed: {joint: axle, axis: rot_z}, at: half, range: [1.9, 2.1]}
  - {id: runs, speed: {joint: axle, axis: rot_z}, at_least: 0}
  - {id: stays, displacement: {joint: axle, axis: x}, range: [-1 mm, 1 mm]}
)";

TEST(Requirements, CoordinatesOfJointsCountTheirTurns) {
  const AnalysedRun run(kWheel);
  EXPECT_NEAR(run.judge("turns").value, 8, 1e-9);  // 4 t − t²/2 is greatest at 4 s, beyond one turn
  EXPECT_NEAR(run.judge("turns").time, 4, kLocated);
  EXPECT_NEAR(run.judge("half").value, 4 * 2.0003 - 0.5 * 2.0003 * 2.0003, kExact);
  EXPECT_FALSE(run.judge("half").is_met());
  EXPECT_NEAR(run.judge("slows").value, 4 - 2.0003, kExact);
  EXPECT_TRUE(run.judge("slows").is_met());
  EXPECT_NEAR(run.judge("runs").value, -1, kExact);
  EXPECT_NEAR(run.judge("stays").value, 0, kExact);
}

TEST(Requirements, DoNotChangeTheModel) {
  const std::string text = kWheel;
  const hil::Scenario with = hil::load_scenario_text(text, "run.yaml");
  const hil::Scenario without = hil::load_scenario_text(text.substr(0, text.find("requirements:")), "run.yaml");
  EXPECT_EQ(hil::build_simulation(with)->get_model_hash(), hil::build_simulation(without)->get_model_hash());
  const AnalysedRun run(text);
  const auto plain = hil::build_simulation(without);  // without stored motion
  while (plain->get_tick() < run.simulation->get_tick()) ASSERT_EQ(plain->step().status, StepStatus::kOk);
  EXPECT_EQ(plain->calc_hash(), run.simulation->calc_hash());
}

std::string get_mistakes(const std::string& requirements) {
  try {
    hil::load_scenario_text(kPass + requirements, "run.yaml");
  } catch (const hil::ScenarioError& error) {
    return error.what();
  }
  return "";
}

TEST(Requirements, MistakesAreReportedWithTheirPlaceAndAGuess) {
  EXPECT_EQ(get_mistakes("  - {id: A, clearance: [still, moved], at: erly, at_least: 1 kg}\n"
                         "  - {id: A, rate: {body: still, relative_to: still}, at: late, from: late, at_most: 1}\n"),
            "run.yaml:13:32: unknown body 'moved'; known: still, moving\n"
            "run.yaml:13:44: unknown event 'erly'; did you mean 'early'? known: early, late, never, gone\n"
            "run.yaml:13:60: '1 kg' is a mass (kg), not a length (m); write a number in m, or followed by mm, cm, km, "
            "in, ft\n"
            "run.yaml:14:5: a second requirement 'A'; give each an id of its own\n"
            "run.yaml:14:46: a body relative to itself; name another body, or ground\n"
            "run.yaml:14:58: an instant and an interval; write either at, or from and to");
}

}  // namespace
}  // namespace unlatch::test::requirements_test
