// Rigid contacts of the language, and their results in a run, against closed forms.
#include <cmath>

#include "hil/run/linear/linearization.h"
#include "hil/run/notices/notices.h"
#include "tests/hil/run/analysed_run.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::rigid_contact_test {
namespace {

constexpr double kWeight = 2 * 9.81;  // N

// A ball of 2 kg, `height` above a floor.
std::string build_ball(const std::string& height, const std::string& law, const std::string& rest = "") {
  return R"(unlatch: 1
name: ball
step: {dt: 1 ms, until: 1}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{name: floor, half_space: {point: [0, 0, 0], normal: [0, 0, 1]}}]}
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0.5 + )" +
         height + R"(], shape: [{name: skin, sphere: {radius: 0.5}}]}
contacts:
  blow: {between: [ground.floor, ball], )" +
         law + "}\n" + rest;
}

const hil::RunNotice* find_notice(const AnalysedRun& run, const std::string& name) {
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    if (notice.name == name) return &notice;
  return nullptr;
}

// A ball that slides without friction slips from the end of its bounces on, t (1 + 2 e / (1 − e)) after the start.
TEST(RigidContacts, ThePathOfASlipAfterBouncesThatEndedLiesWithinItsUncertainty) {
  const double end = std::sqrt(2 * 0.2 / 9.81) * 3, exact = 1 * (1 - end);
  for (const char* settle : {"40 ms", "10 ms", "1 ms"}) {
    std::string text = build_ball("0.2", std::string("rigid: true, restitution: 0.5, settle: ") + settle,
                                  "requirements:\n"
                                  "  - {id: slip, contact_slip: blow, take: final, at_most: 1 m}\n"
                                  "  - {id: near, contact_slip: blow, take: final, at_least: 0.394 m}\n");
    text.insert(text.find("position:"), "velocity: [1, 0, 0], ");
    const AnalysedRun run(text);
    const hil::Verdict slip = run.judge("slip");
    EXPECT_GT(slip.uncertainty, 0);
    EXPECT_NEAR(slip.value, exact, slip.uncertainty) << settle;
    EXPECT_LT(slip.uncertainty, 0.1);
    EXPECT_EQ(slip.is_resolved(), slip.uncertainty < 0.01 * slip.value) << settle;
    EXPECT_FALSE(run.judge("near").is_resolved()) << settle << ": the limit lies within what the slip may be";
  }
}

TEST(RigidContacts, EachBounceIsATouchOfTheRecord) {
  const AnalysedRun run(
      build_ball("0.2", "rigid: true, restitution: 0.5, settle: 1 ms",
                 "requirements:\n"
                 "  - {id: first, time: {event: touch:blow}, at_most: 1 s}\n"
                 "  - {id: impulse, contact: {name: blow, value: impulse}, take: final, at_most: 100 N s}\n"
                 "  - {id: force, contact_force: blow, take: final, at_most: 10 N}\n"));
  const std::vector<hil::ContactRecord> contacts = run.analysis.list_contacts();
  ASSERT_EQ(contacts.size(), 1u);
  const double fall = std::sqrt(2 * 0.2 / 9.81), speed = 9.81 * fall;
  EXPECT_NEAR(*contacts[0].touch, fall, 1e-8);
  // flights of 2 · 0.5ⁿ of the fall, down to 1 ms: n = 1 … 8
  ASSERT_EQ(contacts[0].touches, 9);
  ASSERT_EQ(contacts[0].list.size(), 9u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(contacts[0].list[i].time, fall * (3 - 2 * std::pow(0.5, i)), 1e-7) << i;
    EXPECT_EQ(contacts[0].list[i].lift, contacts[0].list[i].time) << i;
    EXPECT_NEAR(contacts[0].list[i].impulse, 2 * 1.5 * speed * std::pow(0.5, i), 1e-6) << i;
    EXPECT_EQ(contacts[0].list[i].duration, 0) << i;
  }
  EXPECT_FALSE(contacts[0].list[8].lift);
  EXPECT_TRUE(contacts[0].closed);
  EXPECT_NEAR(contacts[0].peak_force, kWeight, 1e-8);
  EXPECT_NEAR(contacts[0].totals.impulse, kWeight * 1, 1e-5) << "the weight of one second, and no speed at the end";
  EXPECT_NEAR(contacts[0].totals.dissipated, kWeight * 0.2, 1e-5);
  EXPECT_NEAR(run.judge("first").value, fall, 1e-6);
  EXPECT_NEAR(run.judge("impulse").value, contacts[0].totals.impulse, 1e-12);
  EXPECT_NEAR(run.judge("force").value, kWeight, 1e-9);
  EXPECT_FALSE(run.judge("force").is_met());
  ASSERT_NE(find_notice(run, "contact"), nullptr);
  EXPECT_NE(find_notice(run, "contact")->text.find("shorter than 0.001 s"), std::string::npos)
      << find_notice(run, "contact")->text;
}

TEST(RigidContacts, OneThatBearsAWeightHasItFromTheFirstTick) {
  const AnalysedRun run(build_ball("0", "rigid: true",
                                   "requirements:\n"
                                   "  - {id: least, contact_force: blow, at_least: 19 N}\n"));
  const std::vector<hil::ContactRecord> contacts = run.analysis.list_contacts();
  EXPECT_TRUE(contacts[0].closed_at_start);
  EXPECT_EQ(contacts[0].touches, 0);
  EXPECT_NEAR(contacts[0].duration, 1, 1e-12);
  EXPECT_NEAR(run.judge("least").value, kWeight, 1e-9);
}

// 1 m/s at first, braked by 0.5 m/s², over a floor without friction, and turning at 2 rad/s about the vertical.
TEST(RigidContacts, TheSlipOfOneWithoutFrictionIsItsPath) {
  const AnalysedRun run(R"(unlatch: 1
name: slide
step: {dt: 5 ms, until: 1 s}
gravity: {uniform: [0, 0, -9.81]}
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0.1], velocity: [1, 0, 0], rate: [0, 0, 2], shape: [{sphere: {radius: 0.1}}]}
ground: {shape: [{name: floor, half_space: {point: [0, 0, 0], normal: [0, 0, 1]}}]}
elements:
  brake: {type: force, body: ball, frame: world, direction: [-1, 0, 0], profile: 1 N}
contacts:
  feet: {between: [ground.floor, ball], rigid: true}
requirements:
  - {id: slip, contact_slip: feet, take: final, at_least: 0.7}
)");
  EXPECT_NEAR(run.judge("slip").value, 0.75, 1e-9);
  EXPECT_NEAR(run.analysis.list_contacts()[0].totals.slip, 0.75, 1e-9);
}

// The last part before a lift ends without a force, by which the slips of pairs are weighted.
TEST(RigidContacts, ThePathOfASlipGoesOnUntilTheLift) {
  const AnalysedRun run(R"(unlatch: 1
name: lifted
step: {dt: 10 ms, until: 0.2 s}
gravity: {uniform: [0, 0, -10]}
bodies:
  ball: {mass: 1, inertia: [0.004, 0.004, 0.004], position: [0, 0, 0.1], velocity: [2, 0, 0], shape: [{sphere: {radius: 0.1}}]}
ground: {shape: [{name: floor, half_space: {normal: [0, 0, 1]}}]}
contacts:
  feet: {between: [ground.floor, ball], rigid: true}
elements:
  lift: {type: force, body: ball, frame: world, direction: [0, 0, 1], profile: {table: {times: [0, 95 ms, 2 s], values: [0, 10 N, 15 N]}}}
requirements:
  - {id: slip, contact_slip: feet, take: final, at_most: 1 m}
)");
  EXPECT_NEAR(run.judge("slip").value, 0.19, 1e-9);  // 2 m/s until 95 ms
}

TEST(RigidContacts, TheEnergyBalanceCloses) {
  const hil::Scenario scenario = hil::load_scenario_text(build_ball("0.2", "rigid: true, restitution: 0.5"), "s.yaml");
  const std::unique_ptr<hil::Simulation> simulation = hil::build_simulation(scenario);
  hil::NoticeWatch watch(scenario, *simulation);
  watch.update(StepReport{});
  while (simulation->get_tick() < 1000) {
    const StepReport report = simulation->step();
    ASSERT_EQ(report.status, StepStatus::kOk);
    watch.update(report);
  }
  const hil::EnergyBalance& energy = watch.get_energy();
  EXPECT_LT(std::abs(energy.largest), 1e-6 * energy.scale);
  EXPECT_NEAR(energy.impulses, -kWeight * 0.2, 1e-4);
}

// The force that holds a sphere of 1 mm on the flat would have to pull at the edge, where its centre would turn about
// it with v²/r = 1270 m/s².
TEST(RigidContacts, ASlipLeavesTheEdgeOfATableWithTheSpeedThatItHasThere) {
  for (const double dt : {1e-3, 1.7e-4}) {
    const AnalysedRun run(R"(unlatch: 1
name: edge
step: {dt: )" + std::to_string(dt) +
                          R"(, until: 0.5}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{name: table, box: {centre: [0, 0, -0.05], size: [1, 1, 0.1]}}]}
bodies:
  slider: {mass: 2, inertia: [1e6, 1e6, 1e6], position: [0, 0, 1 mm], velocity: [1.5, 0, 0], shape: [{name: tip, sphere: {radius: 1 mm}}]}
contacts:
  foot: {between: [ground.table, slider], rigid: true, friction: 0.1}
requirements:
  - {id: speed, velocity: {body: slider, along: [1, 0, 0]}, take: final, at_most: 10 m/s}
)");
    const double brake = 0.1 * 9.81, speed = std::sqrt(1.5 * 1.5 - 2 * brake * 0.5);
    EXPECT_NEAR(run.judge("speed").value, speed, 1e-7) << dt;
    const std::vector<hil::ContactRecord> contacts = run.analysis.list_contacts();
    ASSERT_EQ(contacts[0].list.size(), 1u);
    ASSERT_TRUE(contacts[0].list[0].lift);
    EXPECT_NEAR(*contacts[0].list[0].lift, (1.5 - speed) / brake, 1e-7) << dt;
    EXPECT_NEAR(contacts[0].totals.impulse, kWeight * (1.5 - speed) / brake, 1e-5) << dt;
  }
}

// At the ridge of a hull the distance of an open pair and the gap of a closed one differ by some 1e-8 m: the pair opens
// once, and not again and again at one instant.
TEST(RigidContacts, ARoughSphereLeavesTheRidgeOfAHull) {
  const hil::Scenario scenario = hil::load_scenario_text(R"(unlatch: 1
name: ridge
step: {dt: 1 ms, until: 0.3}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{hull: {points: [[-1, -1, 0], [1, -1, 0], [2, -1, -1], [-2, -1, -1], [-1, 1, 0], [1, 1, 0], [2, 1, -1], [-2, 1, -1], [-2, -1, -3], [2, -1, -3], [-2, 1, -3], [2, 1, -3]]}}]}
bodies:
  ball: {mass: 2, inertia: [0.008, 0.008, 0.008], position: [0.85, 0, 0.1], velocity: [2, 0, 0], shape: [{sphere: {radius: 0.1}}]}
contacts:
  skin: {between: [ground, ball], rigid: true, friction: 0.15, settle: 0.1 ms}
)",
                                                         "s.yaml");
  const std::unique_ptr<hil::Simulation> simulation = hil::build_simulation(scenario);
  while (simulation->get_tick() < 100) {
    const StepReport report = simulation->step();
    ASSERT_EQ(report.status, StepStatus::kOk) << simulation->get_tick();
  }
  // It slides up to the edge, 0.15 m, and flies on.
  const double brake = 0.15 * 9.81, speed = std::sqrt(2 * 2 - 2 * brake * 0.15);
  EXPECT_NEAR(simulation->state().bodies[0].v.x, speed, 1e-6);
}

// A block on two feet, b to both sides of its centre, rocks with less and less (G. W. Housner, Bull. Seism. Soc. Am.
// 53, 1963; here without friction, so that its centre moves up and down): each blow leaves the part (J - m b²)/(J + m
// b²) of its rate, and it rests after a sum of infinitely many flights.
TEST(RigidContacts, ABlockThatRocksComesToRestWhenTheSeriesOfItsFlightsEnds) {
  const double m = 2, J = 0.06, b = 0.1, angle = 0.02;
  for (const char* friction : {"", ", friction: 0.3"}) {
    const AnalysedRun run(R"(unlatch: 1
name: rock
step: {dt: 1 ms, until: 0.6}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{name: floor, half_space: {point: [0, 0, 0], normal: [0, 0, 1]}}]}
bodies:
  block: {mass: 2, inertia: [1, 0.06, 1], position: [0, 0, 0.01 + 0.19*cos(0.02) + 0.1*sin(0.02)], attitude: {rotate: [[y, 0.02]]}, shape: [{name: left, sphere: {centre: [-0.1, 0, -0.19], radius: 10 mm}}, {name: right, sphere: {centre: [0.1, 0, -0.19], radius: 10 mm}}]}
contacts:
  left: {between: [ground.floor, block.left], rigid: true)" +
                          std::string(friction) + R"(}
  right: {between: [ground.floor, block.right], rigid: true)" +
                          friction + R"(}
requirements:
  - {id: rate, rate: {body: block}, take: final, at_most: 10 rad/s}
)");
    EXPECT_LT(run.judge("rate").value, 1e-12) << friction;
    EXPECT_TRUE(run.judge("rate").is_met()) << "and resolved";
    const std::vector<hil::ContactRecord> contacts = run.analysis.list_contacts();
    for (const hil::ContactRecord& contact : contacts) {
      EXPECT_TRUE(contact.closed) << friction;
      EXPECT_LT(contact.touches, 16) << friction;
    }
    if (*friction != '\0') continue;  // its feet stick, and the centre moves on arcs
    const double pull = m * 9.81 * b / (J + m * b * b), fall = std::sqrt(2 * angle / pull), rate = pull * fall;
    const double kept = (J - m * b * b) / (J + m * b * b), rest = fall + 2 * rate / pull * kept / (1 - kept);
    const double latest = std::max(contacts[0].list.back().time, contacts[1].list.back().time);
    EXPECT_NEAR(latest, rest, 1e-3) << "what is left are flights below half of a step, and angles of 0.02² beside 0.02";
  }
}

// Flights of 0.15 ms are shorter than half of a step, and yet flights: the ball does not come back by itself.
TEST(RigidContacts, ABallThatRattlesBetweenTwoWallsKeepsItsSpeed) {
  const AnalysedRun run(R"(unlatch: 1
name: rattle
step: {dt: 1 ms, until: 0.05}
ground: {shape: [{name: left, half_space: {point: [-0.01015, 0, 0], normal: [1, 0, 0]}}, {name: right, half_space: {point: [0.01015, 0, 0], normal: [-1, 0, 0]}}]}
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], velocity: [2, 0, 0], shape: [{name: skin, sphere: {radius: 10 mm}}]}
contacts:
  left: {between: [ground.left, ball], rigid: true, restitution: 1}
  right: {between: [ground.right, ball], rigid: true, restitution: 1}
requirements:
  - {id: speed, velocity: {body: ball}, take: final, at_most: 10 m/s}
)");
  EXPECT_NEAR(run.judge("speed").value, 2, 1e-12);
  EXPECT_EQ(run.analysis.list_contacts()[0].touches + run.analysis.list_contacts()[1].touches, 333);
}

TEST(RigidContacts, ABlowThatIsNotFoundExactlyLeavesItsBodiesUnresolved) {
  const hil::Scenario scenario = hil::load_scenario_text(build_ball("0.2", "rigid: true, restitution: 0.5"), "s.yaml");
  const std::unique_ptr<hil::Simulation> simulation = hil::build_simulation(scenario);
  hil::NoticeWatch watch(scenario, *simulation);
  watch.update(StepReport{});
  const auto step = [&](double yielded) {
    StepReport report = simulation->step();
    report.yielded = yielded;
    report.yielding = 0;
    watch.update(report);
    return watch.describe_unresolved();
  };
  EXPECT_EQ(step(1e-7), "");
  EXPECT_NE(step(1e-4).find("found to 1e-04 of its speeds"), std::string::npos);
  EXPECT_NE(step(1e-3).find("found to 1e-03 of its speeds"), std::string::npos);
  EXPECT_NE(step(1e-5).find("found to 1e-03 of its speeds"), std::string::npos);  // the worst
}

TEST(RigidContacts, MistakesSayWhatWouldBeRight) {
  const auto mistakes = [](const std::string& law) { return load_errors(build_ball("0.2", law)); };
  EXPECT_EQ(mistakes("rigid: true"), "");
  EXPECT_NE(mistakes("rigid: true, stiffness: 1 MN/m").find("stiffness"), std::string::npos);
  EXPECT_NE(mistakes("rigid: false").find("no stiffness"), std::string::npos);
  EXPECT_NE(mistakes("rigid: true, restitution: {coefficient: 0.5, speed: 1}").find("one number"), std::string::npos);
  EXPECT_NE(mistakes("stiffness: 1 MN/m, restitution: 0.5").find("{coefficient: 0.5"), std::string::npos);
  EXPECT_NE(mistakes("stiffness: 1 MN/m, settle: 1 ms").find("settle"), std::string::npos);
  EXPECT_EQ(mistakes("rigid: true, friction: 0.2"), "");
  EXPECT_NE(mistakes("rigid: true, friction: 0.2, slip_speed: 1 mm/s").find("no `slip_speed`"), std::string::npos);
  EXPECT_EQ(mistakes("stiffness: 1 MN/m, friction: 0.2, slip_speed: 1 mm/s"), "");
  const std::string rough = mistakes("rigid: true, friction: -0.2");
  EXPECT_NE(rough.find("friction"), std::string::npos) << rough;
  EXPECT_NE(rough.find("s.yaml:9:"), std::string::npos) << rough;
}

TEST(RigidContacts, AFaultNamesTheContactThatCannotBeHeld) {
  // switched on where the ball is in the floor
  const hil::Scenario scenario = hil::load_scenario_text(
      build_ball("0.01", "rigid: true, enabled: false",
                 "events:\n  - {name: shut, when: {time: 0.2}, then: [{switch: {element: blow, to: true}}]}\n"),
      "s.yaml");
  const std::unique_ptr<hil::Simulation> simulation = hil::build_simulation(scenario);
  StepReport report;
  while (report.status == StepStatus::kOk && simulation->get_tick() < 300) report = simulation->step();
  EXPECT_EQ(report.status, StepStatus::kRigidContact);
  EXPECT_NE(hil::describe_fault(report, simulation->get_tick(), scenario.model, scenario.dt).find("at contact 'blow'"),
            std::string::npos);
}

TEST(RigidContacts, NoLinearModelIsMadeOfOneThatIsClosed) {
  const hil::Scenario scenario = hil::load_scenario_text(build_ball("0", "rigid: true"), "s.yaml");
  EXPECT_THROW((void)hil::linearize(scenario, *hil::build_simulation(scenario), {}), hil::LinearizationError);
}

}  // namespace
}  // namespace unlatch::test::rigid_contact_test
