// Shapes in scenarios, and the pairs of bodies, groups and shapes whose clearance is watched.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::scenario_shapes_test {
namespace {

using geometry::Shape;
using geometry::ShapeKind;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::StartsWith;

const std::string kCoreShape = "shape: [{sphere: {radius: 1}}]";
const std::string kBoosterShape = "shape: [{capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 0}}]";

// The core has a tank, and a skirt of two parts; the booster a nose and a nozzle.
std::string scenario_with_parts(const std::string& clearance) {
  std::string text =
      replaced(kGoodScenario, kCoreShape,
               "shape: [{name: tank, sphere: {radius: 1}}, "
               "{name: front, group: skirt, hollow_cylinder: {from: [-2, 0, 0], to: [-1, 0, 0], radius: 1}}, "
               "{name: rear, group: skirt, hollow_cylinder: {from: [-3, 0, 0], to: [-2, 0, 0], radius: 1}}]");
  text = replaced(text, kBoosterShape,
                  "shape: [{name: nose, sphere: {radius: 0.1}}, "
                  "{name: nozzle, frustum: {from: [-2, 0, 0], to: [-1, 0, 0], radius: 1, end_radius: 0.5}}]");
  return replaced(text, "clearance: all", clearance);
}

hil::Scenario load(const std::string& text) { return hil::load_scenario_text(text, "s.yaml"); }

Shape load_shape(const std::string& text) {
  return load(replaced(kGoodScenario, kCoreShape, "shape: [{" + text + "}]")).shapes[0].at(0).shape;
}

TEST(ScenarioShapes, OfEveryKindAreRead) {
  const Shape sphere = load_shape("sphere: {centre: [1, 2, 3], radius: 50 cm}");
  EXPECT_EQ(sphere.kind, ShapeKind::kSphere);
  EXPECT_EQ(sphere.from.z, 3);
  EXPECT_EQ(sphere.radius, 0.5);
  EXPECT_EQ(load_shape("capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 0}").kind, ShapeKind::kCapsule);
  EXPECT_EQ(load_shape("cylinder: {from: [0, 0, 0], to: [1, 0, 0], radius: 1}").to.x, 1);
  EXPECT_EQ(load_shape("cone: {from: [0, 0, 0], to: [1, 0, 0], radius: 1}").kind, ShapeKind::kCone);
  const Shape frustum = load_shape("frustum: {from: [0, 0, 0], to: [1, 0, 0], radius: 0, end_radius: 2}");
  EXPECT_EQ(frustum.kind, ShapeKind::kFrustum);
  EXPECT_EQ(frustum.end_radius, 2);
  const Shape box = load_shape("box: {size: [1, 2, 3], attitude: [0, 0, 0, 1]}");
  EXPECT_EQ(box.size.y, 2);
  EXPECT_EQ(box.q_BS.z, 1);
  EXPECT_EQ(load_shape("hull: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}").points.size(), 4U);
  const Shape ground = load_shape("half_space: {point: [0, 0, 4], normal: [0, 0, 2]}");
  EXPECT_EQ(ground.kind, ShapeKind::kHalfSpace);
  EXPECT_EQ(ground.from.z, 4);
  EXPECT_EQ(ground.normal.z, 2);
}

TEST(ScenarioShapes, WallsHaveTheirProfileAndTheirHalf) {
  const Shape tube = load_shape("hollow_cylinder: {from: [1, 0, 0], to: [4, 0, 0], radius: 2}");
  EXPECT_EQ(tube.kind, ShapeKind::kHollow);
  EXPECT_FALSE(tube.half);
  EXPECT_EQ(tube.profile.at(1).z, 3);
  EXPECT_EQ(tube.profile.at(1).r, 2);
  const Shape funnel =
      load_shape("hollow_frustum: {from: [1, 0, 0], to: [4, 0, 0], radius: 2, end_radius: 1, half: [0, 1, 0]}");
  EXPECT_TRUE(funnel.half);
  EXPECT_EQ(funnel.side.y, 1);
  EXPECT_EQ(funnel.profile.at(1).r, 1);
  const Shape fairing =
      load_shape("hollow_profile: {from: [1, 0, 0], axis: [0, 0, 5], profile: [[0, 1], [2, 1], [3 m, 20 cm]]}");
  EXPECT_EQ(fairing.profile.at(2).r, 0.2);
  EXPECT_EQ(fairing.to.x, 1);
  EXPECT_GT(fairing.to.z, 0);
}

// One wrong shape each, on line 8, where the shapes begin at column 12.
struct WrongShape {
  const char* name;
  const char* shape;
  int column;
  const char* says;
};
void PrintTo(const WrongShape& wrong, std::ostream* stream) { *stream << wrong.shape; }
class ShapeMistakes : public ::testing::TestWithParam<WrongShape> {};

TEST_P(ShapeMistakes, AreNamedWithTheirPlace) {
  const std::string errors = errors_with(kCoreShape, std::string("shape: [{") + GetParam().shape + "}]");
  EXPECT_THAT(errors,
              AllOf(StartsWith("s.yaml:8:" + std::to_string(GetParam().column) + ": "), HasSubstr(GetParam().says)));
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 0) << errors;
}

INSTANTIATE_TEST_SUITE_P(
    ScenarioShapes, ShapeMistakes,
    ::testing::Values(
        WrongShape{"NoKind", "name: tank", 13, "a shape needs a kind"},
        WrongShape{"TwoKinds", "sphere: {radius: 1}, box: {size: [1, 1, 1]}", 13, "has both"},
        WrongShape{"NoVolume", "sphere: {radius: 0}", 31, "radius is 0; greater than 0 m"},
        WrongShape{"NoAxis", "cylinder: {from: [1, 0, 0], to: [1, 0, 0], radius: 1}", 46, "length 0"},
        WrongShape{"FlatBox", "box: {size: [1, 0, 1]}", 26, "a box of 1 × 0 × 1 m"},
        WrongShape{"FlatFrustum", "frustum: {from: [0, 0, 0], to: [1, 0, 0], radius: 0, end_radius: 0}", 64,
                   "without volume"},
        WrongShape{"FlatHull", "hull: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}", 29, "lie in a plane"},
        WrongShape{"SmallHull", "hull: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}", 29,
                   "a hull of 3 points; 4 to 256 points"},
        WrongShape{"HullOfNumbers", "hull: {points: 4}", 29, "points is not a list"},
        WrongShape{"NoNormal", "half_space: {normal: [0, 0, 0]}", 35, "not a direction"},
        WrongShape{"FlatWall", "hollow_cylinder: {from: [0, 0, 0], to: [1, 0, 0], radius: 0}", 72, "greater than 0"},
        WrongShape{"ShortProfile", "hollow_profile: {from: [0, 0, 0], axis: [1, 0, 0], profile: [[0, 1]]}", 74,
                   "a profile of 1 point;"},
        WrongShape{"FoldedProfile", "hollow_profile: {from: [0, 0, 0], axis: [1, 0, 0], profile: [[0, 1], [0, 2]]}", 74,
                   "not beyond the one before it"},
        WrongShape{"ProfileOfNumbers", "hollow_profile: {from: [0, 0, 0], axis: [1, 0, 0], profile: 1}", 74,
                   "profile is not a list"},
        WrongShape{"NoProfileAxis", "hollow_profile: {from: [0, 0, 0], axis: [0, 0, 0], profile: [[0, 1], [1, 1]]}", 54,
                   "length 0"},
        WrongShape{"HalfAlongTheAxis", "hollow_cylinder: {from: [0, 0, 0], to: [1, 0, 0], radius: 1, half: [1, 0, 0]}",
                   81, "side lies along the axis"},
        WrongShape{"NameTwice", "name: a, sphere: {radius: 1}}, {name: a, sphere: {radius: 1}", 52,
                   "another shape or group"},
        WrongShape{"NameOfAGroup", "name: a, sphere: {radius: 1}}, {group: a, sphere: {radius: 1}", 20,
                   "another shape or group"},
        WrongShape{"NoName", "name: a.b, sphere: {radius: 1}", 20, "is not a name"}),
    [](const auto& at) { return std::string(at.param.name); });

TEST(ScenarioShapes, OfAnUnknownKindAreAnsweredByTheNearestOne) {
  EXPECT_THAT(errors_with(kCoreShape, "shape: [{frustrum: {radius: 1}}]"), HasSubstr("did you mean 'frustum'?"));
}

TEST(ScenarioShapes, ANameOrAGroupStandsForThemInPairs) {
  const hil::Scenario s = load(scenario_with_parts("clearance: [[core, booster], [core.skirt, booster.nozzle]]"));
  ASSERT_EQ(s.clearance.size(), 2U);
  EXPECT_THAT(s.clearance[0].a.shapes, ElementsAre(0, 1, 2));
  EXPECT_EQ(s.clearance[1].a.name, "core.skirt");
  EXPECT_THAT(s.clearance[1].a.shapes, ElementsAre(1, 2));
  EXPECT_EQ(s.clearance[1].a.body, 0);
  EXPECT_THAT(s.clearance[1].b.shapes, ElementsAre(1));
  EXPECT_THAT(s.clearance[1].except, IsEmpty());
}

TEST(ScenarioShapes, MatedFacesAreLeftOutByName) {
  const hil::Scenario s = load(scenario_with_parts(
      "clearance: [{between: all, except: [[booster.nose, core.tank], [core.skirt, booster.nose]]}]"));
  ASSERT_EQ(s.clearance.size(), 1U);
  EXPECT_EQ(s.clearance[0].a.name, "core");
  EXPECT_THAT(s.clearance[0].except, ElementsAre(Pair(0, 0), Pair(1, 0), Pair(2, 0)));
}

TEST(ScenarioShapes, ARequirementWatchesItsPairWithItsExceptions) {
  const std::string requirement = "\nrequirements: [{id: R1, clearance: [booster, core], at_least: 1 cm}]";
  const hil::Scenario s = load(scenario_with_parts(
      "clearance: [{between: [core, booster], except: [[core.tank, booster.nose]]}]" + requirement));
  ASSERT_EQ(s.clearance.size(), 1U);
  EXPECT_EQ(s.requirements.at(0).pair, 0);
  const hil::Scenario alone = load(scenario_with_parts("clearance: []" + requirement));
  ASSERT_EQ(alone.clearance.size(), 1U);
  EXPECT_THAT(alone.clearance[0].except, IsEmpty());
}

// One wrong section `clearance` each, on line 38.
struct WrongPair {
  const char* name;
  const char* clearance;
  const char* place;
  const char* says;
};
void PrintTo(const WrongPair& wrong, std::ostream* stream) { *stream << wrong.clearance; }
class PairMistakes : public ::testing::TestWithParam<WrongPair> {};

TEST_P(PairMistakes, AreNamedWithTheirPlace) {
  const std::string errors = load_errors(scenario_with_parts(std::string("clearance: ") + GetParam().clearance));
  EXPECT_THAT(errors, AllOf(StartsWith(std::string("s.yaml:38:") + GetParam().place), HasSubstr(GetParam().says)));
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 0) << errors;
}

INSTANTIATE_TEST_SUITE_P(
    ScenarioShapes, PairMistakes,
    ::testing::Values(WrongPair{"UnknownBody", "[[core, boster]]", "20: ", "did you mean 'booster'?"},
                      WrongPair{"UnknownShape", "[[core.tnk, booster]]",
                                "14: ", "unknown shape 'tnk' of body 'core'; did you mean 'tank'?"},
                      WrongPair{"NoShape", "[[core., booster]]", "14: ", "unknown shape '' of body 'core'"},
                      WrongPair{"Itself", "[[core.tank, core.skirt]]", "13: ", "a body and itself"},
                      WrongPair{"Three", "[[core, booster, core]]", "13: ", "not a pair of bodies"},
                      WrongPair{"AllInAList", "[all]", "13: ", "clearance: all"},
                      WrongPair{"NoBetween", "[{except: []}]", "13: ", "has no between"},
                      WrongPair{"ExceptionElsewhere",
                                "[{between: [core.skirt, booster], except: [[core.tank, booster]]}]",
                                "55: ", "no watched pair has these shapes"},
                      WrongPair{"NothingLeft", "[{between: [core.tank, booster.nose], except: [[core, booster]]}]",
                                "58: ", "nothing is left"},
                      WrongPair{"TwiceAndDifferent",
                                "[[core, booster], {between: [core, booster], except: [[core.tank, booster.nose]]}]",
                                "30: ", "watched twice"}),
    [](const auto& at) { return std::string(at.param.name); });

TEST(ScenarioShapes, TwoHollowShapesThatAreLeftOutAreNotReportedAgain) {
  const std::string tube = "{name: skirt, hollow_cylinder: {from: [0, 0, 0], to: [1, 0, 0], radius: 1}}";
  const std::string text = replaced(replaced(kGoodScenario, kCoreShape, "shape: [{sphere: {radius: 1}}, " + tube + "]"),
                                    kBoosterShape, "shape: [" + tube + "]");
  EXPECT_EQ(load(text).remarks.size(), 1U);
  const std::string except = "clearance: [{between: [core, booster], except: [[core.skirt, booster.skirt]]}]";
  EXPECT_THAT(load(replaced(text, "clearance: all", except)).remarks, IsEmpty());
}

TEST(ScenarioShapes, APairWithoutADistanceIsAMistakeAndUnderAllARemark) {
  const std::string tube = "hollow_cylinder: {from: [0, 0, 0], to: [1, 0, 0], radius: 1}";
  const std::string text = replaced(replaced(kGoodScenario, kCoreShape, "shape: [{" + tube + "}]"), kBoosterShape,
                                    "shape: [{" + tube + "}]");
  EXPECT_THAT(load_errors(replaced(text, "clearance: all", "clearance: [[core, booster]]")),
              AllOf(StartsWith("s.yaml:38:13: "), HasSubstr("no distance is defined between core and booster")));
  const hil::Scenario all = load(text);
  EXPECT_THAT(all.clearance, IsEmpty());
  ASSERT_EQ(all.remarks.size(), 1U);
  EXPECT_THAT(all.remarks[0].text, HasSubstr("1 of 1 pair of shapes does not count"));
  const hil::Scenario some =
      load(replaced(text, "shape: [{" + tube + "}]", "shape: [{sphere: {radius: 1}}, {" + tube + "}]"));
  EXPECT_EQ(some.clearance.size(), 1U);
  EXPECT_THAT(some.remarks.at(0).text, HasSubstr("1 of 2 pairs"));
  EXPECT_THAT(some.remarks.at(0).text, HasSubstr("make one of the hollow ones solid"));
}

}  // namespace
}  // namespace unlatch::test::scenario_shapes_test
