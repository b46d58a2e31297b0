// Laws that forces read, and of which a step sees too little: what it passes over makes what depends on it unresolved.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <regex>
#include <string>

#include "hil/run/findings/findings.h"
#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::law_watch_test {
namespace {

using ::testing::HasSubstr;

// A block of 2 kg that drifts along x at 1 m/s, begins at 0.0003 m, and is pushed along y.
std::string push(const std::string& law, const std::string& dt, const std::string& more = "") {
  return "unlatch: 1\nname: watched\nstep: {dt: " + dt +
         ", until: 1 s}\nbodies: {block: {mass: 2, inertia: [1, 1, 1], position: [0.0003, 0, 0], velocity: [1, 0, "
         "0]}}\n" +
         more +
         "quantities:\n  x: {position: {body: block, component: x}}\n  y: {position: {body: block, component: y}}\n"
         "  vy: {velocity: {body: block, component: y}}\n"
         "elements: {push: {type: force, body: block, frame: world, direction: [0, 1, 0], profile: {expression: \"" +
         law +
         "\"}}}\nrequirements: [{id: fast, velocity: {body: block, component: y}, take: final, at_least: -1e9 "
         "m/s}]\n";
}

std::string list_notices(const AnalysedRun& run) {
  std::string text;
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    text += notice.name + " " + notice.text + (notice.unresolved ? " [unresolved]" : "") + "\n";
  return text;
}

bool is_unresolved(const AnalysedRun& run) { return !run.judge("fast").unresolved.empty(); }

std::string list_findings(const std::string& text) {
  const hil::Scenario scenario = hil::load_scenario_text(text, "watched.yaml");
  std::string found;
  for (const hil::Finding& finding : hil::list_findings(scenario, *hil::build_simulation(scenario)))
    if (finding.name == "law") found += finding.text + "\n";
  return found;
}

struct Law {
  const char* text;
  double impulse;  // N s; 0: not known in closed form
};

// Over within half a step, wherever in it.
const Law kPulses[] = {
    {"500 N * exp(-((time - 0.5033 s) / (1 ms))^2)", 0.5 * std::sqrt(M_PI)},
    {"500 N * exp(-((x - 0.5033 m) / (1 mm))^2)", 0.5 * std::sqrt(M_PI)},
    {"500 N * exp(-((x - 0.5071 m) / (0.1 mm))^2)", 0.05 * std::sqrt(M_PI)},
    {"if_less(((x - 0.5033 m) / (1 mm))^2, 0.25, 500 N, 0 N)", 0.5},
    {"if_less(((time - 0.5066 s) / (1 ms))^2, 0.04, 500 N, 0 N)", 0.2},
    {"max(0 N, 500 N - 500 N * ((x - 0.5033 m) / (1 mm))^2)", 0.5 * 4 / 3},
    {"500 N / (((x - 0.5033 m) / (1 mm))^2 + 1)", 0.5 * (std::atan(503) + std::atan(497))},
    {"3 N + 500 N * exp(-((x - 0.5033 m) / (1 mm))^2)", 3 + 0.5 * std::sqrt(M_PI)},
    {"500 N * (0.5 - atan(sqrt(((x - 0.5033 m) / (0.1 mm))^2 + 0.04)) / (pi rad))", 0},
    {"500 N * cos(min(1, ((x - 0.5033 m) / (1 mm))^2) * pi rad / 2)", 0},
};

TEST(LawsWatched, APulseShorterThanHalfAStepLeavesItsBodyUnresolved) {
  for (const Law& law : kPulses) {
    const AnalysedRun run(push(law.text, "10 ms"));
    EXPECT_TRUE(is_unresolved(run)) << law.text << "\n" << list_notices(run);
    EXPECT_THAT(list_notices(run), HasSubstr("law ")) << law.text;
  }
}

// Where one corner leads to the next, all are located.
TEST(LawsWatched, APulseWhoseCornersAreFoundIsNoLess) {
  for (const Law& law : {Law{"if_less(abs(x - 0.5033 m), 0.5 mm, 500 N, 0 N)", 0.5},
                         Law{"if_less(abs(time - 0.5066 s), 0.2 ms, 500 N, 0 N)", 0.2},
                         Law{"if_less(x, 0.5033 m, 0 N, 1 N) * if_less(x, 0.5043 m, 500, 0)", 0.5},
                         Law{"max(0 N, 500 N - 500 N/mm * abs(x - 0.5033 m))", 0.5}}) {
    const AnalysedRun run(push(law.text, "10 ms"));
    EXPECT_EQ(list_notices(run).find("law "), std::string::npos) << law.text << list_notices(run);
    EXPECT_NEAR(2 * run.simulation->state().bodies[0].v.y, law.impulse, 1e-6) << law.text;
  }
}

// The step that the notice proposes does: the impulse is there, and nothing is unresolved.
TEST(LawsWatched, TheStepThatTheNoticeProposesSuffices) {
  for (const Law& law : kPulses) {
    const std::string said = list_notices(AnalysedRun(push(law.text, "10 ms")));
    std::smatch step;
    ASSERT_TRUE(std::regex_search(said, step, std::regex("a step of ([0-9.e-]+) s would do"))) << law.text << said;
    const AnalysedRun run(push(law.text, step[1].str() + " s"));
    EXPECT_FALSE(is_unresolved(run)) << law.text << " at " << step[1] << "\n" << list_notices(run);
    if (law.impulse > 0) {
      EXPECT_NEAR(2 * run.simulation->state().bodies[0].v.y, law.impulse, 2e-3 * law.impulse) << law.text;
    }
  }
}

// It would be judged when it ceases to rise, which the run does not see.
TEST(LawsWatched, APulseInTheLastStepOfARunIsReported) {
  for (const char* law :
       {"500 N * exp(-((x - 1.0006 m) / (1 mm))^2)", "500 N * exp(-((time - 1.0003 s) / (1 ms))^2)"}) {
    const AnalysedRun run(push(law, "10 ms"));
    EXPECT_TRUE(is_unresolved(run)) << law << "\n" << list_notices(run);
    EXPECT_THAT(list_notices(run), HasSubstr("law it rises")) << law;
    EXPECT_FALSE(is_unresolved(AnalysedRun(push(law, "0.1 ms")))) << law;
  }
}

// The run ends, or what depends on the law is unresolved.
TEST(LawsWatched, AJumpThatIsNotWrittenWithIfLessIsNeverPassedInSilence) {
  for (const char* law :
       {"3 N * (x - 0.5033 m) / abs(x - 0.5033 m)", "3 N * abs(x - 0.5033 m) / (x - 0.5033 m)",
        "3 N * (x - 0.5033 m) / sqrt((x - 0.5033 m)^2)", "3 N * (x - 0.5033 m)^3 / abs(x - 0.5033 m)^3",
        "3 N * (x - 0.5033 m) / (abs(x - 0.5033 m) + 1e-12 m)", "1 N/rad * atan2(x - 0.5033 m, -1 m)",
        "1 N/rad * atan(1 m / (x - 0.5033 m))", "1 N/rad * atan((x - 0.5033 m) / (1e-9 m))",
        "3 N / (1 + exp((x - 0.5033 m) / (1e-6 m)))", "1 N * min(1, max(-1, (x - 0.5033 m) / (1e-9 m)))",
        "1e-9 N / ((x - 0.5033 m) / (1 m))", "1e-6 N * tan(pi rad * x / (1.0066 m))",
        "1 N/rad * asin(sin(pi rad * x / (0.5033 m)) / sqrt(sin(pi rad * x / (0.5033 m))^2))"}) {
    const hil::Scenario scenario = hil::load_scenario_text(push(law, "10 ms"), "jump.yaml");
    const auto simulation = hil::build_simulation(scenario);
    hil::RunAnalysis analysis(scenario, *simulation);
    analysis.update(StepReport{});
    StepReport report;
    while (report.status == StepStatus::kOk && simulation->get_tick() < 100) {
      report = simulation->step();
      if (report.status == StepStatus::kOk) analysis.update(report);
    }
    EXPECT_TRUE(report.status != StepStatus::kOk || !analysis.judge()[0].unresolved.empty()) << law;
  }
  const AnalysedRun written(push("if_less(x, 0.5033 m, -3 N, 3 N)", "10 ms"));
  EXPECT_FALSE(is_unresolved(written)) << list_notices(written);
}

TEST(LawsWatched, ATableThatAllButJumpsLeavesItsBodyUnresolved) {
  const AnalysedRun run(
      push("tab(x)", "10 ms",
           "tables: {tab: {axes: {x: {at: [-1, 0.5033, 0.50330001, 9], unit: m}}, values: [0, 0, 3, 3], unit: N}}\n"));
  EXPECT_TRUE(is_unresolved(run)) << list_notices(run);
}

// What a step resolves is not reported, be it steep in its tails, periodic, or with corners that are located.
TEST(LawsWatched, WhatAStepResolvesIsNotReported) {
  for (const char* law :
       {"5 N * exp(-((time - 0.5033 s) / (50 ms))^2)", "5 N * exp(-((x - 0.5033 m) / (30 mm))^2)",
        "5 N * sin(20 rad/s * time)", "-20 N/m * y + 3 N * cos(10 rad/s * time)", "5 N * exp(-time / (50 ms))",
        "if_less(time, 0.5033 s, 5 N, -5 N)", "5 N * abs(sin(9 rad/s * time))",
        "max(0 N, min(2 N, 8 N/m * (x - 0.3 m)))", "1 N * sqrt(abs(x - 0.5033 m) / (1 m) + 0.1)",
        "0.02 N m / (1.2 m - x)", "-0.5 kg/m * vy * abs(vy) + 3 N", "1 N/rad * atan2(x, 1 m + y)",
        "1 N * log(1 + x / (1 m))", "2 N * x / sqrt(x^2 + y^2 + 0.01 m2)"}) {
    const AnalysedRun run(push(law, "10 ms"));
    EXPECT_EQ(list_notices(run), "") << law;
    EXPECT_EQ(list_findings(push(law, "10 ms")), "") << law;
  }
}

TEST(LawsWatched, CheckKnowsLawsOfTimeBeforehand) {
  EXPECT_THAT(list_findings(push("500 N * exp(-((time - 0.5033 s) / (1 ms))^2)", "10 ms")), HasSubstr("at 0.503"));
  EXPECT_THAT(list_findings(push("if_less(((on_time - 0.5066 s) / (1 ms))^2, 0.04, 500 N, 0 N)", "10 ms")),
              HasSubstr("would do"));
  EXPECT_EQ(list_findings(push("500 N * exp(-((time - 0.5033 s) / (1 ms))^2)", "0.4 ms")), "");
}

}  // namespace
}  // namespace unlatch::test::law_watch_test
