// Fault scripts: injected faults are the same every time, are recorded, and replay.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hil/session/faults/fault_injector.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::fault_test {
namespace {

using hil::Pace;
using hil::RunStatus;
using ::testing::HasSubstr;
using Habits = FakeParticipant::Habits;

constexpr const char* kPatient = "flight_software.timeout=10";
constexpr const char* kHalfSecond = "flight_software.timeout=0.5";

hil::FaultScript read_faults(const std::string& list) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  return hil::load_faults_text("unlatch_faults: 1\nseed: 7\nfaults:\n" + list, "faults.yaml", scenario);
}

struct FaultyResult {
  SessionResult session;
  std::int64_t befallen = 0;
};

FaultyResult run_faulty(const std::string& list, const std::vector<std::string>& overrides = {kPatient},
                        const std::string& log = "", std::uint64_t seed = 7, const Habits& habits = {}) {
  hil::FaultScript script = read_faults(list);
  script.seed = seed;
  hil::FaultInjector faults(script);
  FaultyResult result{run_session(Pace::kLockstep, habits, log, overrides, true, nullptr, &faults)};
  for (const auto& tally : faults.list_tallies()) result.befallen += tally.count;
  return result;
}

std::int64_t get_reference_hash() {
  static const std::int64_t hash = run_session(Pace::kLockstep, {}).end.hash;
  return hash;
}

// Lockstep is unaffected: a lost message is sent again, a repeated one counts once.
TEST(Faults, LossesLeaveALockstepAsItIs) {
  for (const char* const list :
       {"  - {drop: {message: State}, probability: 0.2}\n", "  - {drop: {message: StepAck}, probability: 0.2}\n",
        "  - {drop: {message: Command, participant: fsw}, probability: 0.5}\n",
        "  - {drop: {message: HelloAck}, count: 2}\n", "  - {drop: {message: State}, ticks: 20}\n",
        "  - {duplicate: {message: Command, copies: 3}}\n", "  - {duplicate: {message: State}, probability: 0.5}\n",
        "  - {reorder: {message: Command}}\n", "  - {reorder: {message: StepAck}, probability: 0.3}\n",
        "  - {delay: {message: Command, time: 3 ms}, probability: 0.5}\n",
        "  - {delay: {message: State, time: 2 ms}, ticks: [10, 20]}\n"}) {
    const FaultyResult result = run_faulty(list);
    EXPECT_EQ(result.session.end.status, RunStatus::kDone) << list << result.session.end.message;
    EXPECT_EQ(result.session.end.hash, get_reference_hash()) << list;
    EXPECT_GT(result.befallen, 0) << list;
  }
}

TEST(Faults, CorruptionIsReproducible) {
  const std::string list = "  - {corrupt: {message: Command, bits: 3}, probability: 0.7}\n";
  const std::string log = make_path("log");
  const FaultyResult first = run_faulty(list, {kPatient}, log), again = run_faulty(list);
  EXPECT_EQ(first.session.end.status, RunStatus::kDone) << first.session.end.message;
  EXPECT_GT(first.befallen, 0);
  EXPECT_EQ(first.session.end.hash, again.session.end.hash);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST(Faults, CorruptBytesAreCountedAsMalformed) {
  const FaultyResult result = run_faulty("  - {corrupt: {message: Command, bits: 64}, ticks: 30, count: 3}\n");
  EXPECT_EQ(result.session.end.hash, get_reference_hash());
  EXPECT_EQ(result.befallen, 3);
  EXPECT_EQ(result.session.end.timing.rejected[static_cast<std::size_t>(hil::Reject::kMalformed)], 3);
}

TEST(Faults, AFrozenParticipantMeetsThePolicyAndComesBackAtItsTick) {
  const std::string list = "  - {freeze: fsw, ticks: [12, 31]}\n";
  const std::string log = make_path("log");
  const std::vector<std::string> overrides{kHalfSecond};
  const FaultyResult first = run_faulty(list, overrides, log), again = run_faulty(list, overrides);
  EXPECT_EQ(first.session.notices, (std::vector<std::string>{"participant.joined", "fault.freeze", "policy.hold",
                                                             "fault.freeze.end", "participant.resumed"}));
  EXPECT_EQ(first.session.end.status, RunStatus::kDone);
  EXPECT_DOUBLE_EQ(first.session.channels[0], 0.5 + 0.005 * 40);  // commanded at tick 40 again
  EXPECT_NE(first.session.end.hash, get_reference_hash());
  EXPECT_EQ(first.session.end.hash, again.session.end.hash);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST(Faults, AFreezeOfSomeWallTimeEndsAPause) {
  const FaultyResult result = run_faulty("  - {freeze: {participant: fsw, time: 300 ms}, ticks: [12, end]}\n",
                                         {"flight_software.policy=pause"});
  EXPECT_EQ(result.session.end.status, RunStatus::kDone) << result.session.end.message;
  EXPECT_EQ(result.session.end.hash, get_reference_hash());
}

TEST(Faults, AKilledParticipantIsNotHeardAgain) {
  const FaultyResult result = run_faulty("  - {kill: fsw, ticks: 12}\n", {kHalfSecond});
  EXPECT_EQ(result.session.notices, (std::vector<std::string>{"participant.joined", "fault.kill", "policy.hold"}));
  EXPECT_DOUBLE_EQ(result.session.channels[0], 0.55);  // command of tick 10
  Habits habits;
  habits.dies_at = 12;
  EXPECT_EQ(result.session.end.hash, run_session(Pace::kLockstep, habits, "", {kHalfSecond}).end.hash);
}

TEST(Faults, DeadAndJammedActuatorsObeyNobodyAndReplay) {
  const std::string log = make_path("log");
  const FaultyResult result =
      run_faulty("  - {dead: throttle, ticks: [5, 44]}\n  - {jam: trim, ticks: [20, end]}\n", {kPatient}, log);
  EXPECT_EQ(result.session.end.status, RunStatus::kDone);
  EXPECT_DOUBLE_EQ(result.session.channels[0], 0.5 + 0.005 * 40);  // command during its absence
  EXPECT_DOUBLE_EQ(result.session.channels[1], -0.15);             // command of tick 15
  hil::RecordingReader recording{hil::LogFileReader(log)};
  hil::LogTick tick;
  std::vector<std::pair<std::int64_t, double>> forced;
  while (recording.next(tick)) {
    for (const hil::LogChange& change : tick.changes) {
      if (change.cause == hil::ChangeCause::kFault) forced.emplace_back(tick.tick, change.value);
    }
  }
  EXPECT_EQ(forced, (std::vector<std::pair<std::int64_t, double>>{{5, 0.0}, {45, 0.7}}));
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST(Faults, SensorsStickAtTheirFirstValueAndAreBiased) {
  hil::FaultInjector faults(read_faults("  - {stick: gyro.x, ticks: [3, 5]}\n  - {bias: {sensor: gyro, by: 0.5}}\n"));
  hil::Participants participants({});
  for (std::int64_t tick = 0; tick < 8; ++tick) {
    faults.begin_tick(tick, 0, participants, [](hil::Participant&) {});
    hil::StateMessage state;
    state.sensor_count = 3;
    state.sensors[0] = state.sensors[1] = state.sensors[2] = static_cast<double>(tick);
    faults.distort(state);
    EXPECT_EQ(state.sensors[0], (tick >= 3 && tick <= 5 ? 3.0 : static_cast<double>(tick)) + 0.5) << tick;
    EXPECT_EQ(state.sensors[2], static_cast<double>(tick) + 0.5);
  }
}

// Mistakes, each with parts of its message: place, fault, and correction.
TEST(FaultScript, MistakesHaveTheirPlace) {
  const std::pair<const char*, const char*> kMistakes[] = {
      {"  - {drop: {message: Stat}}\n", "faults.yaml:4:22: unknown message 'Stat'; did you mean 'State'?"},
      {"  - {drop: {message: State, participant: fsw}}\n", "leave `participant` out"},
      {"  - {drop: {message: State}, probability: 1.5}\n", "more than 0, at most 1"},
      {"  - {drop: {message: State}, ticks: [5, 3]}\n", "write the earlier one first"},
      {"  - {drop: {message: State}, ticks: 1.5}\n", "a whole number from 0"},
      {"  - {drop: {message: State}, freeze: fsw}\n", "has both drop and freeze"},
      {"  - {ticks: 5}\n", "to say what happens"},
      {"  - {delay: {message: State}}\n", "by how much"},
      {"  - {freeze: guidance}\n", "unknown required participant 'guidance'"},
      {"  - {stick: giro}\n", "unknown sensor 'giro'; known: gyro.x"},
      {"  - {dead: throtle}\n", "unknown channel 'throtle'; did you mean 'throttle'?"},
      {"  - {corrupt: {message: State, bits: 0}}\n", "a whole number from 1 to 64"},
      {"  - {stick: gyro.x, probability: 0.5}\n", "unknown key 'probability'"},
  };
  for (const auto& [list, said] : kMistakes) {
    try {
      read_faults(list);
      ADD_FAILURE() << "accepted: " << list;
    } catch (const hil::ScenarioError& error) {
      EXPECT_THAT(error.what(), HasSubstr(said)) << list;
      EXPECT_THAT(error.what(), HasSubstr("faults.yaml:4:")) << list;
    }
  }
}

}  // namespace
}  // namespace unlatch::test::fault_test
