// Every kind of quantity that the table has, by its text in the language: as a named quantity, a condition, a sensor,
// an output, a requirement and a column that an objective may name.
#include "hil/scenario/quantities.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "hil/run/outputs/output_reader.h"
#include "hil/run/run.h"
#include "hil/run/starting_quantities.h"
#include "hil/scenario/measurable.h"
#include "hil/study/evaluation/results.h"
#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::quantities_test {
namespace {

// A body, an element, a contact of every sort that a quantity may name.
constexpr const char* kBase = R"(unlatch: 1
name: quantities
step: {dt: 1 ms, until: 0.05}
gravity: {uniform: [0, 0, -9.81]}
bodies:
  core: {mass: 100, inertia: [10, 11, 12], rate: [0, 0, 0.5], shape: [{sphere: {radius: 0.2}}]}
  stage:
    law: {of: burnt, at: [0, 6], mass: [16, 10], inertia: [[2, 3, 3], [1.2, 2, 2]], centre_of_mass: [[0, 0, 0], [0, 0, 0]], jet_exit: [-1, 0, 0]}
    position: [0, 3, 0]
    velocity: [0.1, 0.2, 0.3]
    rate: [0.1, 0.2, 0.3]
    shape: [{sphere: {radius: 0.5}}]
  pod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0], velocity: [0, 0.5, 0], rate: [0, 0, 0.5]}
joints:
  root: {between: [core, pod], point: [1, 0, 0], follower_point: [0, 0, 0], modes: {hinge: {kind: revolute, axis: z}, free: {kind: free}}, mode: hinge}
elements:
  engine: {type: thrust, body: stage, direction: [1, 0, 0], profile: 20, consumption: 0.01, tank: stage, channel: throttle}
  drive: {type: joint_spring, joint: root, axis: rot_z, effort: 0.3, stiffness: 2, rest: 0.1}
  spring: {type: spring, between: [core, stage], stiffness: 20, free_length: 2}
  keeper: {type: plane_torsion, between: [core, pod], normal: [0, 1, 0], axis: [0, 0, 1], stiffness: 5}
  pusher: {type: pusher, between: [core, stage], stroke: 5 cm, preload: 100 N, stiffness: 1 kN/m}
  reel: {type: cord, between: [core, stage], length: 3 m, wraps: {centre: [0, 0, 0], axis: [0, 0, 1], radius: 40 cm}, stiffness: 1 kN/m}
contacts:
  bump: {between: [core, stage], stiffness: 1 kN/m}
channels:
  throttle: {initial: 1, range: [0, 2]}
signals: [lit]
)";

// A planet and air for quantities of flight.
constexpr const char* kSky = R"(environment: {planet: wgs84, origin: start, atmosphere: us1976}
start: {latitude: 46 deg, longitude: 63 deg, altitude: 30 km, velocity: [100, 50, -20]}
)";

std::string name(std::size_t i) { return "q" + std::to_string(i); }

struct Case {
  Case() {
    const hil::Scenario base = hil::load_scenario_text(std::string(kBase) + kSky + kEvent, "base.yaml");
    starts = hil::list_starting_quantities(base);
    std::string quantities = "quantities:\n", sensors = "sensors:\n", events = kEvent, requirements = "requirements:\n";
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const std::string low = std::to_string(starts[i].value - 1e-3 * (1 + std::abs(starts[i].value)));
      quantities += "  " + name(i) + ": {" + starts[i].text + "}\n";
      sensors += "  s" + name(i) + ": {type: quantity, quantity: " + name(i) + "}\n";
      events += "  - {name: e" + name(i) + ", when: {quantity: " + name(i) + ", above: " + low + "}}\n";
      requirements += "  - {id: r" + name(i) + ", quantity: " + name(i) + ", at_least: -1e9}\n";
    }
    text = std::string(kBase) + kSky + quantities + sensors + events + requirements;
  }
  static constexpr const char* kEvent = "events:\n  - {name: lights, when: {time: 0.02}, then: [{raise: lit}]}\n";
  std::vector<hil::StartingQuantity> starts;
  std::string text;
};

TEST(QuantitiesOfScenarios, EveryKindIsListedWithItsUnitAndValue) {
  std::set<std::string> keys;
  for (const hil::StartingQuantity& quantity : Case().starts) {
    EXPECT_TRUE(std::isfinite(quantity.value)) << quantity.text;
    EXPECT_FALSE(quantity.unit.empty()) << quantity.text;
    keys.insert(quantity.text.substr(0, quantity.text.find(':')));
  }
  for (const std::string& key : hil::list_quantity_keys()) EXPECT_EQ(keys.count(key), 1u) << key;
}

TEST(QuantitiesOfScenarios, EachIsASensorAnOutputAConditionARequirementAndAnObjective) {
  const Case the;
  const AnalysedRun run(the.text);
  const hil::Scenario scenario = hil::load_scenario_text(the.text, "all.yaml");
  ASSERT_EQ(scenario.named_quantities, the.starts.size());
  const auto simulation = hil::build_simulation(scenario);
  hil::OutputReader reader(scenario, *simulation);
  std::vector<double> outputs(reader.count_values());
  std::set<std::string> fired;
  for (int tick = 0; tick < 3; ++tick) {
    if (tick > 0)
      for (const FiredEvent& event : simulation->step().events)
        fired.insert(scenario.model.events[static_cast<std::size_t>(event.event)].name);
    reader.read(outputs);
    for (std::size_t i = 0; i < the.starts.size(); ++i) {
      const double value = simulation->workspace().quantities[i];
      if (tick == 0) {
        EXPECT_EQ(value, the.starts[i].value) << the.starts[i].text;
      }
      EXPECT_EQ(simulation->workspace().sensors[i], value) << the.starts[i].text;
      for (const hil::Output& output : reader.list())
        if (output.name == "quantity." + name(i)) {
          EXPECT_EQ(outputs[output.first], value) << the.starts[i].text;
        }
    }
  }
  std::set<std::string> columns;
  for (const hil::ResultColumn& column : hil::list_columns(scenario)) columns.insert(column.name);
  const std::vector<hil::Measurable> measurables = hil::list_measurables(scenario);
  for (std::size_t i = 0; i < the.starts.size(); ++i) {
    EXPECT_EQ(fired.count("e" + name(i)), 1u) << the.starts[i].text;
    const hil::Verdict verdict = run.judge("r" + name(i));
    EXPECT_TRUE(verdict.is_met()) << the.starts[i].text << " " << verdict.why;
    EXPECT_TRUE(std::isfinite(verdict.value)) << the.starts[i].text;
    EXPECT_TRUE(std::any_of(measurables.begin(), measurables.end(), [&](const hil::Measurable& measurable) {
      return measurable.name == "quantity." + name(i);
    })) << the.starts[i].text;
    EXPECT_EQ(columns.count("r" + name(i)), 1u) << the.starts[i].text;
  }
}

TEST(QuantitiesOfScenarios, ConditionsAndRequirementsMayWriteThemInTheirPlace) {
  const AnalysedRun run(std::string(kBase) +
                        "events:\n"
                        "  - {name: fast, when: {velocity: {body: stage, along: [1, 0, 0]}, above: 0.11 m/s}}\n"
                        "  - {name: later, when: {since: fast, above: 5 ms}}\n"
                        "requirements:\n"
                        "  - {id: felt, specific_force: {body: stage, component: x}, at_most: 5}\n"
                        "  - {id: delay, time: {event: later, after: fast}, range: [4.9999 ms, 5.0001 ms]}\n");
  EXPECT_TRUE(run.judge("felt").is_met());
  EXPECT_TRUE(run.judge("delay").is_met()) << run.judge("delay").value;
}

TEST(QuantitiesOfScenarios, MistakesNameTheirPlaceAndWhatWouldBeRight) {
  const auto expect = [](const std::string& more, const std::string& part) {
    try {
      hil::load_scenario_text(kBase + more, "mistake.yaml");
      ADD_FAILURE() << part;
    } catch (const hil::ScenarioError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  expect("quantities: {q: {velocty: core}}\n", "velocty");
  expect("quantities: {q: {velocity: coree}}\n", "did you mean 'core'");
  expect("quantities: {q: {velocity: {body: core, relative_to: core}}}\n", "a body relative to itself");
  expect("quantities: {q: {angle: root}}\n", "angle needs more than a name");
  expect("quantities: {q: {burnt: core}}\n", "no mass law");
  expect("quantities: {q: {velocity: core}}\nevents: [{name: e, when: {quantity: p, above: 1}}]\n", "did you mean 'q'");
  expect("quantities: {q: {since: nothing}}\n", "unknown event 'nothing'");
  expect("quantities: {q: {rate: {body: core, about: [1, 0, 0], component: x}}}\n", "a component and a direction");
}

// About each axis, whichever rotations a joint leaves free.
TEST(QuantitiesOfScenarios, TheSpeedOfAJointIsTheRateOfItsAngle) {
  for (const auto& [mode, motion] : {std::pair{"{kind: free}", "rate: [1, 1.2, 0.7], velocity: [0, 0.55, -0.5]"},
                                     {"{kind: ball}", "rate: [1, 1.2, 0.7], velocity: [0, 0.55, -0.5]"},
                                     {"{rows: [x, y, z, rot_x]}", "rate: [0.3, 1.2, 0.7], velocity: [0, 0.55, -0.5]"},
                                     {"{kind: universal}", "rate: [1, 1.2, 0.4], velocity: [0, 0.4, -0.5]"}}) {
    std::string text = std::string(R"(unlatch: 1
name: twist
step: {dt: 1 ms, until: 1}
bodies:
  a: {mass: 10, inertia: [1, 1.2, 1.5], rate: [0.3, -0.2, 0.4]}
  b: {mass: 1, inertia: [0.03, 0.18, 0.2], position: [1, 0, 0], )") +
                       motion + R"(}
joints:
  j: {between: [a, b], point: [0.5, 0, 0], follower_point: [-0.5, 0, 0], modes: {m: )" +
                       mode + "}}\nsensors:\n";
    for (const std::string axis : {"x", "y", "z"})
      text += "  angle" + axis + ": {type: angle, joint: j, axis: " + axis + "}\n  speed" + axis +
              ": {type: speed, joint: j, axis: rot_" + axis + "}\n";
    const hil::Scenario scenario = hil::load_scenario_text(text, "twist.yaml");
    const auto simulation = hil::build_simulation(scenario);
    const std::size_t axes = std::string(mode) == "{kind: universal}" ? 4 : 6;  // it has no turn about z
    std::vector<std::vector<double>> seen;
    for (int tick = 0; tick < 600; ++tick) {
      ASSERT_EQ(simulation->step().status, StepStatus::kOk);
      seen.emplace_back(simulation->workspace().sensors.begin(), simulation->workspace().sensors.end());
    }
    for (std::size_t tick = 2; tick + 2 < seen.size(); ++tick)
      for (std::size_t i = 0; i < axes; i += 2) {
        const auto at = [&](std::size_t k) { return seen[k][i]; };
        const double rate = (8 * (at(tick + 1) - at(tick - 1)) - (at(tick + 2) - at(tick - 2))) / (12 * scenario.dt);
        ASSERT_NEAR(seen[tick][i + 1], rate, 1e-8) << mode << ", axis " << i / 2 << ", tick " << tick;
      }
  }
}

}  // namespace
}  // namespace unlatch::test::quantities_test
