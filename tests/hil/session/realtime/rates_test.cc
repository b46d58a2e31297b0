// Sub-rates: held values, their update, and the same in a replay.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hil/run/simulation/model_messages.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::rates_test {
namespace {

using hil::Pace;
using hil::RunStatus;

const std::vector<std::string> kRates{
    "flight_software.timeout=30",
    "timing={states: {every: 5, phase: 2}, groups: {nav: {every: 4, sensors: [gyro]}, "
    "drive: {period: 10 ms, phase: 3, elements: [engine]}}}"};

hil::Scenario load(const std::vector<std::string>& overrides) {
  return hil::load_scenario_text(kSessionScenario, "session.yaml", overrides);
}

std::string describe_mistakes(const std::string& timing) {
  try {
    load({"timing=" + timing});
  } catch (const hil::ScenarioError& error) {
    return error.what();
  }
  return "none";
}

TEST(Rates, SensorsAreHeldBetweenTheirSamples) {
  const hil::Scenario scenario = load({kRates[1]});
  const auto simulation = hil::build_simulation(scenario);
  double held = 0;
  bool moved = false;
  for (int tick = 0; tick <= 20; ++tick) {
    hil::StateMessage state;
    hil::fill_state(*simulation, 0, 1'000'000, state);
    if (tick % 4 == 0) held = simulation->workspace().sensors[2];
    EXPECT_EQ(state.sensors[2], held) << "tick " << tick;
    moved = moved || state.sensors[2] != simulation->workspace().sensors[2];
    ASSERT_EQ(simulation->step().status, StepStatus::kOk);
  }
  EXPECT_TRUE(moved) << "the rate changes, or this shows nothing";
}

TEST(Rates, ChannelsAreLatchedAtTheirTicks) {
  const auto held = hil::build_simulation(load({kRates[1]}));
  const auto direct = hil::build_simulation(load({}));
  for (int tick = 0; tick < 30; ++tick) {
    held->channels()[0] = 0.2 + 0.01 * tick;  // commanded anew at every tick
    const int latched = (tick - 3) / 10 * 10 + 3;
    direct->channels()[0] = tick < 3 ? 0.5 : 0.2 + 0.01 * latched;
    ASSERT_EQ(held->step().status, StepStatus::kOk);
    ASSERT_EQ(direct->step().status, StepStatus::kOk);
    EXPECT_EQ(held->calc_hash(), direct->calc_hash()) << "tick " << tick;
  }
}

TEST(Rates, StatesAreSentAndAnsweredAtTheirTicksOnlyAndItReplays) {
  for (const Pace pace : {Pace::kLockstep, Pace::kRealtime}) {
    const std::string log = make_path("log");
    std::vector<std::int64_t> heard;
    FakeParticipant::Habits habits;
    habits.mischief = [&heard](std::int64_t tick, hil::RingConnection&, std::int64_t) { heard.push_back(tick); };
    const SessionResult result = run_session(pace, habits, log, kRates);
    EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
    if (pace == Pace::kLockstep) {
      EXPECT_THAT(heard, testing::ElementsAre(0, 2, 7, 12, 17, 22, 27, 32, 37, 42, 47, 50));
      EXPECT_EQ(result.end.timing.round_trip.count, 11);
    }
    const ReplayedLog replayed = replay_log(log);
    EXPECT_TRUE(replayed.result.agrees());
    EXPECT_EQ(replayed.result.compared, 51);
  }
}

TEST(Rates, MakeADifferenceAndAreTheSameEveryTime) {
  const auto hash = [](const std::vector<std::string>& overrides) {
    return run_session(Pace::kLockstep, {}, "", overrides).end.hash;
  };
  EXPECT_EQ(hash(kRates), hash(kRates));
  EXPECT_NE(hash(kRates), hash({kRates[0]}));
}

TEST(Rates, MistakesHaveTheirPlaceAndRemedy) {
  using testing::HasSubstr;
  EXPECT_EQ(describe_mistakes("{states: {every: 1}}"), "none");
  EXPECT_EQ(describe_mistakes("{overruns: {catch_up: 3}, spin: 50 us, watchdog: {limit: 1, action: abort}}"), "none");
  EXPECT_THAT(describe_mistakes("{overruns: explode}"), HasSubstr("skip_output"));
  EXPECT_THAT(describe_mistakes("{overruns: {catch_up: 0}}"), HasSubstr("a whole number from 1 to 1000000000"));
  EXPECT_THAT(describe_mistakes("{spin: 1}"), HasSubstr("at least 0, at most 0.01 s"));
  EXPECT_THAT(describe_mistakes("{watchdog: -1}"), HasSubstr("at least 0, at most 3600 s"));
  EXPECT_THAT(describe_mistakes("{states: {every: 2.5}}"), HasSubstr("a whole number from 1 to 1000000000"));
  EXPECT_THAT(describe_mistakes("{states: {every: 5, phase: 5}}"), HasSubstr("below the rate's own"));
  EXPECT_THAT(describe_mistakes("{states: {period: 1.5 ms}}"), HasSubstr("a multiple of step.dt"));
  EXPECT_THAT(describe_mistakes("{groups: {a: {every: 2, sensors: [giro]}}}"), HasSubstr("did you mean 'gyro'"));
  EXPECT_THAT(describe_mistakes("{groups: {a: {every: 2, sensors: [gyro]}, b: {every: 3, sensors: [gyro]}}}"),
              HasSubstr("is in group 'a' already"));
  EXPECT_THAT(describe_mistakes("{groups: {a: {every: 2, elements: [jet]}, b: {every: 3, elements: [jet]}}}"),
              HasSubstr("channel 'trim' drives elements of the groups 'a' and 'b'"));
}

}  // namespace
}  // namespace unlatch::test::rates_test
