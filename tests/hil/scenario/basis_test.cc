// The basis of a scenario's data: which values an entry covers, what is reported of wrong ones, uncertainties.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hil/scenario/language/record.h"
#include "hil/scenario/scenario.h"

namespace unlatch::test::basis_test {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kScenario = R"yaml(unlatch: 1
name: pair
step: {dt: 1 ms, until: 1}
constants: {gap: 0.1 m, twice: 2 * gap}
bodies:
  core: {mass: 2 t, inertia: [1000, 4000, 4000]}
  pod: {mass: 500 kg, inertia: [60, 80, 80], position: [1 m + gap, 0, 0]}
joints:
  clamp: {between: [core, pod], point: [1 m + gap, 0, 0], modes: {held: {kind: weld}, open: {kind: free}}, mode: held}
tables:
  push: {axes: {t: {at: [0, 1], unit: s}}, values: [5, 7], unit: N}
elements:
  engine: {type: force, body: core, direction: [1, 0, 0], profile: {expression: "push(time)"}}
templates:
  spring:
    parameters: {i}
    elements: {spring<i>: {type: spring, between: [core, pod], stiffness: 2 kN/m, free_length: twice}}
instances: [{template: spring, count: 2}]
sensors:
  gyro: {type: rate, body: pod, errors: {noise: 0.05 deg/s, delay: 2}}
events:
  - {name: release, subject: pod, when: {time: 0.5}, then: [{set_mode: {joint: clamp, mode: open}}]}
requirements:
  - {id: R1, text: It leaves, parent: SYS-4.2, rationale: "as long as the film", time: {event: release}, at_most: 1}
)yaml";

hil::Scenario load(const std::string& basis) { return hil::load_scenario_text(kScenario + basis, "pair.yaml"); }
hil::ScenarioRecord read(const std::string& basis) { return hil::load_record(load(basis)); }

std::string get_mistakes(const std::string& basis) {
  try {
    load(basis);
    return "";
  } catch (const hil::ScenarioError& error) {
    return error.what();
  }
}

const hil::DataValue& find(const hil::ScenarioRecord& record, const std::string& path) {
  for (const hil::DataValue& value : record.values)
    if (value.path == path) return value;
  throw std::out_of_range(path);
}

std::vector<std::string> list_covered(const hil::ScenarioRecord& record, int entry) {
  std::vector<std::string> paths;
  for (const hil::DataValue& value : record.values)
    if (value.basis == entry) paths.push_back(value.path);
  return paths;
}

TEST(Basis, DataAreTheNumbersExpressionsAndErrorsOfTheSystemAlone) {
  const hil::ScenarioRecord record = read("");
  std::vector<std::string> paths;
  for (const hil::DataValue& value : record.values) {
    paths.push_back(value.path);
    EXPECT_EQ(value.basis, -1);
  }
  EXPECT_THAT(paths,
              ElementsAre("constants.gap", "constants.twice", "bodies.core.mass", "bodies.core.inertia",
                          "bodies.pod.mass", "bodies.pod.inertia", "bodies.pod.position", "joints.clamp.point",
                          "tables.push.axes.t.at", "tables.push.values", "elements.engine.direction",
                          "elements.engine.profile.expression", "elements.spring1.stiffness",
                          "elements.spring1.free_length", "elements.spring2.stiffness", "elements.spring2.free_length",
                          "sensors.gyro.errors.noise", "sensors.gyro.errors.delay", "events.release.when.time"));
  EXPECT_EQ(find(record, "bodies.core.inertia").text, "[1000, 4000, 4000]");
  EXPECT_EQ(find(record, "bodies.core.inertia").unit, "kg m2");
  EXPECT_THAT(find(record, "bodies.core.mass").numbers, ElementsAre(2000));
}

TEST(Basis, WhatNamesConstantsFollowsFromThem) {
  const hil::ScenarioRecord record = read("");
  EXPECT_TRUE(find(record, "constants.twice").follows());
  EXPECT_THAT(find(record, "bodies.pod.position").constants, ElementsAre("gap"));
  EXPECT_TRUE(find(record, "elements.spring2.free_length").follows());
  EXPECT_FALSE(find(record, "constants.gap").follows());
  EXPECT_FALSE(find(record, "elements.engine.profile.expression").follows());
}

TEST(Basis, SeparatesInputsFromTheModel) {
  const hil::ScenarioRecord record = read("");
  EXPECT_EQ(find(record, "bodies.pod.position").role, hil::DataValue::Role::kInput);
  EXPECT_EQ(find(record, "events.release.when.time").role, hil::DataValue::Role::kInput);
  EXPECT_EQ(find(record, "bodies.pod.mass").role, hil::DataValue::Role::kModel);
}

TEST(Basis, APathCoversAllThatIsInItAndTheLastEntryCounts) {
  const hil::ScenarioRecord record = read(R"(basis:
  - {of: bodies, is: assumed}
  - {of: [bodies.*.mass, "elements.spring*.stiffness"], is: measured, uncertainty: 0.5 %, source: weighing}
  - {of: events.release, is: derived}
  - {of: "bodies.pod.inertia[0]", is: datasheet}
)");
  EXPECT_THAT(list_covered(record, 0), ElementsAre("bodies.core.inertia", "bodies.pod.position"));
  EXPECT_THAT(list_covered(record, 1), ElementsAre("bodies.core.mass", "bodies.pod.mass", "elements.spring1.stiffness",
                                                   "elements.spring2.stiffness"));
  EXPECT_THAT(list_covered(record, 2), ElementsAre("events.release.when.time"));
  EXPECT_THAT(list_covered(record, 3), ElementsAre("bodies.pod.inertia"));
  EXPECT_EQ(record.basis[1].source, "weighing");
  EXPECT_THAT(calc_uncertainties(find(record, "bodies.core.mass"), record.basis), ElementsAre(DoubleEq(10)));
  EXPECT_TRUE(calc_uncertainties(find(record, "bodies.core.inertia"), record.basis).empty());
}

TEST(Basis, AnUncertaintyWithAUnitIsASizeInThatOfTheValues) {
  const hil::ScenarioRecord record = read("basis: [{of: bodies.*.mass, is: measured, uncertainty: 3 kg}]\n");
  EXPECT_THAT(calc_uncertainties(find(record, "bodies.pod.mass"), record.basis), ElementsAre(3));
  EXPECT_THAT(
      get_mistakes("basis:\n  - {of: bodies.core, is: measured, uncertainty: 2 mm}\n"),
      HasSubstr(":26:5: an uncertainty of '2 mm' for bodies.core.mass, which is a mass (kg); a part of the value"));
  EXPECT_THAT(get_mistakes("basis: [{of: bodies.core, is: measured, uncertainty: -1 %}]\n"), HasSubstr("below 0"));
  EXPECT_THAT(get_mistakes("basis: [{of: bodies.core, is: measured, uncertainty: some}]\n"), HasSubstr("'some'"));
}

TEST(Basis, AWrongPathHasItsPlaceAndASuggestion) {
  EXPECT_THAT(get_mistakes("basis:\n  - {of: bodies.cor.mass, is: measured}\n"),
              HasSubstr("pair.yaml:26:10: nothing is at 'bodies.cor.mass'; did you mean 'core'?"));
  EXPECT_THAT(get_mistakes("basis:\n  - {of: bodies.core.mas, is: measured}\n"), HasSubstr("did you mean 'mass'?"));
  EXPECT_THAT(get_mistakes("basis: [{of: bodies.core.mass.x, is: measured}]\n"),
              HasSubstr("nothing is inside of 'mass'"));
  EXPECT_THAT(get_mistakes("basis: [{of: step.dt, is: assumed}]\n"), HasSubstr("'step' is no section with data"));
  EXPECT_THAT(get_mistakes("basis: [{of: bodies.core.mass, is: guessed}]\n"), HasSubstr("unknown basis 'guessed'"));
  EXPECT_THAT(get_mistakes("basis: [{of: bodies..mass, is: assumed}]\n"), HasSubstr("an empty part"));
  EXPECT_THAT(get_mistakes("basis: {of: bodies, is: assumed}\n"), HasSubstr("basis is not a list"));
}

TEST(Basis, APatternThatCoversNothingIsARemark) {
  const hil::Scenario scenario = load("basis: [{of: bodies.fin*.mass, is: measured}]\n");
  ASSERT_EQ(scenario.remarks.size(), 1u);
  EXPECT_EQ(scenario.remarks[0].kind, "basis");
  EXPECT_THAT(scenario.remarks[0].text, HasSubstr("'bodies.fin*.mass' covers nothing"));
}

TEST(Basis, InstancesOfTemplatesBringTheirs) {
  const std::string own = "basis: [{of: elements.spring<i>, is: datasheet}]\n    elements: {spring<i>";
  std::string text = kScenario;
  text.replace(text.find("elements: {spring<i>"), 20, own);
  const hil::ScenarioRecord record = hil::load_record(hil::load_scenario_text(text, "pair.yaml"));
  EXPECT_THAT(list_covered(record, 1), ElementsAre("elements.spring2.stiffness", "elements.spring2.free_length"));
}

TEST(Basis, AnOverrideIsAValueWithoutAPlaceInTheFile) {
  const hil::ScenarioRecord record =
      hil::load_record(hil::load_scenario_text(kScenario, "pair.yaml", {"bodies.core.mass=3 t"}));
  EXPECT_EQ(find(record, "bodies.core.mass").text, "3 t");
  EXPECT_EQ(find(record, "bodies.core.mass").mark.override_index, 0);
}

TEST(Basis, RequirementsHaveParentsAndReasons) {
  const hil::ScenarioRecord record = read("");
  EXPECT_EQ(record.requirements[0].parent, "SYS-4.2");
  EXPECT_EQ(record.requirements[0].rationale, "as long as the film");
}

}  // namespace
}  // namespace unlatch::test::basis_test
