// Errors of sensors: Allan deviations beside the closed forms of each process, units of data sheets, the same bits in
// any order.
#include "hil/scenario/sensor_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "hil/scenario/rates.h"
#include "hil/scenario/scenario.h"
#include "tests/hil/scenario/scenario_support.h"
#include "tests/support/small_models.h"

namespace unlatch::test::sensor_errors_test {
namespace {

constexpr double kDt = 0.001;  // s

// A body with a rate sensor (three values), an attitude sensor and a signal.
Model build_model() {
  Model model;
  model.name = "craft";
  model.bodies.push_back(box("craft", 1, 1, 1, 1));
  model.signals.push_back("wire");
  Sensor gyro;
  gyro.name = "gyro";
  model.sensors.push_back(gyro);
  Sensor tracker;
  tracker.name = "tracker";
  tracker.kind = Sensor::Kind::kAttitude;
  model.sensors.push_back(tracker);
  Sensor wire;
  wire.name = "wire";
  wire.kind = Sensor::Kind::kContact;
  model.sensors.push_back(wire);
  return model;
}
const std::vector<double> kTruth{0.1, -0.2, 0.3, 1, 0, 0, 0, 1};

hil::Rates with_errors(hil::SensorErrors errors, std::int64_t every = 1, std::uint64_t seed = 1) {
  hil::Rates rates;
  rates.groups.push_back({"navigation", {every, 0}, {}, {errors.sensor}});
  rates.errors = {{std::move(errors)}, seed, kDt};
  return rates;
}

// The first value of the gyro less its true one at each sample.
std::vector<double> record(const hil::Rates& rates, std::size_t samples) {
  const Model model = build_model();
  hil::SampleAndHold held(model, rates, {}, kTruth);
  const std::int64_t every = rates.groups[0].rate.every;
  std::vector<double> errors{held.get_sensors()[0] - kTruth[0]};
  for (std::int64_t tick = 1; errors.size() < samples; ++tick) {
    held.sample(tick, kTruth);
    if (tick % every == 0) errors.push_back(held.get_sensors()[0] - kTruth[0]);
  }
  return errors;
}

// Overlapping Allan deviation over m samples (IEEE Std 952-2020, annex C).
double calc_allan(const std::vector<double>& values, std::size_t m) {
  std::vector<double> sums{0};
  for (const double value : values) sums.push_back(sums.back() + value);
  double total = 0;
  const std::size_t count = values.size() - 2 * m;
  for (std::size_t k = 0; k < count; ++k) {
    const double difference = sums[k + 2 * m] - 2 * sums[k + m] + sums[k];
    total += difference * difference;
  }
  return std::sqrt(total / (2.0 * static_cast<double>(m * m) * static_cast<double>(count)));
}

// Relative error of an Allan deviation over m of n samples: 1 / sqrt(2 (n/m − 1)), three of them.
double calc_three_sigma(std::size_t n, std::size_t m) {
  return 3 / std::sqrt(2 * (static_cast<double>(n) / static_cast<double>(m) - 1));
}

constexpr std::size_t kSamples = 200000;
constexpr std::int64_t kEvery = 10;
constexpr double kPeriod = kDt * kEvery;

TEST(SensorErrors, WhiteNoiseHasItsDensityAtAllTimes) {
  constexpr double kDensity = 0.05 * std::numbers::pi / 180 / 60;  // 0.05 deg/√h
  const std::vector<double> errors = record(with_errors({.sensor = 0, .noise_density = kDensity}, kEvery), kSamples);
  for (const std::size_t m : {1u, 10u, 100u, 1000u})
    EXPECT_NEAR(calc_allan(errors, m) * std::sqrt(static_cast<double>(m) * kPeriod) / kDensity, 1,
                calc_three_sigma(kSamples, m))
        << m;
}

TEST(SensorErrors, ARandomWalkGrowsWithTheRootOfTheTime) {
  constexpr double kWalk = 1e-4;
  const std::vector<double> errors = record(with_errors({.sensor = 0, .walk = kWalk}, kEvery), kSamples);
  // K √(τ/3); of sampled steps (2 m² + 1)/(2 m²) of its square
  for (const std::size_t m : {10u, 100u, 1000u}) {
    const double tau = static_cast<double>(m) * kPeriod;
    EXPECT_NEAR(calc_allan(errors, m) / (kWalk * std::sqrt(tau / 3)), 1, calc_three_sigma(kSamples, m) + 0.01) << m;
  }
}

TEST(SensorErrors, ADriftHasItsSizeAndItsTime) {
  constexpr double kDrift = 2e-3, kTime = 0.5;
  const std::vector<double> errors =
      record(with_errors({.sensor = 0, .drift = kDrift, .drift_time = kTime}, kEvery), kSamples);
  double square = 0, neighbours = 0;
  constexpr std::size_t kLag = 50;  // one correlation time
  for (std::size_t i = 0; i + kLag < errors.size(); ++i) {
    square += errors[i] * errors[i];
    neighbours += errors[i] * errors[i + kLag];
  }
  const double independent = static_cast<double>(kSamples) * kPeriod / (2 * kTime);
  EXPECT_NEAR(square / static_cast<double>(kSamples - kLag) / (kDrift * kDrift), 1, 4 * std::sqrt(2 / independent));
  EXPECT_NEAR(neighbours / square, std::exp(-1.0), 4 / std::sqrt(independent));
}

TEST(SensorErrors, FixedErrorsAreThoseOfTheFormula) {
  hil::SensorErrors errors{.sensor = 0, .bias = {0.01, 0.02, 0.03}, .scale = 0.5, .misalignment = {0, 0, 0.1}};
  const Model model = build_model();
  const hil::SampleAndHold held(model, with_errors(errors), {}, kTruth);
  // x − m × x with m = (0, 0, 0.1): (0.1 − 0.02, −0.2 − 0.01, 0.3)
  const double wanted[] = {1.5 * 0.08 + 0.01, 1.5 * -0.21 + 0.02, 1.5 * 0.3 + 0.03};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(held.get_sensors()[i], wanted[i], 1e-15);
}

TEST(SensorErrors, ValuesAreRoundedAndLimited) {
  const Model model = build_model();
  const hil::SampleAndHold rounded(model, with_errors({.sensor = 0, .quantum = 0.04}), {}, kTruth);
  EXPECT_THAT(std::vector<double>(rounded.get_sensors().begin(), rounded.get_sensors().begin() + 3),
              testing::ElementsAre(testing::DoubleEq(0.12), testing::DoubleEq(-0.2), testing::DoubleEq(0.32)));
  const hil::SampleAndHold limited(model, with_errors({.sensor = 0, .range = 0.15}), {}, kTruth);
  EXPECT_THAT(std::vector<double>(limited.get_sensors().begin(), limited.get_sensors().begin() + 3),
              testing::ElementsAre(0.1, -0.15, 0.15));
}

TEST(SensorErrors, ASaturatedConverterSendsItsLargestCodeWithinTheRange) {
  const Model model = build_model();
  const auto send = [&](double bias, double quantum, double range) {
    const hil::SampleAndHold held(
        model, with_errors({.sensor = 0, .bias = {bias, -bias, 0}, .quantum = quantum, .range = range}), {}, kTruth);
    return std::vector<double>(held.get_sensors().begin(), held.get_sensors().begin() + 3);
  };
  EXPECT_THAT(send(9, 2, 5), testing::ElementsAre(4, -4, 0));
  EXPECT_THAT(send(4.9, 2, 5), testing::ElementsAre(4, -4, 0));  // the nearest multiple, 6, is beyond it
  EXPECT_THAT(send(9, 0.05, 5), testing::ElementsAre(5, -5, testing::DoubleEq(0.3)));  // 0.05 is no binary number
  EXPECT_THAT(send(9, 0.1, 0.3),
              testing::ElementsAre(testing::DoubleEq(0.3), testing::DoubleEq(-0.3), testing::DoubleEq(0.3)));
  for (const double value : send(9, 1e-300, 5)) EXPECT_TRUE(std::isfinite(value));
}

TEST(SensorErrors, DelayedSamplesComeInOrder) {
  const Model model = build_model();
  hil::SampleAndHold held(model, with_errors({.sensor = 0, .delay = 3}, 2), {}, kTruth);
  for (std::int64_t tick = 1; tick <= 40; ++tick) {
    std::vector<double> truth = kTruth;
    truth[0] = static_cast<double>(tick);
    held.sample(tick, truth);
    const std::int64_t sampled = tick / 2 * 2 - 6;
    EXPECT_EQ(held.get_sensors()[0], sampled <= 0 ? 0.1 : static_cast<double>(sampled)) << tick;
  }
}

TEST(SensorErrors, LostSamplesAreHeldAndAsManyAsSaid) {
  const Model model = build_model();
  hil::SampleAndHold held(model, with_errors({.sensor = 0, .dropout = 0.2}), {}, kTruth);
  int lost = 0;
  constexpr int kTicks = 20000;
  double last = 0.1;
  for (std::int64_t tick = 1; tick <= kTicks; ++tick) {
    std::vector<double> truth = kTruth;
    truth[0] = static_cast<double>(tick);
    held.sample(tick, truth);
    const double now = held.get_sensors()[0];
    if (now == last)
      ++lost;
    else
      EXPECT_EQ(now, static_cast<double>(tick));
    last = now;
  }
  EXPECT_NEAR(lost, 0.2 * kTicks, 4 * std::sqrt(0.2 * 0.8 * kTicks));
}

TEST(SensorErrors, AnAttitudeIsTurnedAndStaysOfLengthOne) {
  const Model model = build_model();
  hil::SensorErrors errors{.sensor = 1, .bias = {0, 0, 0.02}};
  const hil::SampleAndHold held(model, with_errors(errors), {}, kTruth);
  const std::span<const double> q = held.get_sensors().subspan(3, 4);
  EXPECT_NEAR(2 * std::atan2(q[3], q[0]), 0.02, 1e-15);
  EXPECT_NEAR(q[0] * q[0] + q[3] * q[3], 1, 1e-15);
}

// The quaternion that is sent of an attitude that is turned by a rotation vector from the axes of W.
std::vector<double> send_turned(const std::vector<double>& turn) {
  const Model model = build_model();
  const hil::SampleAndHold held(model, with_errors({.sensor = 1, .bias = turn}), {}, kTruth);
  return {held.get_sensors().begin() + 3, held.get_sensors().begin() + 7};
}

TEST(SensorErrors, AnAttitudeIsTurnedByExactlyTheRotationVector) {
  for (const double size : {1e-9, 1e-5, 1.9e-4, 2.1e-4, 1e-2, 1.0, 3.0, 10.0}) {
    const double length = size * std::sqrt(0.01 + 0.04 + 0.09);
    const std::vector<double> q = send_turned({0.1 * size, -0.2 * size, 0.3 * size});
    const double part = std::sin(0.5 * length) / length;  // of the vector
    const double wanted[] = {std::cos(0.5 * length), 0.1 * size * part, -0.2 * size * part, 0.3 * size * part};
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(q[i], wanted[i], 1e-15 * (i == 0 ? 1 : std::abs(wanted[i]))) << size << ' ' << i;
  }
  EXPECT_EQ(send_turned({0, 0, 0}), (std::vector<double>{1, 0, 0, 0}));
}

// Close to the size below which the sine is its series.
TEST(SensorErrors, TheTurnOfAnAttitudeHasNoJumpWhereItBecomesSmall) {
  double last = 0;
  for (int i = -50; i <= 50; ++i) {
    const double turn = 2e-4 * (1 + i * 1e-15), z = send_turned({0, 0, turn})[3];
    EXPECT_GE(z, last) << i;
    EXPECT_NEAR(z, std::sin(0.5 * turn), 3e-20) << i;
    last = z;
  }
}

TEST(SensorErrors, FromSavedMemoryTheSameBitsFollow) {
  const Model model = build_model();
  const hil::Rates rates = with_errors(
      {.sensor = 0, .turn_on = 0.1, .noise = 0.1, .walk = 0.1, .drift = 0.1, .dropout = 0.1, .delay = 2}, 2);
  hil::SampleAndHold whole(model, rates, {}, kTruth), other(model, rates, {}, kTruth);
  for (std::int64_t tick = 1; tick <= 500; ++tick) whole.sample(tick, kTruth);
  const std::vector<double> sensors(whole.get_sensors().begin(), whole.get_sensors().end());
  const std::vector<double> memory(whole.get_memory().begin(), whole.get_memory().end());
  other.restore({}, sensors, memory);
  for (std::int64_t tick = 501; tick <= 1000; ++tick) {
    whole.sample(tick, kTruth);
    other.sample(tick, kTruth);
    for (std::size_t i = 0; i < kTruth.size(); ++i) ASSERT_EQ(whole.get_sensors()[i], other.get_sensors()[i]) << tick;
  }
}

TEST(SensorErrors, SeedsValuesAndSensorsAreIndependent) {
  const std::vector<double> a = record(with_errors({.sensor = 0, .noise = 1}, 1, 1), 20000);
  const std::vector<double> b = record(with_errors({.sensor = 0, .noise = 1}, 1, 2), 20000);
  double together = 0;
  for (std::size_t i = 0; i < a.size(); ++i) together += a[i] * b[i];
  EXPECT_LT(std::abs(together / 20000), 4 / std::sqrt(20000.0));
}

// A sensor of the same name at another place of the model has the same numbers, one of another name has not.
TEST(SensorErrors, NumbersFollowFromTheNameOfTheSensorAlone) {
  Model model = build_model();
  Sensor other = model.sensors[0];
  other.name = "other";
  model.sensors.insert(model.sensors.begin(), other);
  std::vector<double> truth{0.1, -0.2, 0.3};
  truth.insert(truth.end(), kTruth.begin(), kTruth.end());
  const std::uint64_t gyro = hil::calc_name_hash("gyro"), name = hil::calc_name_hash("other");
  hil::Rates rates = with_errors({.sensor = 0, .name = name, .noise = 1, .walk = 1, .drift = 1}, 2);
  rates.errors.sensors.push_back({.sensor = 1, .name = gyro, .noise = 1, .walk = 1, .drift = 1});
  rates.groups[0].sensors.push_back(1);
  hil::SampleAndHold both(model, rates, {}, truth);
  hil::SampleAndHold alone(build_model(),
                           with_errors({.sensor = 0, .name = gyro, .noise = 1, .walk = 1, .drift = 1}, 2), {}, kTruth);
  int equal = 0;
  for (std::int64_t tick = 1; tick <= 100; ++tick) {
    both.sample(tick, truth);
    alone.sample(tick, kTruth);
    for (std::size_t i = 0; i < 3; ++i) ASSERT_EQ(both.get_sensors()[3 + i], alone.get_sensors()[i]) << tick;
    equal += both.get_sensors()[0] == both.get_sensors()[3] ? 1 : 0;
  }
  EXPECT_EQ(equal, 0);
}

// FNV-1a's published values: "" and "foobar" (draft-eastlake-fnv, appendix).
TEST(SensorErrors, NamesAreHashedByTheirPublishedFunction) {
  EXPECT_EQ(hil::calc_name_hash(""), 0xcbf29ce484222325u);
  EXPECT_EQ(hil::calc_name_hash("foobar"), 0x85944171f73967e8u);
}

TEST(SensorErrors, AStepOfHalfTheSizeGivesASensorWithAPeriodTheSameNumbers) {
  const hil::SensorErrors errors{.sensor = 0, .noise = 0.1, .walk = 0.1, .drift = 0.1, .dropout = 0.1};
  hil::Rates fine = with_errors(errors, 8);
  fine.errors.dt = kDt / 2;
  const std::vector<double> coarse = record(with_errors(errors, 4), 1000), again = record(fine, 1000);
  for (std::size_t i = 0; i < coarse.size(); ++i) EXPECT_DOUBLE_EQ(coarse[i], again[i]) << i;
}

// --- The language
// ------------------------------------------------------------------------------------------------------

hil::Scenario load(const std::string& errors) {
  std::string text = kGoodScenario;
  const std::string sensor = "gyro: {type: rate, body: core";
  text.insert(text.find(sensor) + sensor.size(), ", errors: {" + errors + "}");
  return hil::load_scenario_text(text, "test.yaml");
}

TEST(SensorErrors, UnitsOfDataSheetsAreRead) {
  constexpr double kDegree = std::numbers::pi / 180;
  const hil::Scenario scenario = load(
      "noise_density: 0.05 deg/√h, walk: 0.3 deg/h/√h, bias: 2 deg/h, drift: 0.5 deg/h, noise: 1e-3, "
      "quantum: 10 mrad/s, scale: 300e-6");
  ASSERT_EQ(scenario.rates.errors.sensors.size(), 1u);
  const hil::SensorErrors& own = scenario.rates.errors.sensors[0];
  EXPECT_DOUBLE_EQ(own.noise_density, 0.05 * kDegree / 60);
  EXPECT_DOUBLE_EQ(own.walk, 0.3 * kDegree / 3600 / 60);
  EXPECT_DOUBLE_EQ(own.bias.at(2), 2 * kDegree / 3600);
  EXPECT_DOUBLE_EQ(own.drift, 0.5 * kDegree / 3600);
  EXPECT_DOUBLE_EQ(own.noise, 1e-3);
  EXPECT_DOUBLE_EQ(own.quantum, 0.01);
  EXPECT_EQ(scenario.rates.errors.dt, 0.001);
  EXPECT_DOUBLE_EQ(load("noise_density: 0.05 deg/sqrt(h)").rates.errors.sensors[0].noise_density, 0.05 * kDegree / 60);
  EXPECT_DOUBLE_EQ(load("noise_density: 0.01 deg/s/√Hz").rates.errors.sensors[0].noise_density, 0.01 * kDegree);
}

TEST(SensorErrors, OtherUnitsOfDataSheetsAreRead) {
  constexpr double kDegree = std::numbers::pi / 180;
  const hil::SensorErrors own = load(
                                    "noise: 30 mdps, noise_density: 4 mdps/√Hz, drift: 1 deg/hr, scale: 300 ppm, "
                                    "walk: 0.3 deg/hr/√hr, bias: [10 mdps, 0.1 dps, 0], "
                                    "misalignment: [20 arcsec, -3 arcmin, 0.1 mrad], quantum: 36 arcsec/s")
                                    .rates.errors.sensors.at(0);
  EXPECT_DOUBLE_EQ(own.noise, 0.03 * kDegree);
  EXPECT_DOUBLE_EQ(own.noise_density, 0.004 * kDegree);
  EXPECT_DOUBLE_EQ(own.drift, kDegree / 3600);
  EXPECT_DOUBLE_EQ(own.scale, 300e-6);
  EXPECT_DOUBLE_EQ(own.walk, 0.3 * kDegree / 3600 / 60);
  EXPECT_DOUBLE_EQ(own.bias.at(0), 0.01 * kDegree);
  EXPECT_DOUBLE_EQ(own.bias.at(1), 0.1 * kDegree);
  EXPECT_DOUBLE_EQ(own.misalignment.x(), 20 * kDegree / 3600);
  EXPECT_DOUBLE_EQ(own.misalignment.y(), -3 * kDegree / 60);
  EXPECT_DOUBLE_EQ(own.misalignment.z(), 1e-4);
  EXPECT_DOUBLE_EQ(own.quantum, 0.01 * kDegree);
}

TEST(SensorErrors, ThousandthsOfGravityAreRead) {
  constexpr double kGravity = 9.80665;
  std::string text = kGoodScenario;
  const std::string sensor = "  gyro: {type: rate, body: core}\n";
  text.insert(text.find(sensor),
              "  accelerometer: {type: specific_force, body: core, errors: {noise_density: 50 µg/√Hz, bias: 15 µg, "
              "noise: 1.5 mg, quantum: 2*μg, drift: 3ug}}\n");
  const hil::SensorErrors own = hil::load_scenario_text(text, "test.yaml").rates.errors.sensors.at(0);
  EXPECT_DOUBLE_EQ(own.noise_density, 50e-6 * kGravity);
  EXPECT_DOUBLE_EQ(own.bias.at(0), 15e-6 * kGravity);
  EXPECT_DOUBLE_EQ(own.noise, 1.5e-3 * kGravity);
  EXPECT_DOUBLE_EQ(own.quantum, 2e-6 * kGravity);
  EXPECT_DOUBLE_EQ(own.drift, 3e-6 * kGravity);
}

TEST(SensorErrors, ADelayIsANumberOfSamplesOrATimeThatIsOne) {
  EXPECT_EQ(load("delay: 3").rates.errors.sensors[0].delay, 3);
  EXPECT_EQ(load("delay: 3 ms").rates.errors.sensors[0].delay, 3);  // of 1 ms each, without a group
  const std::string groups = "timing: {groups: {slow: {period: 20 ms, sensors: [gyro]}}}\n";
  const auto load_slow = [&](const std::string& delay) {
    std::string text = kGoodScenario + groups;
    const std::string sensor = "gyro: {type: rate, body: core";
    text.insert(text.find(sensor) + sensor.size(), ", errors: {delay: " + delay + "}");
    return load_errors(text);
  };
  EXPECT_EQ(load_slow("60 ms"), "");
  EXPECT_THAT(load_slow("50 ms"),
              testing::AllOf(testing::HasSubstr("a delay of 2.5 samples"), testing::HasSubstr("0.04 s or 0.06 s")));
  EXPECT_THAT(load_slow("1.5"), testing::HasSubstr("1 or 2, or a group with a shorter period"));
  EXPECT_THAT(load_slow("1 m"), testing::HasSubstr("or a time: 2, 20 ms"));
  EXPECT_THAT(load_slow("-1"), testing::HasSubstr("a whole number from 0 to 1000"));
  EXPECT_THAT(load_slow("100 s"), testing::AllOf(testing::HasSubstr("a delay of 5000 samples"),
                                                 testing::HasSubstr("from 0 to 20 s: at most 1000 samples of 0.02 s")));
}

TEST(SensorErrors, AQuantumBeyondTheRangeIsRefused) {
  EXPECT_THROW(load("quantum: 20 deg/s, range: 5 deg/s"), hil::ScenarioError);
  EXPECT_NO_THROW(load("quantum: 5 deg/s, range: 5 deg/s"));
  try {
    load("quantum: 20 deg/s, range: 5 deg/s");
  } catch (const hil::ScenarioError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("'20 deg/s' is greater than the range '5 deg/s'"));
  }
}

// With sizes within the bounds of the language what is sent stays finite.
TEST(SensorErrors, SizesThatOverflowAreRefused) {
  for (const char* const wrong : {"noise: 1e308", "scale: 1e308", "bias: 1e31", "bias: [0, -1e31, 0]", "walk: 1e200",
                                  "misalignment: [0, 4, 0]", "drift: 1e99", "quantum: 1e31", "noise_density: 1e40"})
    EXPECT_THROW(load(wrong), hil::ScenarioError) << wrong;
  const hil::Scenario scenario = load("noise: 1e30, bias: -1e30, walk: 1e30, drift: 1e30, scale: 1e6, turn_on: 1e30");
  const Model model = build_model();
  hil::Rates rates = with_errors(scenario.rates.errors.sensors[0]);
  hil::SampleAndHold held(model, rates, {}, kTruth);
  for (std::int64_t tick = 1; tick <= 1000; ++tick) {
    held.sample(tick, kTruth);
    for (const double value : held.get_sensors()) ASSERT_TRUE(std::isfinite(value)) << tick;
  }
}

TEST(SensorErrors, SizesOfAnotherDimensionAreRefused) {
  for (const char* const wrong : {"noise: 5 µg", "noise_density: 0.05 deg/h", "noise_density: 0.05 deg/√h/√h",
                                  "noise: -1", "dropout: 1.5", "delay: 0.5", "bias: [1, 2]", "walk: 1 deg/√h"})
    EXPECT_THROW(load(wrong), hil::ScenarioError) << wrong;
}

}  // namespace
}  // namespace unlatch::test::sensor_errors_test
