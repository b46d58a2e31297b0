// Outputs of a run: their list, their values against independent formulas, their selection.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "hil/run/outputs/run_outputs.h"
#include "hil/run/run.h"

namespace unlatch::test::outputs_test {
namespace {

using hil::Output;
using testing::ElementsAre;
using testing::HasSubstr;

// A pendulum with a spring along its arm's end, a damped torsion, a jet: everything moves at once.
constexpr const char* kScenario = R"(unlatch: 1
name: outputs
step: {dt: 0.001, until: 0.5}
gravity: {uniform: [0, 0, -9.81]}
bodies:
  arm: {mass: 2 kg, inertia: [0.1, 0.2, 0.15], position: [0.5, 0, 0], shape: [{sphere: {radius: 0.1}}]}
  ball: {mass: 1 kg, inertia: [0.01, 0.02, 0.03], position: [2, 0, 0.3], rate: [0.3, 0.2, 0.1], shape: [{sphere: {radius: 0.1}}]}
joints:
  hinge: {between: [ground, arm], follower_point: [-0.5, 0, 0], modes: {turns: {kind: revolute, axis: y}}, mode: turns}
elements:
  spring: {type: spring, between: [arm, ball], point: [0.5, 0, 0], follower_point: [0, 0, 0], stiffness: 20, damping: 0.5, free_length: 0.8}
  jet: {type: force, body: ball, direction: [0, 0, 2], profile: 3 N}
sensors:
  gyro: {type: rate, body: ball}
clearance: [[arm, ball]]
)";

struct OutputsTest : testing::Test {
  void load(const std::string& more = {}) {
    scenario = hil::load_scenario_text(kScenario + more, "outputs.yaml");
    simulation = hil::build_simulation(scenario);
  }
  static std::vector<double> get(const hil::OutputReader& reader, const std::string& name,
                                 const std::vector<double>& values) {
    for (const Output& output : reader.list())
      if (output.name == name)
        return {values.begin() + static_cast<std::ptrdiff_t>(output.first),
                values.begin() + static_cast<std::ptrdiff_t>(output.first + output.columns.size())};
    ADD_FAILURE() << "no output " << name;
    return {};
  }
  std::vector<double> read(const std::string& name) {
    hil::OutputReader reader(scenario, *simulation);
    std::vector<double> values(reader.count_values());
    reader.read(values);
    return get(reader, name, values);
  }
  void step(int count) {
    for (int i = 0; i < count; ++i) ASSERT_EQ(simulation->step().status, StepStatus::kOk);
  }

  hil::Scenario scenario;
  std::unique_ptr<hil::Simulation> simulation;
};

TEST_F(OutputsTest, EveryColumnHasANameOfItsOwnAndAPlaceOfItsOwn) {
  load();
  std::set<std::string> columns, names;
  std::size_t next = 0;
  for (const Output& output : hil::list_outputs(scenario)) {
    EXPECT_TRUE(names.insert(output.name).second) << output.name;
    EXPECT_EQ(output.first, next);
    next += output.columns.size();
    for (const Output::Column& column : output.columns) {
      EXPECT_TRUE(columns.insert(column.name).second) << column.name;
      EXPECT_FALSE(column.unit.empty()) << column.name;
    }
  }
  EXPECT_EQ(next, hil::count_values(hil::list_outputs(scenario)));
}

TEST_F(OutputsTest, ABodyAndAJointOfOneNameHaveColumnsThatDiffer) {
  std::string text = kScenario;
  for (std::size_t at; (at = text.find("hinge:")) != std::string::npos;) text.replace(at, 6, "arm:");
  scenario = hil::load_scenario_text(text, "outputs.yaml");
  std::set<std::string> columns;
  for (const Output& output : hil::list_outputs(scenario))
    for (const Output::Column& column : output.columns) EXPECT_TRUE(columns.insert(column.name).second) << column.name;
  EXPECT_EQ(columns.count("joint.arm.x"), 1u);
}

// Central differences over 2 dt: their error is that of the third derivative, here below 1e-3 of the size of the
// values.
TEST_F(OutputsTest, AccelerationsAndRatesAreThoseOfTheMotion) {
  constexpr double kDifference = 1e-3;
  load();
  step(200);
  const std::vector<double> v = read("body.ball.velocity"), w = read("body.ball.rate"),
                            angle = read("joint.hinge.angle"), length = read("element.spring.length");
  step(1);
  const std::vector<double> a = read("body.ball.acceleration"), alpha = read("body.ball.angular_acceleration"),
                            angle_rate = read("joint.hinge.angle_rate"), rate = read("element.spring.rate");
  step(1);
  const std::vector<double> v2 = read("body.ball.velocity"), w2 = read("body.ball.rate"),
                            angle2 = read("joint.hinge.angle"), length2 = read("element.spring.length");
  double spin = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(a[k], (v2[k] - v[k]) / 0.002, kDifference * 10);
    EXPECT_NEAR(alpha[k], (w2[k] - w[k]) / 0.002, kDifference);
    EXPECT_NEAR(angle_rate[k], (angle2[k] - angle[k]) / 0.002, kDifference);
    spin += std::abs(alpha[k]);
  }
  EXPECT_NEAR(rate[0], (length2[0] - length[0]) / 0.002, kDifference);
  EXPECT_GT(spin, 1e-4);  // the check above could fail
}

TEST_F(OutputsTest, ForcesOfElementsAreThoseThatMoveTheBodies) {
  constexpr double kRounding = 1e-9;
  load();
  step(100);
  EXPECT_NEAR(read("element.jet.force")[0], 6, kRounding);  // 3 N along a direction of length 2
  const double force = read("element.spring.force")[0], length = read("element.spring.length")[0],
               rate = read("element.spring.rate")[0], stroke = read("element.spring.stroke")[0];
  EXPECT_NEAR(stroke, 0.8 - length, kRounding);
  EXPECT_NEAR(force, 20 * stroke - 0.5 * rate, kRounding);
  // The ball's acceleration: weight, spring along the line, jet along the ball's z-axis.
  const BodyState &arm = simulation->state().bodies[0], &ball = simulation->state().bodies[1];
  const Vec3 line = ball.p - (arm.p + rotation_matrix(arm.q) * Vec3{0.5, 0, 0});
  const Vec3 total = (force / norm(line)) * line + rotation_matrix(ball.q) * Vec3{0, 0, 6} + Vec3{0, 0, -9.81};
  const std::vector<double> a = read("body.ball.acceleration");
  EXPECT_NEAR(a[0], total.x, kRounding);
  EXPECT_NEAR(a[1], total.y, kRounding);
  EXPECT_NEAR(a[2], total.z, kRounding);
  EXPECT_NEAR(read("clearance.arm.ball")[0], norm(ball.p - arm.p) - 0.2, kRounding);
  EXPECT_THAT(read("sensor.gyro"), ElementsAre(ball.w.x, ball.w.y, ball.w.z));
}

TEST_F(OutputsTest, PushersGiveTheirForceAndWhatIsLeftOfTheirStroke) {
  constexpr double kRounding = 1e-9;
  scenario = hil::load_scenario_text(R"(unlatch: 1
name: pushed
step: {dt: 0.001, until: 1}
bodies:
  lower: {mass: 3, inertia: [1, 1, 1]}
  upper: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  rail: {between: [lower, upper], point: [1, 0, 0], modes: {slides: {kind: prismatic, axis: x}}, mode: slides}
elements:
  pusher: {type: pusher, joint: rail, axis: x, stroke: 5 cm, preload: 100 N, stiffness: 1 kN/m}
  rub: {type: joint_friction, joint: rail, axis: x, coefficient: 0.5}
  cord: {type: cord, between: [lower, upper], length: 1.2, stiffness: 5 kN/m}
)",
                                     "pushed.yaml");
  simulation = hil::build_simulation(scenario);
  step(20);
  const double x = read("joint.rail.displacement")[0], speed = read("joint.rail.speed")[0];
  EXPECT_NEAR(read("element.pusher.force")[0], 100 - 1000 * x, kRounding);
  EXPECT_NEAR(read("element.pusher.stroke")[0], 0.05 - x, kRounding);
  EXPECT_NEAR(read("element.pusher.displacement")[0], x, kRounding);
  EXPECT_NEAR(read("element.pusher.rate")[0], speed, kRounding);
  EXPECT_EQ(read("element.rub.force")[0], 0);  // the rail bears no load
  EXPECT_NEAR(read("element.rub.displacement")[0], x, kRounding);
  EXPECT_NEAR(read("element.cord.stroke")[0], x - 0.2, kRounding);  // slack
  EXPECT_EQ(read("element.cord.force")[0], 0);
  for (int tick = 0; tick < 200 && read("joint.rail.displacement")[0] <= 0.2; ++tick) step(1);
  const double longer = read("joint.rail.displacement")[0] - 0.2;
  ASSERT_GT(longer, 0);
  EXPECT_NEAR(read("element.cord.force")[0], -5000 * longer, 1e-6);
  EXPECT_EQ(read("element.pusher.force")[0], 0);
}

// 2 kg at 3 m/s on 0.2 MN/m: the depth is 3/w sin(w t) after the touch at 0.1 s, w = 316 rad/s.
TEST_F(OutputsTest, ContactsHaveTheirForceDepthAndTotals) {
  scenario = hil::load_scenario_text(R"(unlatch: 1
name: blow
step: {dt: 1 ms, until: 0.2, contact_substeps: 8}
bodies:
  wall: {mass: 1e9, inertia: [1e9, 1e9, 1e9], shape: [{box: {size: [2, 10, 10]}}]}
  ball: {mass: 2, inertia: [1, 1, 1], position: [1.8, 0, 0], velocity: [-3, 0, 0], shape: [{sphere: {radius: 0.5}}]}
contacts:
  blow: {between: [wall, ball], stiffness: 0.2 MN/m}
)",
                                     "blow.yaml");
  simulation = hil::build_simulation(scenario);
  step(50);
  for (const char* what : {"force", "friction", "depth", "slip_speed", "impulse", "slip", "dissipated"})
    EXPECT_EQ(read("element.blow." + std::string(what))[0], 0) << what;
  EXPECT_EQ(read("element.blow.scale")[0], 1);
  step(53);  // 3 ms after the touch
  const double omega = std::sqrt(2e5 / 2), depth = 3 / omega * std::sin(omega * 0.003);
  EXPECT_NEAR(read("element.blow.depth")[0], depth, 1e-7);
  EXPECT_NEAR(read("element.blow.force")[0], 2e5 * depth, 2e5 * 1e-7);
  EXPECT_NEAR(read("element.blow.impulse")[0], 6 * (1 - std::cos(omega * 0.003)), 1e-5);
  EXPECT_NEAR(read("element.blow.slip_speed")[0], 0, 1e-9);
}

// One reading of a contact serves its outputs, whatever their order; each contact has its own.
TEST_F(OutputsTest, ContactsThatAreReadInAnyOrderGiveTheSame) {
  scenario = hil::load_scenario_text(R"(unlatch: 1
name: blows
step: {dt: 1 ms, until: 0.2, contact_substeps: 8}
bodies:
  wall: {mass: 1e9, inertia: [1e9, 1e9, 1e9], shape: [{box: {size: [2, 10, 10]}}]}
  a: {mass: 2, inertia: [1, 1, 1], position: [1.8, 0, 0], velocity: [-3, 0.5, 0], shape: [{sphere: {radius: 0.5}}]}
  b: {mass: 1, inertia: [1, 1, 1], position: [1.8, 3, 0], velocity: [-3, 0, 0.25], shape: [{sphere: {radius: 0.5}}]}
contacts:
  first: {between: [wall, a], stiffness: 0.2 MN/m, friction: 0.3}
  second: {between: [wall, b], stiffness: 0.1 MN/m, friction: 0.1}
)",
                                     "blows.yaml");
  simulation = hil::build_simulation(scenario);
  step(103);
  hil::OutputReader reader(scenario, *simulation);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < reader.list().size(); ++i) order.push_back((i * 7) % reader.list().size());
  ASSERT_EQ(std::set<std::size_t>(order.begin(), order.end()).size(), order.size());
  std::vector<double> mixed(reader.count_values()), one(reader.count_values());
  reader.read(order, mixed);
  int contacts = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    reader.read(std::span(&order[i], 1), one);
    contacts += reader.list()[order[i]].name.starts_with("element.");
  }
  EXPECT_EQ(mixed, one);
  EXPECT_EQ(contacts, 2 * 8);
  EXPECT_NE(get(reader, "element.first.force", mixed), get(reader, "element.second.force", mixed));
  EXPECT_GT(get(reader, "element.second.friction", mixed)[0], 0);
}

TEST_F(OutputsTest, GroupsHaveRatesOfTheirOwn) {
  load(
      "outputs:\n  - {select: [ball.velocity, \"*.force\"], every: 100}\n  - {select: [spring.length], rate: 200 "
      "Hz}\n");
  hil::RunOutputs outputs(scenario, *simulation, {7}, scenario.outputs);
  outputs.look();
  for (int i = 0; i < 250; ++i) {
    step(1);
    outputs.look();
  }
  outputs.finish();
  ASSERT_EQ(outputs.get_series().size(), 2u);
  const auto &slow = outputs.get_series()[0], &fast = outputs.get_series()[1];
  EXPECT_EQ(slow.times.size(), 4u);  // 0, 100, 200 and the last
  EXPECT_EQ(fast.times.size(), 51u);
  EXPECT_EQ(slow.selected.outputs.size(), 4u);  // velocity; forces of the hinge, the spring, the jet
  EXPECT_EQ(slow.values.size(), 4u * (3 + 3 + 1 + 1));
  ASSERT_EQ(outputs.get_samples().size(), 1u);
  EXPECT_DOUBLE_EQ(outputs.get_samples()[0].time, 0.007);
}

TEST_F(OutputsTest, AMistypedNameIsRefusedWithAGuess) {
  try {
    load("outputs: [{select: [ball.velocty]}]\n");
    FAIL();
  } catch (const hil::ScenarioError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'ball.velocty' is no output"));
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'ball.velocity'?"));
  }
  try {
    load("outputs: [{select: [ball.vx]}]\n");
    FAIL();
  } catch (const hil::ScenarioError& error) {
    EXPECT_THAT(error.what(), HasSubstr("that is a column of 'body.ball.velocity'"));
  }
}

TEST_F(OutputsTest, ARateThatDoesNotDivideTheStepsIsRefused) {
  EXPECT_THROW(load("outputs: [{select: [\"*\"], rate: 300 Hz}]\n"), hil::ScenarioError);
  EXPECT_THROW(load("outputs: [{select: [\"*\"], rate: 100 Hz, every: 10}]\n"), hil::ScenarioError);
  EXPECT_NO_THROW(load("outputs: [{select: [\"*\"], rate: 250 Hz}]\n"));
}

TEST_F(OutputsTest, APatternThatSelectsNothingIsARemark) {
  load("outputs: [{select: [\"ball.*\", \"nozzle*.force\"]}]\n");
  ASSERT_EQ(scenario.remarks.size(), 1u);
  EXPECT_EQ(scenario.remarks[0].kind, "outputs");
  EXPECT_THAT(scenario.remarks[0].text, HasSubstr("'nozzle*.force' selects nothing"));
}

TEST_F(OutputsTest, TheCommandLineSelectsAsTheScenarioDoes) {
  load();
  const std::vector<Output> list = hil::list_outputs(scenario);
  const auto groups = hil::parse_outputs("ball.*,*.force@10,gyro@100Hz", 0.001, list);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].rate.every, 1);
  EXPECT_THAT(groups[0].patterns, ElementsAre("ball.*"));
  EXPECT_EQ(groups[1].rate.every, 10);
  EXPECT_THAT(groups[1].patterns, ElementsAre("*.force", "gyro"));
  for (const char* wrong : {"bal.velocity", "ball.*@0", "ball.*@x", "ball.*@300Hz", ""})
    EXPECT_THROW((void)hil::parse_outputs(wrong, 0.001, list), std::invalid_argument) << wrong;
}

}  // namespace
}  // namespace unlatch::test::outputs_test
