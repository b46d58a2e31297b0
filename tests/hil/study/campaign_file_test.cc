// Facts about campaign files: the values that they draw, and their mistakes, all at once with their places.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "hil/scenario/base/normal.h"
#include "hil/study/campaign/campaign.h"
#include "hil/study/campaign/samples/sample_record.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::campaign_file_test {
namespace {

namespace fs = std::filesystem;

using hil::Campaign;
using testing::ElementsAre;
using testing::HasSubstr;

class CampaignFileTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "s.yaml") << kGoodScenario;
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] Campaign load(const std::string& rest) const {
    return hil::load_campaign_text("unlatch_campaign: 1\nname: c\nscenario: s.yaml\n" + rest, "c.yaml",
                                   folder_.string());
  }
  // Returns the mistakes, one line each.
  [[nodiscard]] std::string load_errors(const std::string& rest) const {
    try {
      (void)load(rest);
      return "";
    } catch (const hil::ScenarioError& error) {
      return error.what();
    }
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / ("campaign_" + std::to_string(getpid()));
};

std::vector<std::string> list_names(const Campaign& campaign) {
  std::vector<std::string> names;
  for (const hil::CampaignParameter& parameter : campaign.parameters) names.push_back(parameter.name);
  return names;
}

TEST_F(CampaignFileTest, ErrorsOfSensorsTakeTheUnitsOfDataSheets) {
  constexpr double kDegree = 3.141592653589793 / 180;
  std::ofstream(folder_ / "s.yaml") << replaced(kGoodScenario, "gyro: {type: rate, body: core}",
                                                "gyro: {type: rate, body: core, errors: {noise_density: 0.1 deg/√h, "
                                                "drift: 2 deg/h}}");
  const Campaign campaign = load(
      "samples: 3\nparameters:\n  arw: {path: sensors.gyro.errors.noise_density, uniform: {min: 0.05 deg/√h, max: "
      "0.2 deg/sqrt(h)}}\n  drift: {path: sensors.gyro.errors.drift, normal: {mean: nominal, sigma: 10 %}}\n"
      "  rrw: {path: sensors.gyro.errors.walk, uniform: {min: 0, max: 1 deg/h/√h}}\n");
  EXPECT_DOUBLE_EQ(campaign.parameters[0].distribution.a, 0.05 * kDegree / 60);
  EXPECT_DOUBLE_EQ(campaign.parameters[0].distribution.b, 0.2 * kDegree / 60);
  EXPECT_EQ(campaign.parameters[0].unit, "rad/√s");
  EXPECT_EQ(campaign.parameters[0].shown->name, "deg/√h");
  EXPECT_DOUBLE_EQ(campaign.parameters[0].shown->factor, kDegree / 60);
  EXPECT_DOUBLE_EQ(campaign.parameters[1].distribution.a, 2 * kDegree / 3600);
  EXPECT_EQ(campaign.parameters[2].unit, "rad/s/√s");
  EXPECT_DOUBLE_EQ(campaign.parameters[2].distribution.b, kDegree / 3600 / 60);
  // The value that is drawn is that of the scenario, to the bit: √(x²) = x.
  const double drawn = hil::draw_inputs(campaign, 1)[0];
  const auto scenario = campaign.tree->read(hil::make_settings(campaign, hil::draw_inputs(campaign, 1)));
  EXPECT_EQ(scenario.rates.errors.sensors[0].noise_density, drawn);
  EXPECT_THAT(load_errors("samples: 3\nparameters:\n  arw: {path: sensors.gyro.errors.noise_density, uniform: {min: "
                          "0.05 deg/√h, max: 0.2 deg/h/√h}}\n"),
              HasSubstr("values of different kinds: rad/√s and rad/s/√s"));
}

TEST_F(CampaignFileTest, StarsMakeAParameterForEachEntryOrOneForAll) {
  const std::string parameter =
      "samples: 3\nparameters:\n  mass: {path: bodies.*.mass, normal: {mean: nominal, sigma: 1 %, within: 3}";
  const Campaign each = load(parameter + "}\n");
  EXPECT_THAT(list_names(each), ElementsAre("mass:core", "mass:booster"));
  EXPECT_EQ(each.parameters[1].distribution.a, 4500);  // nominal, in SI
  EXPECT_EQ(each.parameters[1].distribution.b, 45);
  const Campaign shared =
      load("samples: 3\nparameters:\n  delay: {path: events.*.delay, shared: true, uniform: {min: 0 s, max: 20 ms}}\n");
  EXPECT_THAT(list_names(shared), ElementsAre("delay"));
  EXPECT_THAT(shared.parameters[0].paths, ElementsAre("events.contact:booster.delay"));
}

TEST(CampaignFiles, EveryShippedOneLoads) {
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(UNLATCH_SOURCE_DIR "/hil/scenarios")) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".yaml" || !(name.starts_with("campaign") || name == "landing.yaml")) continue;
    ++count;
    EXPECT_NO_THROW(hil::load_campaign(entry.path().string())) << entry.path();
  }
  EXPECT_EQ(count, 10);
}

TEST_F(CampaignFileTest, ASampleDependsOnFileSeedAndNumberAlone) {
  const std::string text =
      "sampling: latin-hypercube\nsamples: 50\nparameters:\n  m: {path: bodies.core.mass, uniform: {min: 90 kg, max: "
      "110 kg}}\n";
  const Campaign a = load(text + "seed: 7\n"), b = load(text + "seed: 7\n"), other = load(text + "seed: 8\n");
  int differ = 0;
  for (std::int64_t i = 49; i >= 0; --i) {
    EXPECT_EQ(draw_inputs(a, i), draw_inputs(b, 49 - (49 - i)));
    differ += draw_inputs(a, i) != draw_inputs(other, i) ? 1 : 0;
  }
  EXPECT_GT(differ, 45);
}

TEST_F(CampaignFileTest, CorrelationsAreThoseOfTheNormalNumbers) {
  const Campaign campaign = load(
      "samples: 4000\nparameters:\n"
      "  a: {path: bodies.core.mass, normal: {mean: 100 kg, sigma: 1 kg, within: 8}}\n"
      "  b: {path: bodies.booster.mass, normal: {mean: 4 t, sigma: 1 %, within: 8}}\n"
      "  c: {path: elements.spring.stiffness, uniform: {min: 9, max: 11}}\n"
      "correlations:\n  - {between: [a, b], rho: 0.8}\n  - {between: [c, a], rho: -0.5}\n");
  double ab = 0, ac = 0, aa = 0;
  for (std::int64_t i = 0; i < 4000; ++i) {
    const std::vector<double> x = draw_inputs(campaign, i);
    const double a = (x[0] - 100) / 1, b = (x[1] - 4000) / 40, c = hil::calc_normal_quantile((x[2] - 9) / 2);
    ab += a * b / 4000;
    ac += a * c / 4000;
    aa += a * a / 4000;
  }
  constexpr double kChance = 0.05;  // three standard errors of 4,000 samples; the numbers are always the same
  EXPECT_NEAR(aa, 1, kChance);
  EXPECT_NEAR(ab, 0.8, kChance);
  EXPECT_NEAR(ac, -0.5, kChance);
}

TEST_F(CampaignFileTest, ADirectionStaysAUnitVectorInItsCone) {
  const Campaign campaign =
      load("samples: 100\nparameters:\n  axis: {path: elements.engine.direction, cone: {within: 2 deg}}\n");
  EXPECT_EQ(list_inputs(campaign).size(), 3u);
  for (std::int64_t i = 0; i < 100; ++i) {
    const std::vector<double> u = draw_inputs(campaign, i);
    EXPECT_NEAR(std::hypot(u[0], u[1], u[2]), 1, 1e-15);
    EXPECT_GE(u[0], std::cos(2 * 3.14159265358979 / 180) - 1e-15);
  }
  EXPECT_EQ(make_settings(campaign, draw_inputs(campaign, 0)).size(), 1u);
}

TEST_F(CampaignFileTest, ValuesThatAreNoNumbersAreChosenByTheirIndex) {
  const Campaign campaign = load(
      "samples: 20\nparameters:\n  mode: {path: joints.nose.mode, discrete: {values: [hinge, free], weights: [1, "
      "3]}}\n");
  int free = 0;
  for (std::int64_t i = 0; i < 20; ++i) {
    const auto settings = make_settings(campaign, draw_inputs(campaign, i));
    const std::string text = to_text(settings[0]);
    EXPECT_TRUE(text == "joints.nose.mode=hinge" || text == "joints.nose.mode=free") << text;
    free += text == "joints.nose.mode=free" ? 1 : 0;
  }
  EXPECT_GT(free, 10);
}

TEST_F(CampaignFileTest, RowsOfATableAreSamples) {
  std::ofstream(folder_ / "t.csv") << "other,m [kg]\n1,101\n2,102.5\n";
  const Campaign campaign = load("sampling: csv\ntable: t.csv\nparameters:\n  m: {path: bodies.core.mass}\n");
  EXPECT_EQ(campaign.plan.samples, 2);
  EXPECT_THAT(draw_inputs(campaign, 1), ElementsAre(102.5));
}

TEST_F(CampaignFileTest, ColumnsOfTablesAreReadInTheUnitsOfTheirHeadings) {
  const std::string rows = "sampling: csv\ntable: t.csv\nparameters:\n  m: {path: bodies.core.mass}\n";
  const std::string drawn =
      "samples: 2\nparameters:\n  m: {path: bodies.core.mass, empirical: {file: t.csv, column: m}}\n";
  for (const auto& [unit, size] : {std::pair{"", 1.0}, {" [kg]", 1.0}, {" [g]", 1e3}, {" [t]", 1e-3}}) {
    std::ofstream(folder_ / "t.csv") << "m" << unit << "\n" << 101 * size << "\n" << 102.5 * size << "\n";
    EXPECT_THAT(draw_inputs(load(rows), 1), ElementsAre(testing::DoubleEq(102.5))) << unit;
    const Campaign campaign = load(drawn);
    EXPECT_THAT(campaign.parameters[0].distribution.values,
                ElementsAre(testing::DoubleEq(101), testing::DoubleEq(102.5)))
        << unit;
    EXPECT_EQ(campaign.parameters[0].unit, "kg");
  }
  for (const auto& [unit, part] : {std::pair{"s", "'m' in s is of another kind than its values, in kg"},
                                   {"grams", "'grams' of 'm' is not a unit"}}) {
    std::ofstream(folder_ / "t.csv") << "m [" << unit << "]\n101\n102.5\n";
    EXPECT_THAT(load_errors(rows), HasSubstr(part));
    EXPECT_NE(load_errors(drawn), "");
  }
}

TEST_F(CampaignFileTest, AllMistakesAreToldAtOnceWithTheirPlaces) {
  const std::string errors = load_errors(
      "samples: 10.5\nsampling: sobols\nparameters:\n"
      "  a: {path: bodies.core.mass, normal: {mean: 100 kg, sigma: -1}}\n"
      "  b: {path: bodies.boster*.mass, uniform: {min: 1, max: 2}}\n"
      "  c: {path: elements.spring.stiffness, uniform: {min: 2, max: 1}, colour: red}\n");
  for (const char* part :
       {"c.yaml:4:10", "number of samples", "unknown sampling 'sobols'", "c.yaml:7", "sigma is below 0",
        "nothing in the scenario is met by 'bodies.boster*.mass'", "min is not below max", "unknown key 'colour'"})
    EXPECT_THAT(errors, HasSubstr(part));
}

// The table had two equal columns, of which statistics and plots took one.
TEST_F(CampaignFileTest, AParameterThatIsNamedLikeAResultIsAMistake) {
  const std::string mass = ": {path: bodies.core.mass, uniform: {min: 90, max: 110}}\n";
  const Campaign good = load("samples: 3\nparameters:\n  m" + mass);
  const std::vector<hil::ResultColumn> results = list_columns(good.tree->get_nominal(), good.chosen);
  ASSERT_FALSE(results.empty());
  std::ofstream(folder_ / "s.yaml")
      << kGoodScenario << "\nrequirements:\n  - {id: m, velocity: {body: core, along: [1, 0, 0]}, at_most: 9 km/s}\n";
  const std::string errors = load_errors("samples: 3\nparameters:\n  m" + mass);
  EXPECT_THAT(errors, HasSubstr("c.yaml:6"));
  EXPECT_THAT(errors, HasSubstr("'m' is a result of the scenario, such as a requirement, too"));
  EXPECT_THAT(errors, HasSubstr("give the parameter another name"));
  EXPECT_EQ(load_errors("samples: 3\nparameters:\n  mass" + mass), "");
}

TEST_F(CampaignFileTest, AValueThatBecomesUnphysicalIsAMistakeWithItsProbability) {
  const std::string errors =
      load_errors("samples: 10\nparameters:\n  m: {path: bodies.core.mass, normal: {mean: 100 kg, sigma: 50 %}}\n");
  EXPECT_THAT(errors, HasSubstr("probability of 0.0228"));  // Φ(−2)
  EXPECT_THAT(errors, HasSubstr("within: 3"));
  EXPECT_EQ(
      load_errors("samples: 10\nparameters:\n  m: {path: bodies.core.mass, normal: {mean: 100 kg, sigma: 5 %}}\n"), "");
}

TEST_F(CampaignFileTest, ValuesThatClashTogetherAreAMistake) {
  std::string text = "samples: 10\nparameters:\n";
  for (const char* k : {"0", "1", "2"})
    text += std::string("  i") + k + ": {path: 'bodies.core.inertia[" + k + "]', uniform: {min: 12, max: 26}}\n";
  EXPECT_THAT(load_errors(text), HasSubstr("together"));  // 12 + 12 < 26 at a corner: the triangle's inequality
}

// The first and the last value, and so the median, are valid.
TEST_F(CampaignFileTest, EveryDiscreteValueIsTriedWithItsWeight) {
  const std::string errors = load_errors(
      "samples: 40\nparameters:\n  m: {path: bodies.core.mass, discrete: {values: [1 kg, -5 kg, 2 kg, 3 kg], weights: "
      "[3, 1, 4, 2]}}\n");
  EXPECT_THAT(errors, HasSubstr("'m' becomes unusable with a probability of 0.1"));
  EXPECT_THAT(errors, HasSubstr("leave out what makes no valid scenario: -5"));
  EXPECT_EQ(load_errors("samples: 40\nparameters:\n  m: {path: bodies.core.mass, discrete: {values: [1 kg, -5 kg, 2 "
                        "kg], weights: [3, 0, 4]}}\n"),
            "");  // never drawn
  const std::string words = load_errors(
      "samples: 9\nparameters:\n  mode: {path: joints.nose.mode, discrete: {values: [hinge, free, shut]}}\n");
  EXPECT_THAT(words, HasSubstr("probability of 0.333"));
  EXPECT_THAT(words, HasSubstr("shut"));
}

TEST_F(CampaignFileTest, ACorrelatedDiscreteValueIsTriedToo) {
  EXPECT_THAT(
      load_errors("samples: 40\nparameters:\n  b: {path: bodies.booster.mass, uniform: {min: 4000, max: 5000}}\n"
                  "  m: {path: bodies.core.mass, discrete: {values: [1 kg, 2 kg, -5 kg], weights: [45, 45, "
                  "10]}}\ncorrelations:\n  - {between: [b, m], rho: 0.99}\n"),
      HasSubstr("probability of 0.1"));
}

TEST_F(CampaignFileTest, ValuesThatClashInsideAreAMistakeWithAnEstimatedProbability) {
  std::string text = "samples: 10\nparameters:\n";
  for (const char* k : {"0", "1", "2"})
    text += std::string("  i") + k + ": {path: 'bodies.core.inertia[" + k + "]', uniform: {min: 12, max: 26}}\n";
  const std::string errors = load_errors(text);
  // P(a + b < c) is 3 times the volume (2/14)^3 / 6: 0.0015, of which 400 draws hardly see one.
  EXPECT_THAT(errors, testing::ContainsRegex("with a probability (below|of some) 0.00[0-9]+ "));
  EXPECT_THAT(errors, HasSubstr("of 400 draws)"));
  const std::string often = load_errors(
      "samples: 10\nparameters:\n  a: {path: 'bodies.core.inertia[0]', uniform: {min: 6, max: 14}}\n"
      "  b: {path: 'bodies.core.inertia[1]', uniform: {min: 16, max: 24}}\n");  // a + b < 25: 4.5 / 64
  EXPECT_THAT(often, HasSubstr("make no valid scenario, with a probability of some 0.0"));
}

TEST_F(CampaignFileTest, APairIsCorrelatedOnce) {
  const std::string parameters =
      "samples: 10\nparameters:\n  m: {path: bodies.core.mass, uniform: {min: 90, max: 110}}\n"
      "  v: {path: bodies.booster.mass, uniform: {min: 4000, max: 5000}}\ncorrelations:\n"
      "  - {between: [m, v], rho: 0.9}\n";
  EXPECT_EQ(load_errors(parameters), "");
  EXPECT_THAT(load_errors(parameters + "  - {between: [v, m], rho: -0.9}\n"),
              HasSubstr("the correlation of 'v' and 'm' is given twice"));
}

TEST_F(CampaignFileTest, LevelsOfAParameterAreAWholeNumberFromTwo) {
  for (const char* levels : {"2.5", "1", "1e300", "-3", "0"})
    EXPECT_THAT(load_errors("sampling: grid\nparameters:\n  m: {path: bodies.core.mass, levels: " +
                            std::string(levels) + ", uniform: {min: 90, max: 110}}\n"),
                HasSubstr("this number of levels is not usable"))
        << levels;
}

TEST_F(CampaignFileTest, SamplesOfSobolThatAreNoPowerOfTwoAreANote) {
  const std::string rest =
      "set: {flight_software.required: []}\nsampling: sobol\nparameters:\n"
      "  m: {path: bodies.core.mass, uniform: {min: 90, max: 110}}\n";
  EXPECT_THAT(load("samples: 100\n" + rest).remarks, ElementsAre(HasSubstr("64 or 128, not 100")));
  EXPECT_THAT(load("samples: 128\n" + rest).remarks, ElementsAre());
}

TEST_F(CampaignFileTest, ATableMayBeLargerThanAScenario) {
  const std::string rest = "sampling: csv\ntable: big.csv\nsamples: 2\nparameters:\n  m: {path: bodies.core.mass}\n";
  {
    std::ofstream file(folder_ / "big.csv");
    file << "m,comment\n101,0\n102,0\n";
    for (int i = 0; i < 150; ++i) file << "103," << std::string(10'000, '0') << "\n";  // 1.5 MB
  }
  EXPECT_EQ(load_errors(rest), "");
  fs::resize_file(folder_ / "big.csv", (std::uintmax_t{256} << 20) + 1);  // sparse
  EXPECT_THAT(load_errors(rest), HasSubstr("more than 256 MiB; a table file has at most"));
}

TEST_F(CampaignFileTest, OutputsAndCurvesBecomeColumns) {
  const Campaign campaign = load(
      "samples: 3\nparameters:\n  m: {path: bodies.core.mass, uniform: {min: 90, max: 110}}\n"
      "outputs:\n  - {of: core.velocity}\n  - {of: [core.vx, \"sensor.gyro\"], take: max}\n"
      "curves:\n  - {of: nose.angle.y, every: 250 ms}\n  - {of: core.x, every: 0.5}\n");
  std::vector<std::string> names;
  for (const hil::ResultColumn& column : list_columns(campaign.chosen))
    names.push_back(column.name + (column.unit.empty() ? "" : " " + column.unit));
  EXPECT_THAT(names,
              ElementsAre("output.core.vx.final m/s", "output.core.vy.final m/s", "output.core.vz.final m/s",
                          "output.core.vx.max m/s", "output.sensor.gyro.x.max rad/s", "output.sensor.gyro.y.max rad/s",
                          "output.sensor.gyro.z.max rad/s", "curve.nose.angle.y@0 rad", "curve.nose.angle.y@0.25 rad",
                          "curve.nose.angle.y@0.5 rad", "curve.nose.angle.y@0.75 rad", "curve.nose.angle.y@1 rad",
                          "curve.core.x@0 m", "curve.core.x@0.5 m", "curve.core.x@1 m"));
  EXPECT_EQ(campaign.chosen.count(), names.size());
}

TEST_F(CampaignFileTest, MistakesOfOutputsAndCurvesAreTold) {
  const std::string parameters =
      "samples: 3\nparameters:\n  m: {path: bodies.core.mass, uniform: {min: 90, max: 110}}\n";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"outputs: [{of: core.vq}]", "no output 'core.vq'"},
           {"outputs: [{of: core.vq}]", "did you mean 'core.vx'"},
           {"outputs: [{of: core.velocty}]", "did you mean 'core.velocity'"},
           {"outputs: [{of: \"boster.*\"}]", "no output 'boster.*'"},
           {"outputs: [{of: core.vx, take: mean}]", "unknown way to take an output 'mean'"},
           {"outputs: [{of: [core.vx, core.velocity]}]", "'core.vx' is chosen twice"},
           {"outputs: [{of: []}]", "no outputs are named"},
           {"outputs: [{take: max}]", "of"},
           {"outputs: core.vx", "outputs is not a list"},
           {"curves: {of: core.vx, every: 1 s}", "curves is not a list"},
           {"curves: [{of: core.vx}]", "every"},
           {"curves: [{of: core.vx, every: 1.5 ms}]", "not a whole number of steps of 0.001 s"},
           {"curves: [{of: core.vx, every: 0 s}]", "not a whole number of steps"},
           {"curves: [{of: core.vx, every: -1 s}]", "not a whole number of steps"},
           {"curves: [{of: core.vx, every: 1e300}]", "not a whole number of steps"},
           {"curves: [{of: core.vx, every: 2 s}]", "the run is shorter: it ends at 1 s"},
           {"curves: [{of: core.vx, every: 1 m}]", "is a length"},
           {"curves: [{of: core.vx, every: 1 s}, {of: core.velocity, every: 0.5 s}]", "'core.vx' has two curves"},
           {"curves: [{of: \"*\", every: 1 ms}]", "columns; at most 4096 fit into a table"}})
    EXPECT_THAT(load_errors(parameters + text + "\n"), HasSubstr(message)) << text;
}

TEST_F(CampaignFileTest, ARareFailureMayBeOfAnOutput) {
  const Campaign campaign = load(
      "sampling: subset\nsamples: 500\nsubset: {of: output.core.vx.max, above: 2 km/s}\noutputs: [{of: core.vx, take: "
      "max}]\nparameters:\n  m: {path: bodies.core.mass, uniform: {min: 90 kg, max: 110 kg}}\n");
  ASSERT_TRUE(campaign.failure);
  EXPECT_EQ(campaign.failure->limit, 2000);
  EXPECT_EQ(campaign.failure->column_index, list_columns(campaign.tree->get_nominal()).size());
}

// Versions and physics are distinguished, although all texts are the same: their records must not be mixed.
TEST_F(CampaignFileTest, ResultsOfAnotherVersionOrPhysicsHaveAnotherShape) {
  const Campaign campaign =
      load("samples: 3\nparameters:\n  m: {path: bodies.core.mass, uniform: {min: 90, max: 110}}\n");
  const hil::SampleEvaluator evaluator(*campaign.tree);
  EXPECT_EQ(get_shape(campaign, evaluator), get_shape(campaign, evaluator));
  EXPECT_NE(get_shape(campaign, evaluator), get_shape(campaign, evaluator, "unlatch 0.0.1"));
  const hil::ScenarioTree other(campaign.scenario, {"elements.engine.profile=6 kN"});
  EXPECT_NE(get_shape(campaign, evaluator), get_shape(campaign, hil::SampleEvaluator(other)));
}

TEST_F(CampaignFileTest, AUnitOfAnotherKindIsAMistake) {
  EXPECT_THAT(
      load_errors("samples: 10\nparameters:\n  m: {path: bodies.core.mass, uniform: {min: 90 m, max: 110 m}}\n"),
      HasSubstr("is a length"));
}

// Expressions use a constant by its dimension: a value without its unit would make `5 * gap` no length.
TEST_F(CampaignFileTest, AConstantKeepsItsUnit) {
  const auto give = [&](const char* text) {
    std::ofstream(folder_ / "s.yaml") << "constants: {gap: " << text << "}\n"
                                      << replaced(kGoodScenario, "free_length: 1", "free_length: 5 * gap");
  };
  std::ofstream(folder_ / "t.csv") << "gap\n0.25\n";
  const std::vector<std::pair<std::string, double>> plans{
      {"sampling: grid\nlevels: 2\nparameters:\n  gap: {path: constants.gap, uniform: {min: 100 mm, max: 300 mm}}\n",
       0.15},
      {"sampling: grid\nlevels: 2\nparameters:\n  gap: {path: constants.gap, uniform: {min: 0.1, max: 0.3}}\n", 0.15},
      {"samples: 1\nparameters:\n  gap: {path: constants.gap, discrete: {values: [0.125 m]}}\n", 0.125},
      {"samples: 1\nparameters:\n  gap: {path: constants.gap, normal: {mean: nominal, sigma: 0}}\n", 0.2},
      {"sampling: csv\ntable: t.csv\nparameters:\n  gap: {path: constants.gap}\n", 0.25}};
  for (const auto& [text, gap] : plans) {
    SCOPED_TRACE(text);
    const bool plain = text.find("0.1,") != std::string::npos || text.find("csv") != std::string::npos;
    give("20 cm");
    EXPECT_THAT(load_errors(text), plain ? HasSubstr("a plain number for 'constants.gap'") : HasSubstr(""));
    EXPECT_EQ(load_errors(text).empty(), !plain);
    give("0.2 m");
    ASSERT_EQ(load_errors(text), "");
    const Campaign campaign = load(text);
    const std::vector<double> inputs = draw_inputs(campaign, 0);
    EXPECT_NEAR(inputs[0], gap, 1e-15);
    EXPECT_EQ(list_inputs(campaign)[0].unit, "m");
    const auto settings = make_settings(campaign, inputs);
    EXPECT_EQ(to_text(settings[0]), "constants.gap=" + hil::to_text(inputs[0]) + " m");
    EXPECT_EQ(campaign.tree->read(settings).constants[0].value.value, inputs[0]);  // the same bits
  }
}

TEST_F(CampaignFileTest, ARareFailureHasItsColumnItsLimitAndItsLevels) {
  const std::string parameters = "parameters:\n  m: {path: bodies.core.mass, uniform: {min: 90 kg, max: 110 kg}}\n";
  const Campaign campaign = load(
      "sampling: subset\nsamples: 500\nsubset: {of: clearance.core.booster, below: 50 mm, "
      "part: 20 %, levels: 4, at_most: 1e-3}\n" +
      parameters);
  ASSERT_TRUE(campaign.failure);
  EXPECT_EQ(campaign.failure->column, "clearance.core.booster");
  EXPECT_EQ(campaign.failure->limit, 0.05);
  EXPECT_EQ(campaign.failure->chains, 100);
  EXPECT_EQ(campaign.failure->at_most, 1e-3);
  EXPECT_EQ(campaign.plan.samples, 500 + 3 * 400);
  EXPECT_THROW((void)draw_inputs(campaign, 500), std::out_of_range);
  for (const auto& [subset, message] : std::vector<std::pair<std::string, std::string>>{
           {"of: clearance.core.booster", "no requirement 'clearance.core.booster', and no limit"},
           {"of: clearance.core.boster, below: 0 m", "did you mean 'clearance.core.booster'"},
           {"of: clearance.core.booster, below: 1 kg", "is a mass"},
           {"of: clearance.core.booster, below: 0 m, above: 1 m", "below and above"},
           {"of: clearance.core.booster, below: 0 m, part: 0.3", "this part is not usable"},
           {"of: clearance.core.booster, below: 0 m, part: 1/7", "a multiple of 7"},
           {"of: clearance.core.booster, below: 0 m, levels: 2.5", "this number of levels is not usable"},
           {"of: clearance.core.booster, below: 0 m, at_most: 2", "this probability is not usable"},
           {"below: 0 m", "of"}})
    EXPECT_THAT(load_errors("sampling: subset\nsamples: 500\nsubset: {" + subset + "}\n" + parameters),
                HasSubstr(message))
        << subset;
  EXPECT_THAT(load_errors("sampling: subset\nsamples: 500\n" + parameters), HasSubstr("subset"));
  EXPECT_THAT(load_errors("samples: 500\nsubset: {of: clearance.core.booster, below: 0 m}\n" + parameters),
              HasSubstr("without `sampling: subset`"));
}

TEST_F(CampaignFileTest, CorrelationsThatContradictEachOtherAreAMistake) {
  const std::string errors = load_errors(
      "samples: 10\nparameters:\n  a: {path: bodies.core.mass, uniform: {min: 90, max: 110}}\n"
      "  b: {path: bodies.booster.mass, uniform: {min: 4000, max: 5000}}\n  c: {path: elements.spring.stiffness, "
      "uniform: {min: 9, max: 11}}\n"
      "correlations:\n  - {between: [a, b], rho: 0.9}\n  - {between: [b, c], rho: 0.9}\n  - {between: [a, c], rho: "
      "-0.9}\n");
  EXPECT_THAT(errors, HasSubstr("contradict"));
}

}  // namespace
}  // namespace unlatch::test::campaign_file_test
