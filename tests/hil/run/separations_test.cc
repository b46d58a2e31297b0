// Separations against closed forms: the push of a spring, its end, rates, coning, clearances after the release.
#include <cmath>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::separations_test {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kLocated = 1e-6;  // s
// Relative: a pusher's force has a corner at its end, within one step of h; the error of the step itself is (h ω)³.
constexpr double kPush = 1e-6;

// A spring of 400 N/m, 0.3 m short of its free length, at an arm of ARM m from the satellite's centre of mass; 100 kg
// and 25 kg; the satellite has an inertia of 1e6 kg m² about z.
const char* const kSpring = R"(unlatch: 1
name: spring
step: {dt: 1 ms, until: 2}
bodies:
  stage: {mass: 100, inertia: [1e9, 1e9, 1e9], shape: [{sphere: {radius: 0.1}}]}
  satellite: {mass: 25, inertia: [1e6, 1e6, 1e6], position: [1, 0, 0], shape: [{sphere: {radius: 0.2}}]}
joints:
  bolt1: {between: [stage, satellite], point: [1, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
  bolt2: {between: [stage, satellite], point: [1, 0, 0], modes: {held: {rows: [x]}, free: {rows: []}}, mode: held}
elements:
  pusher: {type: spring, between: [stage, satellite], point: [0.3, ARM, 0], follower_point: [0, ARM, 0], stiffness: 400, free_length: 1, push_only: true}
events:
  - {name: release, subject: first, when: {time: 0.1003}, then: [{set_mode: {joint: bolt1, mode: free}}]}
  - {name: release, subject: last, when: {time: 0.2007}, then: [{set_mode: {joint: bolt2, mode: free}}]}
clearance: all
)";

std::string replace(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

TEST(Separations, ASpringGivesItsEnergyAndMomentum) {
  // One bolt alone holds: before its release the bodies do not move.
  const AnalysedRun run(replace(replace(kSpring, "ARM", "0"), "time: 0.1003", "time: 0.2007"));
  const std::vector<hil::Separation> pairs = run.analysis.list_separations();
  ASSERT_EQ(pairs.size(), 1u);
  const hil::Separation& pair = pairs[0];
  const double reduced = 100.0 * 25.0 / 125.0, omega = std::sqrt(400 / reduced), v = 0.3 * omega;
  EXPECT_NEAR(pair.release, 0.2007, 1e-12);
  EXPECT_NEAR(pair.end, 0.2007 + kPi / 2 / omega, kLocated);
  EXPECT_FALSE(pair.pushes);
  EXPECT_NEAR(pair.along, v, kPush * v);
  EXPECT_NEAR(pair.across, 0, 1e-12);
  EXPECT_EQ(pair.axis, "+x of stage");
  ASSERT_EQ(pair.pushers.size(), 1u);
  EXPECT_EQ(pair.pushers[0].spring, "pusher");
  EXPECT_NEAR(pair.pushers[0].work, 0.5 * 400 * 0.09, kPush * 18);
  EXPECT_NEAR(pair.pushers[0].impulse, reduced * v, kPush * reduced * v);
}

TEST(Separations, AnEccentricSpringTipsOff) {
  const AnalysedRun run(replace(replace(kSpring, "ARM", "0.5"), "time: 0.1003", "time: 0.2007"));
  const std::vector<hil::Separation> pairs = run.analysis.list_separations();
  ASSERT_EQ(pairs.size(), 1u);
  // The satellite turns by some 1e-6 rad during the push: the arm is constant.
  const double inverse = 1 / 100.0 + 1 / 25.0 + 0.25 / 1e6 + 0.25 / 1e9, momentum = 0.3 * std::sqrt(400 / inverse);
  const double rate = momentum * 0.5 / 1e6;
  EXPECT_NEAR(pairs[0].follower.rate.transverse, rate, 1e-5 * rate);
  EXPECT_NEAR(pairs[0].follower.rate.axial, 0, 1e-12);
  EXPECT_NEAR(pairs[0].relative.transverse, rate * (1 + 1e-3), 1e-5 * rate);  // the stage turns oppositely
}

TEST(Separations, TwoJointsPartTheirBodiesOnce) {
  const AnalysedRun run(replace(kSpring, "ARM", "0"));
  const std::vector<hil::Separation> pairs = run.analysis.list_separations();
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_NEAR(pairs[0].release, 0.2007, 1e-12);
  EXPECT_EQ(pairs[0].joint, "bolt2");
  EXPECT_EQ(run.analysis.tip_offs.size(), 2u);
}

// A disc of 2 kg m² about z and 1 kg m² across, spinning about z at 3 rad/s and about x at 1 rad/s.
TEST(Separations, ConingOfASymmetricalBodyIsThatOfFreePrecession) {
  const AnalysedRun run(R"(unlatch: 1
name: disc
step: {dt: 1 ms, until: 1}
bodies:
  disc: {mass: 1, inertia: [1, 1, 2], rate: [1, 0, 3]}
  hub: {mass: 1, inertia: [1, 1, 1], rate: [1, 0, 3]}
joints:
  clamp: {between: [hub, disc], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
events:
  - {name: release, when: {time: 0}, then: [{set_mode: {joint: clamp, mode: free}}]}
)");
  const std::vector<hil::Separation> pairs = run.analysis.list_separations();
  ASSERT_EQ(pairs.size(), 1u);
  const hil::Coning& coning = pairs[0].follower.coning;
  EXPECT_NEAR(coning.half_angle, std::atan2(1.0, 6.0), 1e-12);
  EXPECT_NEAR(coning.period, 2 * kPi / std::hypot(1.0, 6.0), 1e-12);
}

// Two halves on hinges at a fixed base, a bolt between them and a pusher at their tops: a rod of mass m and length l on
// each hinge, which the pusher turns outwards.
const char* const kHalves = R"(unlatch: 1
name: halves
step: {dt: 1 ms, until: 1.5}
bodies:
  left: {mass: 3, inertia: [1, 1, 1], position: [0, 0, 1], shape: [{sphere: {radius: 0.1}}]}
  right: {mass: 3, inertia: [1, 1, 1], position: [1, 0, 1], shape: [{sphere: {radius: 0.1}}]}
joints:
  hinge1: {between: [ground, left], follower_point: [0, 0, -1], modes: {held: {kind: revolute, axis: y}, free: {rows: []}}, mode: held}
  hinge2: {between: [ground, right], point: [1, 0, 0], follower_point: [0, 0, -1], modes: {held: {kind: revolute, axis: y}, free: {rows: []}}, mode: held}
  zip: {between: [left, right], point: [0.5, 0, 0], follower_point: [-0.5, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
elements:
  pusher: {type: pusher, between: [left, right], guide: [1, 0, 0], stroke: 20 mm, preload: 100, stiffness: 0}
events:
  - {name: open, when: {time: 0.1}, then: [{set_mode: {joint: zip, mode: free}}]}
  - {name: leave, when: {time: 1}, then: [{set_mode: {joint: hinge2, mode: free}}]}
clearance: all
)";

TEST(Separations, HalvesThatPartWhileTheirHingesHoldAreAPairWithTheWorkOfTheirSprings) {
  const AnalysedRun run(kHalves);
  const std::vector<hil::Separation> pairs = run.analysis.list_separations();
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].joint, "zip");
  EXPECT_TRUE(pairs[0].indirect);
  EXPECT_NEAR(pairs[0].release, 0.1, 1e-12);
  ASSERT_EQ(pairs[0].pushers.size(), 1u);
  EXPECT_EQ(pairs[0].pushers[0].spring, "pusher");
  EXPECT_EQ(pairs[0].base.bodies, std::vector<int>{0});
  EXPECT_EQ(pairs[0].follower.bodies, std::vector<int>{1});
  EXPECT_EQ(pairs[1].joint, "hinge2");  // leaves the ground, and with it the other half
  EXPECT_FALSE(pairs[1].indirect);
  EXPECT_NEAR(pairs[1].release, 1, 1e-12);
}

// Bolts that open one after the other, and a weld that holds what a bolt joins, part nothing.
TEST(Separations, BodiesThatOtherJointsStillHoldDirectlyHaveNotParted) {
  const AnalysedRun bolts(replace(kSpring, "ARM", "0"));
  EXPECT_EQ(bolts.analysis.list_separations().size(), 1u);
  std::string text = replace(
      kHalves, "hinge1: {between: [ground, left], follower_point: [0, 0, -1], modes: {held: {kind: revolute, axis: y}",
      "hinge1: {between: [ground, left], follower_point: [0, 0, -1], modes: {held: {kind: weld}");
  text = replace(
      text,
      "follower_point: [0, 0, -1], modes: {held: {kind: revolute, axis: y}, free: {rows: []}}, mode: held}\n  zip",
      "follower_point: [0, 0, -1], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}\n  zip");
  const AnalysedRun welded(text);
  const std::vector<hil::Separation> pairs = welded.analysis.list_separations();
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].joint, "hinge2");
}

// Two balls, released at a distance of 1 m, that approach each other at 0.5 m/s after they were joined.
TEST(Separations, AClearanceThatStillClosesAtTheEndIsReported) {
  const char* const text = R"(unlatch: 1
name: closing
step: {dt: 1 ms, until: 1}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 1, inertia: [1, 1, 1], position: [1.2, 0, 0], shape: [{sphere: {radius: 0.1}}]}
joints:
  clamp: {between: [a, b], point: [1.2, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
elements:
  pull: {type: force, body: b, direction: [-1, 0, 0], profile: 0.5 N}
events:
  - {name: release, when: {time: 0.5}, then: [{set_mode: {joint: clamp, mode: free}}]}
clearance: all
)";
  const AnalysedRun run(text);
  const hil::Clearance& clearance = run.analysis.clearances()[0];
  ASSERT_TRUE(clearance.after_release.has_value());
  EXPECT_NEAR(clearance.after_release->smallest, 1 - 0.5 * 0.5 * 0.25, 1e-9);
  EXPECT_NEAR(clearance.after_release->time, 1, 1e-9);
  EXPECT_NEAR(clearance.rate, -0.25, 1e-3);  // the mean of the last step
  EXPECT_EQ(run.analysis.list_separations()[0].pair, 0);
}

TEST(Separations, AClearanceThatDoesNotChangeIsATie) {
  const AnalysedRun run(R"(unlatch: 1
name: tie
step: {dt: 1 ms, until: 1}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 1, inertia: [1, 1, 1], position: [1.2, 0, 0], shape: [{sphere: {radius: 0.1}}]}
clearance: all
)");
  const hil::Clearance& clearance = run.analysis.clearances()[0];
  EXPECT_EQ(clearance.tie.from, 0);
  EXPECT_NEAR(clearance.tie.to, 1, 1e-12);
  EXPECT_GT(clearance.tie.count, 1000);
  EXPECT_FALSE(clearance.after_release.has_value());
}

}  // namespace
}  // namespace unlatch::test::separations_test
