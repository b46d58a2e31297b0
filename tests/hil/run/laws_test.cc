// Tables and expressions of scenarios: against an integration of SciPy's, by commands and overrides, in files, refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "hil/run/findings/findings.h"
#include "hil/run/run.h"
#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::laws_test {
namespace {

using ::testing::HasSubstr;

constexpr double kReference = 1e-9;  // m, m/s of some 1: RK4 at 1 ms and SciPy at 1e-13

// Of tests/references/laws_reference.py, without its last digits.
constexpr const char* kBall = R"yaml(unlatch: 1
name: laws
step: {dt: 1 ms, until: 2 s}
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0], velocity: [0, 1, 0]}
channels:
  factor: {initial: 1, range: [0, 5]}
tables:
  grip:
    axes:
      x: {of: {position: {body: ball, component: x}}, at: [-2, -1.2, -0.5, 0, 0.6, 1.3, 2], unit: m}
      speed: {of: speed, at: [0, 1, 2, 4], unit: m/s}
    values: [[1.1, 1.6, 2.2, 3.4], [2.9, 2.2, 1.4, 0.3], [2.6, 2.5, 2.1, 1.9], [3.0, 3.0, 3.1, 3.3], [-1.2, -1.4, -1.9, -3.0],
             [-2.4, -2.1, -1.6, -0.2], [-4.0, -4.4, -5.0, -6.6]]
    unit: N
    interpolation: smooth
    scale_channel: factor
  push: {axes: {t: {at: [0, 500, 1000, 2000], unit: ms}}, values: [0, 2, -1, 0.5], unit: N}
quantities:
  x: {position: {body: ball, component: x}}
  y: {position: {body: ball, component: y}}
  vy: {velocity: {body: ball, component: y}}
  speed: {velocity: ball}
  grip_now: {expression: grip}
elements:
  across: {type: force, body: ball, frame: world, direction: [1, 0, 0], profile: {expression: grip}}
  back: {type: force, body: ball, frame: world, direction: [0, 1, 0],
         profile: {expression: "-1.5 N/m * y * (1 + 0.2 * sin(3 rad/s * time)) - 0.1 kg/m * vy * speed"}}
  up: {type: force, body: ball, frame: world, direction: [0, 0, 1],
       profile: {expression: "push(on_time) * exp(-0.3 * time / (1 s)) + 0.2 N/rad * atan2(y * 1 m, 1 m2 + x^2)"}}
)yaml";
constexpr double kPosition[] = {-0.08747337712915698, 1.0730893613821773, 0.5246557301016895};
constexpr double kVelocity[] = {0.20289329114856253, -0.10457392727485558, 0.3475805584412296};

std::string replace(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string list_mistakes(const std::string& text, const std::string& file = "laws.yaml") {
  try {
    hil::load_scenario_text(text, file);
    return "";
  } catch (const hil::ScenarioError& error) {
    return error.what();
  }
}

TEST(LawsOfScenarios, MoveABallAsAnIndependentIntegrationDoes) {
  const AnalysedRun run(kBall);
  const BodyState& ball = run.simulation->state().bodies[0];
  EXPECT_NEAR(ball.p.x, kPosition[0], kReference);
  EXPECT_NEAR(ball.p.y, kPosition[1], kReference);
  EXPECT_NEAR(ball.p.z, kPosition[2], kReference);
  EXPECT_NEAR(ball.v.x, kVelocity[0], kReference);
  EXPECT_NEAR(ball.v.y, kVelocity[1], kReference);
  EXPECT_NEAR(ball.v.z, kVelocity[2], kReference);
}

TEST(LawsOfScenarios, AreReachedByOverrides) {
  const auto run = [](const std::vector<std::string>& overrides) {
    const hil::Scenario scenario = hil::load_scenario_text(kBall, "laws.yaml", overrides);
    const auto simulation = hil::build_simulation(scenario);
    EXPECT_EQ(simulation->step().status, StepStatus::kOk);
    return simulation->workspace().quantities[4];
  };
  const double force = run({});
  EXPECT_NEAR(run({"tables.grip.scale=1.5"}), 1.5 * force, 1e-5);
  EXPECT_NEAR(run({"tables.grip.offset=0.25"}), force + 0.25, 1e-5);
  EXPECT_NEAR(run({"quantities.grip_now.scale=-2"}), -2 * force, 1e-5);
  EXPECT_NEAR(run({"quantities.grip_now.offset=3 N"}), force + 3, 1e-5);
  EXPECT_NEAR(run({"channels.factor.initial=0.5"}), 0.5 * force, 1e-5);
}

// What a command does to a table that a force reads; saved and restored, and with the hash of the same ticks.
TEST(LawsOfScenarios, ACommandScalesATableInTheRun) {
  const hil::Scenario scenario = hil::load_scenario_text(kBall, "laws.yaml");
  const auto first = hil::build_simulation(scenario), second = hil::build_simulation(scenario);
  std::vector<std::uint64_t> saved;
  std::vector<std::int64_t> hashes;
  for (int tick = 0; tick < 400; ++tick) {
    if (tick == 100) first->set_channel(0, 3);
    if (tick == 200) saved = first->save();
    ASSERT_EQ(first->step().status, StepStatus::kOk);
    if (tick == 99) {
      EXPECT_NEAR(first->workspace().quantities[4], first->workspace().laws[0], 1e-15);
    }
    if (tick >= 200) hashes.push_back(first->calc_hash());
  }
  EXPECT_GT(std::abs(first->workspace().quantities[4]), 3);  // three times the force
  ASSERT_TRUE(second->restore(saved));
  for (const std::int64_t hash : hashes) {
    ASSERT_EQ(second->step().status, StepStatus::kOk);
    EXPECT_EQ(second->calc_hash(), hash);
  }
}

TEST(LawsOfScenarios, AreConditionsAndRequirements) {
  const AnalysedRun run(std::string(kBall) +
                        "events:\n"
                        "  - {name: low, when: {expression: \"2 * x\", below: 1 m}}\n"
                        "requirements:\n"
                        "  - {id: fast, expression: \"speed / (2 s)\", at_most: 100 m/s2}\n"
                        "  - {id: low, time: {event: low}, range: [0.3, 1.5]}\n");
  EXPECT_TRUE(run.judge("fast").is_met());
  EXPECT_TRUE(run.judge("low").is_met());
}

TEST(LawsOfScenarios, ThrustMayStandAndPointWhereItShouldNot) {
  const hil::Scenario scenario = hil::load_scenario_text(R"(unlatch: 1
name: misaligned
step: {dt: 1 ms, until: 1 s}
bodies: {b: {mass: 2, inertia: [1, 1, 1]}}
elements:
  e: {type: thrust, body: b, point: [-1, 0, 0], offset: [0, 2 mm, 0], direction: [2, 0, 0], misalignment: [0, 0, 30 deg], profile: 1 N}
)",
                                                         "misaligned.yaml");
  const Load& load = scenario.model.loads[0];
  EXPECT_NEAR((load.direction - Eigen::Vector3d(std::sqrt(3.0), 1, 0)).norm(), 0, 1e-15);
  EXPECT_EQ(load.point, Eigen::Vector3d(-1, 0.002, 0));
}

// Writes a scenario with a table from a file; returns the mistakes that it has.
struct Folder {
  explicit Folder(const std::string& csv, const std::string& table = "file: t.csv") {
    path = std::filesystem::path(::testing::TempDir()) / ("unlatch-laws-test-" + std::to_string(getpid()));
    std::filesystem::create_directories(path);
    std::ofstream(path / "t.csv", std::ios::binary) << csv;
    std::ofstream(path / "s.yaml") << "unlatch: 1\nname: files\nstep: {dt: 1 ms, until: 1 s}\n"
                                      "bodies: {b: {mass: 2, inertia: [1, 1, 1]}}\ntables:\n  made: {"
                                   << table << "}\n";
  }
  ~Folder() { std::filesystem::remove_all(path); }
  hil::Scenario load() const { return hil::load_scenario((path / "s.yaml").string()); }
  std::string list_mistakes() const {
    try {
      load();
      return "";
    } catch (const hil::ScenarioError& error) {
      return error.what();
    }
  }
  std::filesystem::path path;
};

TEST(TablesFromFiles, HaveTheKnotsValuesAndUnitsOfTheirColumns) {
  const Folder folder(
      "\xEF\xBB\xBF# made by hand\r\nmach; alpha [deg]; cx; force [kN]\r\n\r\n0.5; 0; 1; 10\r\n0.5; 90; 2; +20\r\n"
      "0.5; 180; 3; 3e1\r\n2;0;4;40\r\n2;90;5;50\r\n2;180;6;60",
      "file: t.csv, column: force, axes: {mach: {ends: error}, alpha: {above: notice}}");
  const hil::Scenario scenario = folder.load();
  const Table& table = scenario.model.tables[0];
  EXPECT_EQ(table.values, (std::vector<double>{1e4, 2e4, 3e4, 4e4, 5e4, 6e4}));
  EXPECT_EQ(table.axes[0].knots, (std::vector<double>{0.5, 2}));
  ASSERT_EQ(table.axes[1].knots.size(), 3u);
  EXPECT_NEAR(table.axes[1].knots[2], std::acos(-1.0), 1e-15);
  EXPECT_EQ(table.axes[0].below, TableAxis::End::kError);
  EXPECT_EQ(table.axes[1].below, TableAxis::End::kClamp);
  EXPECT_EQ(table.axes[1].above, TableAxis::End::kNotice);
  // A recording's text has the file in it.
  const hil::Scenario again = hil::load_scenario_text(scenario.text, "again.yaml");
  EXPECT_EQ(again.model.tables[0].values, table.values);
}

TEST(TablesFromFiles, OfAHundredThousandEntriesAreReadAndRecorded) {
  std::string csv = "mach, alpha [deg], beta [deg], force [kN]\n";
  for (int m = 0; m < 50; ++m)
    for (int a = 0; a < 50; ++a)
      for (int b = 0; b < 40; ++b)
        csv += std::to_string(0.125 * m) + "," + std::to_string(a) + "," + std::to_string(b) + "," +
               std::to_string(m + a * b) + "\n";
  ASSERT_GT(csv.size(), 1u << 20);  // more than a scenario without tables may have
  const std::string axes = "file: t.csv, axes: {mach: {}, alpha: {}, beta: {}}";
  const Folder folder(csv, axes);
  const hil::Scenario scenario = folder.load();
  ASSERT_EQ(scenario.model.tables[0].values.size(), 100000u);
  EXPECT_EQ(scenario.model.tables[0].values.back(), 1e3 * (49 + 49 * 39));
  const hil::Scenario again = hil::load_scenario_text(scenario.text, "again.yaml");
  EXPECT_EQ(again.model.tables[0].values, scenario.model.tables[0].values);
  const Folder larger(csv + std::string(16u << 20, '\n'), axes);
  EXPECT_THAT(larger.list_mistakes(), HasSubstr("bytes, more than 16 MiB"));
}

TEST(TablesFromFiles, MistakesNameTheLineAndTheColumn) {
  const auto expect = [](const std::string& csv, const std::string& part, const std::string& table = "file: t.csv") {
    const std::string mistakes = Folder(csv, table).list_mistakes();
    EXPECT_THAT(mistakes, HasSubstr(part)) << csv;
  };
  const std::string head = "a, b, v\n0, 0, 1\n0, 1, 2\n";
  expect(head + "1, 0, 3\n1, 2, 4\n", "t.csv:5:4: 'b' is 2 where 1 is expected");
  expect(head + "1, 0, 3\n", "t.csv:4:7: the table ends here, with 3 rows of 4");
  expect(head + "1, 0, 3\n1, 1, nan\n", "t.csv:5:7: 'nan' is not finite");
  expect(head + "1, 0, 3\n1, 1, \n", "t.csv:5:7: a value is missing");
  expect(head + "1, 0, 3\n1, 1\n", "t.csv:5:4: a row of 2 values under 3 headings");
  expect(head + "1, 0, 3\n1, 1, x4\n", "t.csv:5:7: 'x4' is not a number");
  expect(head + "0, 0, 3\n0, 1, 4\n", "'a' does not rise: 0 after 0");
  expect(head + "1, 0, 3\n1, 1, 4\n1, 0, 3\n1, 1, 4\n", "t.csv:6:1: 'a' does not rise: 1 after 1");
  expect("a, a, v\n", "t.csv:1:4: a second column 'a'");
  expect("a, b c, v\n", "t.csv:1:4: 'b c' is not the heading of a column");
  expect("a [furlong], v\n0, 1\n1, 2\n", "t.csv:1:1: 'furlong' is not a unit");
  expect("", "there is no heading");
  expect("a, v\n", "there are no rows");
  expect(head, "unknown column of t.csv 'c'", "file: t.csv, axes: {c: {}}");
  expect(head, "there is no such file", "file: u.csv");
  expect(head, "it lies outside", "file: ../t.csv");
}

TEST(LawsOfScenarios, MistakesNameTheirPlaceAndWhatWouldBeRight) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& part) {
    EXPECT_THAT(list_mistakes(replace(kBall, from, to)), HasSubstr(part));
  };
  expect("{expression: grip}\nelements", "{expression: \"grip + 1 m\"}\nelements",
         "a sum of a force (N) and a length (m)");
  expect("profile: {expression: grip}", "profile: {expression: \"2 * x\"}",
         "this expression is a length (m), not a force (N)");
  expect("profile: {expression: grip}", "profile: {expression: \"grip / (1 N)\"}", "multiply it by 1 N");
  expect("profile: {expression: grip}", "profile: {expression: \"grop\"}", "did you mean 'grip'");
  expect("profile: {expression: grip}", "profile: {expression: \"push\"}", "does not say what its axes are of");
  expect("push(on_time)", "push(on_time, x)", "table 'push' of 2 values; it takes 1 value");
  expect("push(on_time)", "push(x)", "axis 1 of table 'push' is a time (s), not a length (m)");
  expect("{expression: grip}\nelements", "{expression: \"on_time * 1 N/s\"}\nelements", "'on_time' is neither");
  expect("{expression: grip}\nelements", "{expression: \"grip_now\"}\nelements",
         "quantity 'grip_now' is not known here");
  expect("{expression: grip}\nelements", "{expression: grip, unit: m}\nelements", "is a force (N), not a length (m)");
  expect("{expression: grip}\nelements", "{acceleration: ball}\nelements", "");
  expect("values: [0, 2, -1, 0.5]", "values: [0, 2, -1]", "the number of its values is 3; 4");
  expect("at: [0, 500, 1000, 2000]", "at: [0, 500, 500, 2000]", "knots do not increase");
  expect("at: [0, 500, 1000, 2000]", "at: [0, 500, 5 kg, 2000]", "one unit for all");
  expect("of: speed", "of: grip", "is looked up at itself");
  expect("interpolation: smooth", "interpolation: cubic", "unknown interpolation 'cubic'");
  expect("scale_channel: factor", "scale_channel: facto", "did you mean 'factor'");
  expect("unit: N}", "unit: newt}", "'newt' is not a unit");
}

TEST(LawsOfScenarios, ACoefficientThatIsAnAngleSaysWhatToDivideItBy) {
  EXPECT_THAT(list_mistakes("unlatch: 1\nname: slip\nstep: {dt: 1 ms, until: 1 s}\n"
                            "environment: {planet: wgs84, atmosphere: us1976}\nstart: {velocity: [1, 0, 0]}\n"
                            "bodies: {b: {mass: 1, inertia: [1, 1, 1]}}\nquantities: {beta: {sideslip: b}}\n"
                            "elements: {air: {type: aerodynamics, body: b, area: 1, cy: {expression: -0.6 * beta}}}\n"),
              HasSubstr("this expression is an angle (rad), not a plain number; divide it by (1 rad)"));
}

TEST(LawsOfScenarios, AForceMayNotReadWhatFollowsFromTheForces) {
  const std::string text = replace(kBall, "  speed: {velocity: ball}",
                                   "  speed: {velocity: ball}\n  felt: {acceleration: {body: ball, component: x}}");
  EXPECT_EQ(list_mistakes(text), "");
  EXPECT_THAT(list_mistakes(replace(text, "profile: {expression: grip}", "profile: {expression: \"felt * 1 kg\"}")),
              HasSubstr("a force reads it, and it reads 'acceleration', which follows from the forces"));
}

TEST(LawsOfScenarios, CheckNamesCornersAndIntervalsBelowTheStep) {
  const auto list = [](const std::string& text) {
    const hil::Scenario scenario = hil::load_scenario_text(text, "laws.yaml");
    std::string all;
    for (const hil::Finding& finding : hil::list_findings(scenario, *hil::build_simulation(scenario)))
      all += finding.name + " " + finding.where + " " + finding.text + "\n";
    return all;
  };
  const std::string found = list(kBall);
  EXPECT_THAT(found,
              HasSubstr("corner table 'push' is linear, and forces read it: each knot that is passed is located"));
  EXPECT_EQ(found.find("'grip'"), std::string::npos);
  EXPECT_THAT(list(replace(kBall, "at: [0, 500, 1000, 2000]", "at: [0, 500, 500.5, 2000]")),
              HasSubstr("step table 'push' has an interval of 0.0005 s, less than a step of 0.001 s"));
}

// Thrust of a firing test, from the instant at which the engine is switched on; the impulse is that of the trapezoids.
TEST(LawsOfScenarios, ATailOffFromTestDataGivesItsImpulse) {
  const AnalysedRun run(
      "unlatch: 1\nname: engine\nstep: {dt: 10 ms, until: 1.5 s}\nbodies: {stage: {mass: 200, inertia: [1, 1, 1]}}\n"
      "tables: {tail: {axes: {t: {at: [0, 0.0313, 0.1208, 0.2777, 0.6], unit: s}}, values: [9, 9.4, 5.1, 1.3, 0], "
      "unit: kN, scale: 1.02}}\n"
      "elements: {engine: {type: thrust, body: stage, direction: [1, 0, 0], profile: {expression: tail(on_time)}, "
      "enabled: false}}\n"
      "events: [{name: cutoff, when: {time: 0.2345}, then: [{switch: {element: engine, to: true}}]}]\n");
  const double t[] = {0, 0.0313, 0.1208, 0.2777, 0.6}, f[] = {9e3, 9.4e3, 5.1e3, 1.3e3, 0};
  double impulse = 0;
  for (int i = 0; i < 4; ++i) impulse += 0.5 * (t[i + 1] - t[i]) * (f[i] + f[i + 1]);
  EXPECT_NEAR(run.simulation->state().bodies[0].v.x, 1.02 * impulse / 200, 1e-10);
}

// A pusher of 0.1 m; its follower comes back by a spring, on the guide or 2 m beside it.
TEST(Pushers, WithAGuideThatPushBesideItLeaveTheirBodiesUnresolved) {
  const auto list = [](const char* velocity) {
    const AnalysedRun run(std::string("unlatch: 1\nname: guided\nstep: {dt: 1 ms, until: 4 s}\nbodies: {pod: {mass: 2, "
                                      "inertia: [1, 1, 1], velocity: ") +
                          velocity +
                          "}}\nelements:\n  bolt: {type: pusher, between: [ground, pod], guide: [1, 0, 0], stroke: 10 "
                          "cm, preload: 40 N}\n"
                          "  back: {type: force, body: pod, frame: world, direction: [-1, 0, 0], profile: 2 N}\n");
    std::string notices;
    for (const hil::RunNotice& notice : run.analysis.accuracy().get())
      notices += notice.name + " " + notice.subject + " " + notice.text + (notice.unresolved ? " unresolved\n" : "\n");
    return notices;
  };
  EXPECT_EQ(list("[0, 0, 0]"), "");
  const std::string beside = list("[0, 1, 0]");
  EXPECT_THAT(beside, HasSubstr("beside bolt it pushes"));
  EXPECT_THAT(beside, HasSubstr("unresolved"));
}

// 1 m a step along x: cells of the axis over x are 0.2 m long; the axis over y is at rest.
std::string list_cell_notices(const char* table, const char* interpolation, const char* dt) {
  const AnalysedRun run(
      std::string("unlatch: 1\nname: skipped\nstep: {dt: ") + dt +
      ", until: 100 ms}\nbodies: {ball: {mass: 2, inertia: [1, 1, 1], velocity: [100, 0, 0]}}\ntables:\n  fine: {" +
      table + ", interpolation: " + interpolation +
      "}\nquantities:\n  x: {position: {body: ball, component: x}}\n  y: {position: {body: ball, component: y}}\n"
      "elements: {push: {type: force, body: ball, frame: world, direction: [0, 0, 1], profile: {expression: 1 N * "
      "fine}}}\n");
  std::string notices;
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    notices += notice.name + " " + notice.subject + " " + notice.text + (notice.unresolved ? " unresolved\n" : "\n");
  return notices;
}

TEST(LawsOfScenarios, ATableWhoseCellsAreSkippedLeavesItsBodyUnresolvedOnEveryAxis) {
  const char* first =
      "axes: {a: {of: x, at: [2, 2.2, 2.4, 2.6, 2.8, 3], unit: m}, b: {of: y, at: [-1, 1], unit: m}}, "
      "values: [[0, 0], [1, 1], [5, 5], [1, 1], [0, 0], [0, 0]]";
  const char* second =
      "axes: {b: {of: y, at: [-1, 1], unit: m}, a: {of: x, at: [2, 2.2, 2.4, 2.6, 2.8, 3], unit: m}}, "
      "values: [[0, 1, 5, 1, 0, 0], [0, 1, 5, 1, 0, 0]]";
  for (const char* table : {first, second}) {
    for (const char* interpolation : {"smooth", "linear"}) {
      const std::string found = list_cell_notices(table, interpolation, "10 ms");
      EXPECT_THAT(found, HasSubstr("cell fine a step passes 4 whole cells of its axis a, from "));
      EXPECT_THAT(found, HasSubstr("unresolved"));
    }
    EXPECT_EQ(list_cell_notices(table, "smooth", "1 ms"), "");
    EXPECT_EQ(list_cell_notices(table, "linear", "5 ms"), "");  // its knots are located
  }
}

TEST(LawsOfScenarios, ATableThatIsLeftIsNoticedOrEndsTheRun) {
  const std::string noticed =
      replace(kBall, "at: [0, 500, 1000, 2000], unit: ms", "at: [0, 500, 1000, 1500], unit: ms, ends: notice");
  const AnalysedRun run(noticed);
  std::string notices;
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    notices += notice.name + " " + notice.subject + " " + notice.text + "\n";
  EXPECT_THAT(notices, HasSubstr("table push table 'push', axis t: 2 is above 1.5: the value at the end holds"));
  const hil::Scenario scenario = hil::load_scenario_text(replace(noticed, "ends: notice", "ends: error"), "laws.yaml");
  const auto simulation = hil::build_simulation(scenario);
  StepReport report;
  while (report.status == StepStatus::kOk && simulation->get_tick() < 2000) report = simulation->step();
  EXPECT_EQ(simulation->get_tick(), 1500);
  EXPECT_THAT(hil::describe_fault(report, simulation->get_tick(), scenario.model, scenario.dt),
              HasSubstr("a table was left: table 'push', axis t: 1.501 is above 1.5, tick 1500"));
}

}  // namespace
}  // namespace unlatch::test::laws_test
