// Scenario files: valid ones are read, mistakes are reported with place and correction.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/hil/scenario/scenario_support.h"
#include "unlatch/plan.h"

namespace unlatch::test::scenario_test {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(Scenario, ReadsEverySection) {
  const hil::Scenario s = hil::load_scenario_text(kGoodScenario, "s.yaml");
  EXPECT_EQ(s.name, "pair");
  EXPECT_EQ(s.dt, 0.001);
  ASSERT_EQ(s.model.bodies.size(), 2u);
  EXPECT_EQ(s.model.bodies[1].mass, 4500);
  EXPECT_EQ(s.model.joints.at(0).modes.at(0).rows, 0b101111);
  EXPECT_EQ(s.model.loads.at(0).profile.value, 5000);
  EXPECT_EQ(s.model.loads.at(0).channel, 0);
  EXPECT_EQ(s.model.point_springs.at(0).base, 0);
  EXPECT_EQ(s.model.signals, std::vector<std::string>{"kr"});
  EXPECT_EQ(s.model.events.at(0).when.threshold, -0.005);
  EXPECT_TRUE(s.model.events.at(0).when.below);
  EXPECT_EQ(s.model.events.at(0).delay, 0.012);
  EXPECT_EQ(s.model.events.at(0).then.at(1).mode, 1);
  ASSERT_EQ(s.clearance.size(), 1u);
  EXPECT_EQ(s.clearance[0].a.name, "core");
  EXPECT_EQ(s.clearance[0].b.name, "booster");
  ASSERT_EQ(s.points.size(), 2u);
  EXPECT_EQ(s.points[0].body, 1);
  EXPECT_EQ(s.points[0].p_BP, Eigen::Vector3d(-1, 0, 0.05));
  EXPECT_EQ(s.points[0].seen_from, 0);
  EXPECT_EQ(s.points[1].seen_from, kGround);
  EXPECT_EQ(s.flight_software.policy, hil::Policy::kSafe);
  EXPECT_EQ(s.marks.at("joint 'nose'").line, 18);
}

TEST(Scenario, PlacesBodiesRelativeToMovingBodies) {
  std::string text = replaced(kGoodScenario, "inertia: [10, 20, 25]",
                              "inertia: [10, 20, 25]\n    attitude: {rotate: [[z, 90 deg]]}\n    rate: [0, 0, 2]\n"
                              "    velocity: [1, 0, 0]");
  const hil::Scenario s = hil::load_scenario_text(text, "s.yaml");
  const Body& b = s.model.bodies[1];
  constexpr double kRounding = 1e-14;
  EXPECT_LT((b.p_WB - Eigen::Vector3d(0, 3, 0)).norm(), kRounding);
  EXPECT_LT((b.v_WB - Eigen::Vector3d(1 - 6, 0, 0)).norm(), kRounding);
  EXPECT_LT((b.w_WB_B - Eigen::Vector3d(0, 0, 2)).norm(), kRounding);
}

TEST(Scenario, EveryShippedFileLoads) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(UNLATCH_SOURCE_DIR "/hil/scenarios")) {
    if (!is_scenario_file(entry.path())) continue;
    ++count;
    EXPECT_NO_THROW(hil::load_scenario(entry.path().string())) << entry.path();
  }
  EXPECT_GE(count, 21);
}

// One wrong piece each: place, fault, and correction.
struct Wrong {
  const char* name;
  const char* what;
  const char* with;
  const char* place;
  const char* says;
};
void PrintTo(const Wrong& wrong, std::ostream* stream) { *stream << wrong.with; }
class ScenarioMistakes : public ::testing::TestWithParam<Wrong> {};

TEST_P(ScenarioMistakes, AreNamedWithTheirPlace) {
  const std::string errors = errors_with(GetParam().what, GetParam().with);
  EXPECT_THAT(errors, AllOf(StartsWith(GetParam().place), HasSubstr(GetParam().says)));
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 0) << errors;
}

INSTANTIATE_TEST_SUITE_P(
    Scenario, ScenarioMistakes,
    ::testing::Values(
        Wrong{"UnknownKey", "mass: 100", "mas: 3\n    mass: 100", "s.yaml:6:5: ", "did you mean 'mass'?"},
        Wrong{"KeyOfYaml11", "channel: throttle}", "channel: throttle, on: false}",
              "s.yaml:27:94: ", "unknown key 'on' in element 'engine'; the key `on` is named `enabled` now"},
        Wrong{"KeyWrittenBackByYaml11", "channel: throttle}", "channel: throttle, true: false}",
              "s.yaml:27:94: ", "unknown key 'true' in element 'engine'; the key `on` is named `enabled` now"},
        Wrong{"NameOfYaml11", "name: pair", "name: yes", "s.yaml:2:7: ", "'yes' is not a name; YAML 1.1"},
        Wrong{"BodyOfYaml11", "channels:", "  No: {mass: 1, inertia: [1, 1, 1]}\nchannels:", "s.yaml:15:3: ",
              "'No' cannot be the name"},
        Wrong{"OctalOfYaml11", "mass: 100", "mass: 0100", "s.yaml:6:11: ", "leading zero"},
        Wrong{"SexagesimalOfYaml11", "mass: 100", "mass: 1:30", "s.yaml:6:11: ", "unexpected ':'"},
        Wrong{"DuplicateKey", "mass: 100", "mass: 100\n    mass: 100", "s.yaml:7:5: ", "first given on line 6"},
        Wrong{"DuplicateBody",
              "channels:", "  core: {mass: 1, inertia: [1, 1, 1]}\nchannels:", "s.yaml:15:3: ", "duplicate key 'core'"},
        Wrong{"MissingKey", "    mass: 100\n", "", "s.yaml:6:5: ", "body 'core' has no mass"},
        Wrong{"Type", "mass: 100", "mass: [100]", "s.yaml:6:11: ", "must be a number, in kg"},
        Wrong{"NoNumber", "mass: 100", "mass: heavy", "s.yaml:6:11: ", "'heavy' is not a number"},
        Wrong{"NaN", "mass: 100", "mass: .nan", "s.yaml:6:11: ", "not finite"},
        Wrong{"PlainNan", "mass: 100", "mass: nan", "s.yaml:6:11: ", "not finite"},
        Wrong{"Infinity", "mass: 100", "mass: -.inf", "s.yaml:6:11: ", "not finite"},
        Wrong{"Overflow", "mass: 100", "mass: 1e400", "s.yaml:6:11: ", "range of a double"},
        Wrong{"Underflow", "mass: 100", "mass: 1e-400", "s.yaml:6:11: ", "range of a double"},
        Wrong{"Unit", "4.5 t", "4.5 km", "s.yaml:10:11: ", "write a number in kg, or followed by g, t"},
        Wrong{"ListLength", "position: [3, 0, 0]", "position: [3, 0]", "s.yaml:13:15: ", "3 numbers"},
        Wrong{"UnknownBody", "[core, booster]\n", "[core, boster]\n", "s.yaml:19:21: ", "did you mean 'booster'?"},
        Wrong{"GroundFollows", "[core, booster]\n", "[core, ground]\n", "s.yaml:19:21: ", "swap them"},
        Wrong{"UnknownConditionKey", "axis: x}, below", "axis: x}, below: 1, abov",
              "s.yaml:35:60: ", "unknown key 'abov"},
        Wrong{"UnknownChannel", "channel: throttle", "channel: trottle", "s.yaml:27:84: ", "known: throttle"},
        Wrong{"NoDirection", "direction: [1, 0, 0]", "direction: [0, 0, 0]", "s.yaml:27:", "its direction is zero"},
        Wrong{"UnknownSignal", "signal: kr", "signal: kx", "s.yaml:31:31: ", "did you mean 'kr'?"},
        Wrong{"UnknownMode", "mode: free}}", "mode: fre}}", "s.yaml:37:56: ", "mode of joint 'nose' 'fre'"},
        Wrong{"UnknownType", "type: rate", "type: rte", "s.yaml:30:16: ", "did you mean 'rate'?"},
        Wrong{"UnknownRow", "rows: []", "rows: [x, w]", "s.yaml:24:24: ", "unknown row 'w'"},
        Wrong{"RowTwice", "rows: []", "rows: [x, x]", "s.yaml:24:24: ", "the row 'x' twice"},
        Wrong{"NoThreshold", ", below: -5 mm", "", "s.yaml:35:11: ", "a threshold"},
        Wrong{"TwoKinds", "{raise: kr}", "{raise: kr, ramp: {}}", "s.yaml:37:12: ", "both ramp and raise"},
        Wrong{"Policy", "policy: safe", "policy: stop", "s.yaml:39:58: ", "known: hold, zero, safe, pause, abort"},
        Wrong{"Header", "unlatch: 1\n", "", "s.yaml:1:1: ", "missing header; add `unlatch: 1`"},
        Wrong{"Version", "unlatch: 1", "unlatch: 2", "s.yaml:1:10: ", "`unlatch: 1`"},
        Wrong{"StepAlone", "step: {dt: 0.001, until: 1}", "step: 0.001", "s.yaml:3:7: ", "step"},
        Wrong{"StepList", "{dt: 0.001, until: 1}", "[0.001, 1]",
              "s.yaml:3:7: ", "a mapping (key: value) that describes step"},
        Wrong{"StepOfTwoClocks", "dt: 0.001", "dt: 1/3 ms", "s.yaml:3:12: ", "333333 and 333334 ns"},
        Wrong{"Step", "dt: 0.001", "dt: 0", "s.yaml:3:12: ", "whole nanoseconds"},
        Wrong{"Circle", "inertia: [10, 20, 25]", "inertia: [10, 20, 25]\n    relative_to: core",
              "s.yaml:8:18: ", "core -> core"},
        Wrong{"UnknownJoint", "{joint: nose, mode", "{joint: nos, mode", "s.yaml:37:44: ", "did you mean 'nose'?"},
        Wrong{"Skewed", "    modes:", "    axes: {x: [1, 0, 0], y: [0.1, 1, 0]}\n    modes:", "s.yaml:22:11: ",
              "not perpendicular"},
        Wrong{"NearlySkewed", "    modes:", "    axes: {x: [1, 0, 0], y: [3.0e-7, 1, 0]}\n    modes:", "s.yaml:22:11: ",
              "the cosine between them is 3e-07"},
        Wrong{"LeftHanded", "    modes:", "    axes: {x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, -1]}\n    modes:",
              "s.yaml:22:11: ", "left-handed"},
        Wrong{"Name", "name: pair", "name: a pair", "s.yaml:2:7: ", "is not a name"},
        Wrong{"ZeroMass", "mass: 100", "mass: 0", "s.yaml:6:11: ", "its mass is 0 kg; greater than 0"},
        Wrong{"Inertia", "[10, 20, 25]", "[10, 20, 35]", "s.yaml:7:14: ", "triangle inequality"},
        Wrong{"NotPositive", "[10, 20, 25]", "[-1, 20, 25]", "s.yaml:7:14: ", "not positive definite"},
        Wrong{"Gap", "point: [2, 0, 0]", "point: [1, 0, 0]",
              "s.yaml:20:12: ", "1 m along x; move body 'booster' by [-1"},
        Wrong{"PointOfItself", "seen_from: core", "seen_from: booster", "s.yaml:41:55: ", "does not move"},
        Wrong{"PointOfNobody", "fore: {body: core", "fore: {body: cor", "s.yaml:42:16: ", "did you mean 'core'?"},
        Wrong{"Channel", "initial: 1", "initial: 2", "s.yaml:16:23: ", "initial is 2; within its range [0, 1]"}),
    [](const auto& at) { return std::string(at.param.name); });

TEST(Scenario, ReportsAllMistakesAtOnceInTheirOrder) {
  std::string text = replaced(kGoodScenario, "mass: 100", "mass: 0");
  text = replaced(text, "type: rate", "type: rte");
  text = replaced(text, "step:", "stp: 3\nstep:");
  const std::string errors = load_errors(text);
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 2) << errors;
  EXPECT_LT(errors.find("'stp'"), errors.find("mass is 0"));
  EXPECT_LT(errors.find("mass is 0"), errors.find("'rte'"));
}

TEST(Scenario, TakesOnAndOffForTrueAndFalse) {
  const auto load = [](const std::string& value, const std::string& to) {
    std::string text = replaced(kGoodScenario, "channel: throttle}", "channel: throttle, enabled: " + value + "}");
    text = replaced(text, "{raise: kr}", "{raise: kr}, {switch: {element: engine, to: " + to + "}}");
    return hil::load_scenario_text(text, "s.yaml");
  };
  const hil::Scenario canonical = load("false", "true"), accepted = load("off", "on");
  for (const hil::Scenario* s : {&canonical, &accepted}) {
    EXPECT_FALSE(s->model.loads[0].on);
    EXPECT_EQ(s->model.events[0].then[1].value, 1.0);
  }
  EXPECT_EQ(load("true", "off").model.events[0].then[1].value, 0.0);
}

TEST(Scenario, DoesNotReportConsequencesOfAMistake) {
  const std::string errors = errors_with("position: [3, 0, 0]", "position: [3, 0, nought]");  // the joint's gap is one
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 0) << errors;
}

TEST(Scenario, FilesThatCannotBeReadAreMistakes) {
  const auto error_of = [](const std::string& path) -> std::string {
    try {
      hil::load_scenario(path);
      return "";
    } catch (const hil::ScenarioError& e) {
      return e.what();
    }
  };
  EXPECT_THAT(error_of(UNLATCH_SOURCE_DIR "/hil"), HasSubstr("this is a folder"));
  EXPECT_THAT(error_of("/nowhere/s.yaml"), HasSubstr("no such file"));
  EXPECT_THAT(error_of("/dev/zero"), HasSubstr("not a regular file"));
}

// --- Overrides ------------------------------------------------------------------------------------------------------

hil::Scenario load_with(const std::vector<std::string>& overrides) {
  return hil::load_scenario_text(kGoodScenario, "s.yaml", overrides);
}

TEST(ScenarioOverrides, ReachScalarsThatAreThere) {
  const hil::Scenario s = load_with({"bodies.core.mass=98", "step.dt=2 ms", "elements.engine.direction[1]=0.5",
                                     "events[0].delay=0.25", "elements.spring.stiffness=11"});
  EXPECT_EQ(s.model.bodies[0].mass, 98);
  EXPECT_EQ(s.dt, 0.002);
  EXPECT_EQ(s.model.loads[0].direction, Eigen::Vector3d(1, 0.5, 0));
  EXPECT_EQ(s.model.events[0].delay, 0.25);
  EXPECT_EQ(s.model.point_springs[0].stiffness, 11);
  EXPECT_EQ(s.overrides.size(), 5u);
}

TEST(ScenarioOverrides, ReachScalarsThatTheFileLeavesOut) {
  const hil::Scenario s = load_with({"elements.engine.enabled=false", "gravity.uniform[2]=-9.81",
                                     "elements.engine.point.1=2", "elements.engine.scale=0.5"});
  EXPECT_FALSE(s.model.loads[0].on);
  EXPECT_EQ(s.model.gravity.uniform, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(s.model.loads[0].point, Eigen::Vector3d(0, 2, 0));
  EXPECT_EQ(s.model.loads[0].direction, Eigen::Vector3d(0.5, 0, 0));
}

TEST(ScenarioOverrides, BringInWhatIsNumberedOrGivenWhole) {
  const hil::Scenario s = load_with(
      {"bodies.core2.mass=3", "bodies.core2.inertia=[1, 1, 1]", "bodies.boaster={mass: 4, inertia: [1, 1, 1]}"});
  EXPECT_EQ(s.model.bodies.size(), 4u);
}

TEST(ScenarioOverrides, AScaleOfZeroMakesALoadDead) {
  const hil::Scenario s = load_with({"elements.engine.scale=0"});
  EXPECT_EQ(s.model.loads[0].direction, Eigen::Vector3d(0, 0, 0));
  EXPECT_TRUE(compile_plan(s.model, {}).errors.empty());
}

TEST(ScenarioOverrides, ReachEventsByNameAndSubject) {
  EXPECT_EQ(load_with({"events.contact:booster.enabled=false"}).model.events.size(), 0u);
  EXPECT_EQ(load_with({"events.contact.delay=1"}).model.events[0].delay, 1);
}

// Among valid overrides, beside one whose own value is wrong, and beside a line that is wrong without any.
TEST(ScenarioOverrides, AreBlamedForLinesThatAreSoundWithoutThem) {
  const std::string with_constant = replaced(
      replaced(kGoodScenario, "name: pair", "name: pair\nconstants: {heavy: 100}"), "mass: 100", "mass: heavy");
  const std::vector<std::string> overrides{"step.until=2", "constants.heavy=-1", "bodies.booster.mass=0"};
  EXPECT_THAT(load_errors(with_constant, overrides),
              AllOf(StartsWith("s.yaml: --set constants.heavy=-1: body 'core'"), HasSubstr(" (at 7:11)"),
                    HasSubstr("\ns.yaml: --set bodies.booster.mass=0: "), Not(HasSubstr("step.until"))));
  EXPECT_THAT(load_errors(replaced(with_constant, "mode: hinge", "mode: hing"), overrides),
              AllOf(HasSubstr("--set constants.heavy=-1: "), ContainsRegex("s.yaml:[0-9]+:[0-9]+: ")));
}

TEST(ScenarioOverrides, MistakesNameTheOverride) {
  EXPECT_THAT(
      load_errors(kGoodScenario, {"bodies.core.mas=3"}),
      AllOf(StartsWith("s.yaml: --set bodies.core.mas=3: unknown key 'mas'"), HasSubstr("did you mean 'mass'")));
  EXPECT_THAT(load_errors(kGoodScenario, {"bodies.core.mass=0"}), StartsWith("s.yaml: --set bodies.core.mass=0: "));
  EXPECT_THAT(load_errors(kGoodScenario, {"bodies.boster.mass=3"}),
              AllOf(HasSubstr("there is no 'boster'"), HasSubstr("did you mean 'booster'?")));
  EXPECT_THAT(load_errors(kGoodScenario, {"events[7].delay=0"}), HasSubstr("no entry [7]: the list has 1"));
  EXPECT_THAT(load_errors(kGoodScenario, {"events.lift.delay=0"}), HasSubstr("no entry 'lift'"));
  EXPECT_THAT(load_errors(kGoodScenario, {"bodies.core.mass.x=0"}), HasSubstr("inside the single value"));
  for (const char* text :
       {"", "=", "=1", "a..b=1", "a[=1", "a[0]x=1", "a", "a=", "a={", "gravity.uniform[999999999]=1"})
    EXPECT_NE(load_errors(kGoodScenario, {text}), "") << text;
}

}  // namespace
}  // namespace unlatch::test::scenario_test
