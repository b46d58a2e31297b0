// Facts about one sample of a scenario: it has the bits of a separate run, independent of the thread and of earlier
// samples.
#include "hil/study/evaluation/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <thread>

#include "hil/run/outputs/run_outputs.h"
#include "hil/run/run.h"
#include "hil/study/campaign/campaign.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::evaluation_test {
namespace {

using hil::make_setting;
using hil::SampleEvaluator;
using hil::SampleResult;
using hil::SampleStatus;
using hil::ScenarioTree;
using hil::Setting;

ScenarioTree make_tree(const std::string& text = kGoodScenario) {
  return ScenarioTree(hil::ScenarioSources(text, ""), "s.yaml");
}

const std::string kBoosters = std::string(UNLATCH_SOURCE_DIR) + "/hil/scenarios/boosters/reference.yaml";

// Settings with all digits, a list, an entry by its name, and one that is missing in the file.
std::vector<Setting> vary(int k) {
  const double x = 1 + k / 30.0;
  const std::vector<double> direction{std::cos(0.01 * x), std::sin(0.01 * x), 0};
  return {make_setting("bodies.core.mass", 98500 * x), make_setting("elements.core_thrust.direction", direction),
          make_setting("events.nozzle:booster1.delay", 0.001 * x),
          make_setting("elements.main2.profile.exponential.tau", 0.35 * x), hil::parse_setting("step.until=0.9")};
}

struct Hashes {
  std::int64_t model, state;
  bool operator==(const Hashes&) const = default;
};

Hashes run_anew(const std::vector<Setting>& settings) {
  std::vector<std::string> overrides;
  for (const Setting& setting : settings) overrides.push_back(to_text(setting));
  const hil::Scenario scenario = hil::load_scenario(kBoosters, overrides);
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  const std::atomic<bool> stop{false};
  const hil::LogEnd end =
      hil::run_fast(*simulation, analysis, nullptr, hil::calc_nearest_tick(scenario.until, scenario.dt), stop, [] {});
  return {simulation->get_model_hash(), end.hash};
}

Hashes evaluate(const SampleEvaluator& evaluator, const std::vector<Setting>& settings) {
  const SampleResult result = evaluator.evaluate(settings);
  EXPECT_EQ(result.status, SampleStatus::kDone) << result.message;
  return {result.model_hash, result.hash};
}

TEST(SampleEvaluator, GivesTheBitsOfLoadingTheFileAnew) {
  const ScenarioTree tree(kBoosters);
  const SampleEvaluator evaluator(tree);
  std::vector<Hashes> seen;
  for (int k = 0; k < 5; ++k) {
    const Hashes hashes = evaluate(evaluator, vary(k));
    EXPECT_EQ(hashes, run_anew(vary(k))) << k;
    EXPECT_THAT(seen, testing::Not(testing::Contains(hashes))) << k;
    seen.push_back(hashes);
  }
}

// Files of modes are read and conditioned once for all samples, whatever the damping; other modes anew.
TEST(SampleEvaluator, GivesFlexibleBodiesTheBitsOfReadingTheirModesAnew) {
  const std::string file = std::string(UNLATCH_SOURCE_DIR) + "/hil/scenarios/fairing/scenario.yaml";
  const ScenarioTree tree(file);
  std::vector<std::int64_t> seen;
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{},
        {"bodies.half1.flexible.damping=0.007"},
        {"bodies.half1.flexible.select=[1, 2]", "bodies.half2.flexible.damping=0.003"}}) {
    std::vector<Setting> settings;
    for (const std::string& text : overrides) settings.push_back(hil::parse_setting(text));
    for (int again = 0; again < 2; ++again) {
      const std::int64_t hash = hil::build_simulation(tree.read(settings))->get_model_hash();
      EXPECT_EQ(hash, hil::build_simulation(hil::load_scenario(file, overrides))->get_model_hash());
      if (again == 0) {
        EXPECT_THAT(seen, testing::Not(testing::Contains(hash)));
      }
      seen.push_back(hash);
    }
  }
}

std::vector<std::uint64_t> to_bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> bits;
  for (const double value : values) bits.push_back(std::bit_cast<std::uint64_t>(value));
  return bits;
}

constexpr const char* kCampaigns[] = {"antenna/campaign.yaml", "array/campaign.yaml",   "boosters/campaign.yaml",
                                      "capsule/landing.yaml",  "fairing/campaign.yaml", "interstage/campaign.yaml"};

// A sample's analysis leaves out parts that its columns do not need; `unlatch run` requests all.
TEST(SampleEvaluator, GivesTheValuesOfAnAnalysisOfEverythingInEveryShippedCampaign) {
  for (const char* name : kCampaigns) {
    const hil::Campaign campaign = hil::load_campaign(std::string(UNLATCH_SOURCE_DIR) + "/hil/scenarios/" + name);
    const SampleEvaluator evaluator(*campaign.tree);
    const std::vector<Setting> settings = make_settings(campaign, draw_inputs(campaign, 1));
    const hil::Scenario scenario = campaign.tree->read(settings);
    const auto simulation = hil::build_simulation(scenario);
    hil::RunAnalysis everything(scenario, *simulation);
    const std::atomic<bool> stop{false};
    hil::run_fast(*simulation, everything, nullptr, hil::calc_nearest_tick(scenario.until, scenario.dt), stop, [] {});
    EXPECT_EQ(to_bits(evaluator.evaluate(settings).values),
              to_bits(collect_results(evaluator.columns(), scenario, everything)))
        << name;
  }
}

// Every output of the scenario: as a curve, at the end, and its extremes.
hil::ChosenOutputs choose_all(const hil::Scenario& scenario, int steps, std::size_t points) {
  hil::ChosenOutputs chosen;
  hil::ChosenCurves curves{{}, steps * scenario.dt, points};
  for (const hil::Output& output : list_outputs(scenario)) {
    for (const hil::Output::Column& column : output.columns) {
      curves.curves.push_back({column.name, column.unit});
      for (const auto take :
           {hil::ChosenOutput::Take::kFinal, hil::ChosenOutput::Take::kMin, hil::ChosenOutput::Take::kMax})
        chosen.values.push_back({column.name, column.unit, take});
    }
  }
  chosen.curves.push_back(std::move(curves));
  return chosen;
}

TEST(SampleEvaluator, GivesChosenOutputsAsTheRunWritesThemDown) {
  constexpr int kSteps = 100;
  constexpr std::size_t kPoints = 12;
  const ScenarioTree tree(kBoosters);
  const SampleEvaluator evaluator(tree, choose_all(tree.get_nominal(), kSteps, kPoints));
  const std::vector<Setting> settings = vary(2);
  const hil::Scenario scenario = tree.read(settings);
  const auto simulation = hil::build_simulation(scenario);
  std::vector<std::int64_t> every_tick;
  const std::int64_t last = hil::calc_nearest_tick(scenario.until, scenario.dt);
  for (std::int64_t tick = 0; tick <= last; ++tick) every_tick.push_back(tick);
  hil::RunOutputs written(scenario, *simulation, every_tick, {});
  hil::RunAnalysis analysis(scenario, *simulation);
  const std::atomic<bool> stop{false};
  hil::run_fast(*simulation, analysis, nullptr, last, stop, [&] { written.look(); });
  const auto& samples = written.get_samples();
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(last) + 1);

  const SampleResult result = evaluator.evaluate(settings);
  ASSERT_EQ(result.values.size(), evaluator.columns().size());
  const auto get = [&](const std::string& name) {
    const auto column = evaluator.find(name);
    EXPECT_TRUE(column) << name;
    return column ? result.values[*column] : 0;
  };
  std::size_t at = 0;
  for (const hil::Output& output : written.reader().list())
    for (const hil::Output::Column& column : output.columns) {
      double least = samples[0].values[at], greatest = least;
      for (const auto& sample : samples) {
        least = std::min(least, sample.values[at]);
        greatest = std::max(greatest, sample.values[at]);
      }
      EXPECT_EQ(get("output." + column.name + ".final"), samples.back().values[at]) << column.name;
      EXPECT_EQ(get("output." + column.name + ".min"), least) << column.name;
      EXPECT_EQ(get("output." + column.name + ".max"), greatest) << column.name;
      EXPECT_EQ(get("curve." + column.name + "@0"), samples[0].values[at]) << column.name;
      EXPECT_EQ(get("curve." + column.name + "@0.3"), samples[3 * kSteps].values[at]) << column.name;
      EXPECT_TRUE(std::isnan(get("curve." + column.name + "@1"))) << column.name;  // it ends at 0.9 s
      ++at;
    }
}

// Two balls part with 2 m/s from 0.8 m on. Nobody reads the third sensor, which costs a distance at each tick
// elsewhere.
TEST(SampleEvaluator, ComputesTheSensorsOfDistancesThatRequirementsAndOutputsRead) {
  const ScenarioTree tree = make_tree(R"(unlatch: 1
name: balls
step: {dt: 0.01, until: 0.5}
bodies:
  base: {mass: 1000, inertia: [9, 9, 9], shape: [{sphere: {radius: 100 mm}}]}
  ball: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0], velocity: [2, 0, 0], shape: [{sphere: {radius: 100 mm}}]}
sensors:
  gap: {type: distance, between: [base, ball]}
  other: {type: distance, between: [ball, base]}
  third: {type: distance, between: [ball, base]}
requirements:
  - {id: near, text: They part, sensor: {name: gap}, take: final, at_least: 1 m}
)");
  hil::ChosenOutputs chosen;
  chosen.values = {{"sensor.other", "m", hil::ChosenOutput::Take::kMax}};
  const SampleEvaluator evaluator(tree, chosen);
  const SampleResult result = evaluator.evaluate({});
  ASSERT_EQ(result.status, SampleStatus::kDone) << result.message;
  EXPECT_NEAR(result.values[*evaluator.find("near")], 1.8, 1e-12);
  EXPECT_NEAR(result.values[*evaluator.find("output.sensor.other.max")], 1.8, 1e-12);
}

TEST(SampleEvaluator, HasNoPointsAfterAFaultAndNoFinalValues) {
  const ScenarioTree tree = make_tree();
  hil::ChosenOutputs chosen = choose_all(tree.get_nominal(), 100, 11);
  const SampleEvaluator evaluator(tree, chosen);
  // A stiffness that no step resolves: the state overflows.
  const std::vector<Setting> settings{make_setting("elements.spring.stiffness", 1e12),
                                      hil::parse_setting("joints.nose.mode=free")};
  const SampleResult result = evaluator.evaluate(settings);
  ASSERT_EQ(result.status, SampleStatus::kFaulted) << result.message;
  const double end = static_cast<double>(result.ticks) * tree.get_nominal().dt;
  ASSERT_LT(end, 0.9);
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    const hil::ResultColumn& column = evaluator.columns()[i];
    if (column.kind == hil::ResultColumn::Kind::kCurve) {
      EXPECT_EQ(std::isnan(result.values[i]), 0.1 * static_cast<double>(column.part) > end) << column.name;
    }
    if (column.kind == hil::ResultColumn::Kind::kOutput) {
      EXPECT_EQ(std::isnan(result.values[i]), column.name.ends_with(".final")) << column.name;
    }
  }
}

TEST(SampleEvaluator, KnowsNoOutputThatTheSettingsTakeAway) {
  const ScenarioTree tree = make_tree();
  hil::ChosenOutputs chosen;
  chosen.values = {{"core.x", "m", hil::ChosenOutput::Take::kFinal}, {"gone.x", "m", hil::ChosenOutput::Take::kMax}};
  const SampleEvaluator evaluator(tree, chosen);
  const SampleResult result = evaluator.evaluate({});
  EXPECT_FALSE(std::isnan(result.values[*evaluator.find("output.core.x.final")]));
  EXPECT_TRUE(std::isnan(result.values[*evaluator.find("output.gone.x.max")]));
}

// Some end early, one is no valid scenario; the shipped campaigns with loops or flexible bodies run one by one.
TEST(SampleEvaluator, GivesSamplesSideBySideTheBitsOfEachAlone) {
  for (const char* name : kCampaigns) {
    const hil::Campaign campaign = hil::load_campaign(std::string(UNLATCH_SOURCE_DIR) + "/hil/scenarios/" + name);
    const SampleEvaluator evaluator(*campaign.tree, choose_all(campaign.tree->get_nominal(), 50, 30));
    std::vector<hil::SampleTask> tasks;
    for (int i = 0; i < 5; ++i) tasks.push_back({make_settings(campaign, draw_inputs(campaign, i))});
    tasks[1].run.until = 0.7;
    tasks[2].settings.push_back(hil::parse_setting("step.dt=-1"));
    const std::atomic<bool> stop{false};
    const std::vector<SampleResult> together = evaluator.evaluate(tasks, stop);
    ASSERT_EQ(together.size(), tasks.size());
    EXPECT_EQ(together[2].status, SampleStatus::kInvalid);
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      const SampleResult alone = evaluator.evaluate(tasks[i].settings, stop, tasks[i].run);
      EXPECT_EQ(together[i].status, alone.status) << name << i;
      EXPECT_EQ(together[i].message, alone.message) << name << i;
      EXPECT_EQ(together[i].ticks, alone.ticks) << name << i;
      EXPECT_EQ(together[i].hash, alone.hash) << name << i;
      EXPECT_EQ(together[i].model_hash, alone.model_hash) << name << i;
      const std::vector<std::uint64_t> a = to_bits(together[i].values), b = to_bits(alone.values);
      ASSERT_EQ(a.size(), b.size()) << name << i;
      for (std::size_t k = 0; k < a.size(); ++k) {
        EXPECT_EQ(a[k], b[k]) << name << i << " " << evaluator.columns()[k].name << ": " << together[i].values[k]
                              << " instead of " << alone.values[k];
      }
    }
  }
}

TEST(SampleEvaluator, AsksForPeaksOfReactionsOnlyWhereAColumnShowsOne) {
  const ScenarioTree tree(kBoosters);
  std::vector<hil::ResultColumn> columns = list_columns(tree.get_nominal());
  EXPECT_TRUE(list_needs(columns).reactions);
  EXPECT_FALSE(list_needs(columns).accuracy);
  std::erase_if(columns, [](const auto& column) { return column.kind == hil::ResultColumn::Kind::kPeak; });
  EXPECT_FALSE(list_needs(columns).reactions);
}

TEST(SampleEvaluator, KeepsNothingFromOneSampleToTheNext) {
  const ScenarioTree tree(kBoosters);
  const SampleEvaluator evaluator(tree);
  const std::vector<Setting> plain{hil::parse_setting("step.until=0.3")};
  const SampleResult before = evaluator.evaluate(plain);
  evaluate(evaluator, vary(3));
  const std::vector<Setting> wrong{make_setting("bodies.core.mass", -1.0)};
  EXPECT_EQ(evaluator.evaluate(wrong).status, SampleStatus::kInvalid);
  const SampleResult after = evaluator.evaluate(plain);
  EXPECT_EQ(before.hash, after.hash);
  EXPECT_EQ(before.model_hash, after.model_hash);
}

TEST(SampleEvaluator, ServesThreadsAtOnce) {
  const ScenarioTree tree(kBoosters);
  const SampleEvaluator evaluator(tree);
  constexpr int kThreads = 4;
  std::vector<Hashes> found(kThreads);
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < kThreads; ++k)
      threads.emplace_back([&, k] { found[static_cast<std::size_t>(k)] = evaluate(evaluator, vary(k)); });
  }
  for (int k = 0; k < kThreads; ++k) EXPECT_EQ(found[static_cast<std::size_t>(k)], evaluate(evaluator, vary(k)));
}

TEST(SampleEvaluator, TellsRequirementsEventsClearancesAndSeparations) {
  const ScenarioTree tree(kBoosters);
  const SampleEvaluator evaluator(tree);
  const SampleResult result = evaluator.evaluate({});
  ASSERT_EQ(result.values.size(), evaluator.columns().size());
  const auto get = [&](const std::string& name) {
    const auto column = evaluator.find(name);
    EXPECT_TRUE(column) << name;
    return column ? result.values[*column] : 0;
  };
  constexpr double kSixDigits = 5e-7;
  EXPECT_NEAR(get("event.release:booster1"), 0.665807, kSixDigits);  // interface of the reference case
  EXPECT_GT(get("event.liftoff:booster1"), get("event.contact:booster1"));
  EXPECT_EQ(get("distance1"), get("clearance.core.booster1"));
  EXPECT_EQ(get("distance1.margin"), get("distance1") - 1.0);
  EXPECT_GT(get("separation.nose1.along"), 1.0);
  EXPECT_EQ(get("tip_off.nose1"), get("separation.nose1.rate"));  // nothing pushes after the release
  EXPECT_LT(get("peak.nose1.x"), -1e5);
}

TEST(SampleEvaluator, ColumnsHaveTouchPeakAndImpulseOfContacts) {
  const ScenarioTree tree(std::string(UNLATCH_SOURCE_DIR) + "/hil/scenarios/boosters/recontact.yaml");
  const SampleEvaluator evaluator(tree);
  const SampleResult result = evaluator.evaluate({});
  ASSERT_EQ(result.status, SampleStatus::kDone) << result.message;
  std::size_t written = 0;
  for (const hil::ResultColumn& column : evaluator.columns())
    if (column.kind == hil::ResultColumn::Kind::kContact && column.name.ends_with(".touch")) {
      const std::string name = column.name.substr(0, column.name.size() - std::string(".touch").size());
      const auto get = [&](const char* value) { return result.values[*evaluator.find(name + value)]; };
      const bool struck = get(".peak") > 0;
      EXPECT_EQ(struck, get(".impulse") > 0) << name;
      EXPECT_EQ(struck, get(".depth") > 0) << name;
      EXPECT_EQ(struck, get(".duration") > 0) << name;
      EXPECT_EQ(struck, !std::isnan(get(".touch"))) << name;
      if (!struck) continue;
      ++written;
      // ∫ F_n dt lies between the peak's triangle and its rectangle.
      EXPECT_GT(get(".impulse"), 0.3 * get(".peak") * get(".duration")) << name;
      EXPECT_LT(get(".impulse"), get(".peak") * get(".duration")) << name;
    }
  EXPECT_GT(written, 0U);
}

TEST(SampleEvaluator, AnEventThatNeverCameHasNoTime) {
  const ScenarioTree tree(kBoosters);
  const SampleEvaluator evaluator(tree);
  const std::vector<Setting> early{hil::parse_setting("step.until=0.1")};
  const SampleResult result = evaluator.evaluate(early);
  EXPECT_TRUE(std::isnan(result.values[*evaluator.find("event.release:booster1")]));
  EXPECT_TRUE(std::isnan(result.values[*evaluator.find("tip_off.nose1")]));
}

TEST(SampleEvaluator, ColumnsKeepTheirMeaningWhenAnEventIsLeftOut) {
  const ScenarioTree tree(kBoosters);
  const SampleEvaluator evaluator(tree);
  const std::vector<Setting> dead{hil::parse_setting("events.contact:booster1.enabled=false")};
  const SampleResult result = evaluator.evaluate(dead);
  ASSERT_EQ(result.values.size(), evaluator.columns().size());
  EXPECT_TRUE(std::isnan(result.values[*evaluator.find("event.contact:booster1")]));
  EXPECT_NEAR(result.values[*evaluator.find("event.contact:booster2")], 0.77, 0.01);
}

TEST(SampleEvaluator, SettingsThatMakeNoScenarioAreAResultWithAllMistakes) {
  const ScenarioTree tree = make_tree();
  const SampleEvaluator evaluator(tree);
  const std::vector<Setting> wrong{make_setting("bodies.core.mass", -1.0), make_setting("bodies.booster.mass", 0.0)};
  const SampleResult result = evaluator.evaluate(wrong);
  EXPECT_EQ(result.status, SampleStatus::kInvalid);
  EXPECT_THAT(result.message, testing::HasSubstr("--set bodies.core.mass=-1"));
  EXPECT_THAT(result.message, testing::HasSubstr("--set bodies.booster.mass=0"));
}

TEST(Setting, TextReadsAsTheSameValue) {
  for (const char* text : {"bodies.core.mass=98000", "a.b[2]=-0.1", "e.direction=[1, -2e-05, 3.0000000000000004]",
                           "e.enabled=false", "e.profile={exponential: {initial: 3 kN, tau: 2*pi/3 rad}}",
                           "title=\"a \\\"b\\\": c, [d]\"", "x=- 1", "y=.5"}) {
    const Setting setting = hil::parse_setting(text);
    const std::string written = to_text(setting);
    EXPECT_EQ(to_text(hil::parse_setting(written)), written) << text;
    hil::YamlNode once = hil::parse_yaml("{}"), twice = once;
    apply_setting(setting, 0, once);
    apply_setting(hil::parse_setting(written), 0, twice);
    EXPECT_EQ(to_text(Setting{"x", once}), to_text(Setting{"x", twice})) << text;
  }
  EXPECT_EQ(to_text(make_setting("bodies.core.mass", 0.1)), "bodies.core.mass=0.1");
}

}  // namespace
}  // namespace unlatch::test::evaluation_test
